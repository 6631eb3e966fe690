"""Landlock: a process gives up writing to some folders, and signalling processes outside, for good; so do its descendants.

Landlock (Linux 5.13) grants rights beneath folders and refuses them everywhere else. To protect folders, the rights to write
are granted to all that neither is nor holds one of them. In the folders that hold a protected one nothing can be created.

See https://docs.kernel.org/userspace-api/landlock.html.
"""

import ctypes
import os
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from frictionbench.harness.process import checked, forbid_new_privileges, libc

CREATE_RULESET, ADD_RULE, RESTRICT_SELF = 444, 445, 446  # system calls
VERSION, PATH_BENEATH = 1, 1  # asks for the version of the interface; the kind of rule
WRITE_FILE, TRUNCATE = 1 << 1, 1 << 14
FOLDER_RIGHTS = sum(1 << bit for bit in range(4, 14))  # to remove, to make each kind of file, and to move between folders
TRUNCATES, SCOPES = 3, 6  # the first versions that bound truncating, and signals and abstract sockets
SCOPED = 3


class _Ruleset(ctypes.Structure):
    _fields_ = (("files", ctypes.c_uint64), ("network", ctypes.c_uint64), ("scoped", ctypes.c_uint64))


class _Beneath(ctypes.Structure):
    _pack_ = 1
    _fields_ = (("rights", ctypes.c_uint64), ("folder", ctypes.c_int32))


def version() -> int:
    """The version of Landlock's interface; 0 where the kernel has none, or one that does not bound truncating."""
    found = int(libc.syscall(CREATE_RULESET, None, 0, VERSION))
    return found if found >= TRUNCATES else 0


def protect(protected: Sequence[Path], writable: Path) -> None:
    """Give up writing to the protected folders, except for the folder writable, and, from version 6 on, signalling others.

    Errors: OSError.
    """
    scopes = version() >= SCOPES
    rules = _Ruleset(WRITE_FILE | TRUNCATE | FOLDER_RIGHTS, 0, SCOPED if scopes else 0)
    size = ctypes.sizeof(rules) if scopes else ctypes.sizeof(ctypes.c_uint64)
    ruleset = checked("landlock_create_ruleset", libc.syscall(CREATE_RULESET, ctypes.byref(rules), size, 0))
    try:
        for path in (*_beside(protected), writable):
            _grant(ruleset, path)
        forbid_new_privileges()
        checked("landlock_restrict_self", libc.syscall(RESTRICT_SELF, ruleset, 0))
    finally:
        os.close(ruleset)


def _beside(protected: Sequence[Path]) -> list[Path]:
    """The largest files and folders, without links, that neither are protected nor hold anything protected."""
    above = {parent for path in protected for parent in path.parents}
    found: list[Path] = []
    for folder in above:
        with suppress(PermissionError):
            found += [path for path in folder.iterdir() if path not in above and not path.is_symlink()]
    return [path for path in found if path not in protected]


def _grant(ruleset: int, path: Path) -> None:
    try:
        opened = os.open(path, os.O_PATH | os.O_NOFOLLOW | os.O_CLOEXEC)
    except (FileNotFoundError, PermissionError):  # a temporary file that has gone, or nothing to which it could write
        return
    try:
        rights = WRITE_FILE | TRUNCATE | (FOLDER_RIGHTS if path.is_dir() else 0)
        rule = _Beneath(rights, opened)
        checked("landlock_add_rule", libc.syscall(ADD_RULE, ruleset, PATH_BENEATH, ctypes.byref(rule), 0))
    finally:
        os.close(opened)
