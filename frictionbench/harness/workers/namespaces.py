"""Namespaces: a process that sees and can signal no process but its descendants, and cannot write to some folders.

    keeper  ─  init  ─  the process

The keeper makes a user namespace, in which it may do what follows without privileges outside; a mount namespace, in which the
protected folders are read-only; and a namespace of processes, whose first process is init. When init ends the kernel kills all
processes of the namespace, however they were detached. The keeper ends as the process ended, and init when the keeper does.

See the manual pages user_namespaces(7), pid_namespaces(7) and mount_setattr(2).
"""

import ctypes
import os
import resource
import signal
from collections.abc import Sequence
from pathlib import Path

from frictionbench.harness.process import checked, die_with_parent, forbid_new_privileges, hide_memory, libc

NEW_MOUNTS, NEW_USERS, NEW_PROCESSES = 0x00020000, 0x10000000, 0x20000000  # linux/sched.h
BIND, RECURSIVE, PRIVATE = 0x1000, 0x4000, 1 << 18  # linux/mount.h
MOUNT_SETATTR, AT_FDCWD, AT_RECURSIVE, READ_ONLY = 442, -100, 0x8000, 1
CAPABILITIES = 0x20080522  # version 3 of the structures of capset(2)


class _Attributes(ctypes.Structure):
    _fields_ = tuple((name, ctypes.c_uint64) for name in ("set", "clear", "propagation", "users"))


def protect(protected: Sequence[Path], writable: Path) -> None:
    """Return in a new process of new namespaces, where only `writable` can be written to beneath the protected folders.

    The calling process becomes its keeper and does not return. Errors: OSError, in the calling process or in the new one.
    """
    user, group = os.getuid(), os.getgid()
    checked("unshare", libc.unshare(NEW_USERS | NEW_MOUNTS | NEW_PROCESSES))
    for name, line in (("setgroups", "deny"), ("uid_map", f"{user} {user} 1"), ("gid_map", f"{group} {group} 1")):
        with open(f"/proc/self/{name}", "w", encoding="ascii") as mapping:
            mapping.write(line)
    _mount(None, Path("/"), PRIVATE | RECURSIVE)
    for path in protected:
        _mount(path, path, BIND | RECURSIVE)
        _set_attributes(path, _Attributes(set=READ_ONLY))
    _mount(writable, writable, BIND)
    _set_attributes(writable, _Attributes(clear=READ_ONLY))
    said, says = os.pipe()
    if os.fork():
        _close_others(said)
        status = os.read(said, 4)
        _end_as(int.from_bytes(status, "little") if status else 1 << 8)  # without a status init could not start the process
    die_with_parent(0)
    os.close(said)
    _mount(Path("proc"), Path("/proc"), 0, kind=b"proc")
    if process := os.fork():
        hide_memory()
        _close_others(says)
        _be_init(process, says)
    os.close(says)
    _drop_capabilities()


def _be_init(process: int, says: int) -> None:
    """Wait for orphans and for the process, and report its status; the end of init ends all others."""
    try:
        while True:
            pid, status = os.wait()
            if pid == process:
                os.write(says, status.to_bytes(4, "little"))
                break
    finally:
        os._exit(0)


def _end_as(status: int) -> None:
    """End as the process ended, with its exit code or by its signal."""
    code = os.waitstatus_to_exitcode(status)
    if code < 0:
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        signal.pthread_sigmask(signal.SIG_SETMASK, ())
        if -code not in (signal.SIGKILL, signal.SIGSTOP):
            signal.signal(-code, signal.SIG_DFL)
        os.kill(os.getpid(), -code)
    os._exit(max(code, 0))


def _close_others(kept: int) -> None:
    """Close all descriptors but one: whoever reads the process's pipes sees them closed when the process closes them."""
    os.closerange(3, kept)
    os.closerange(kept + 1, resource.getrlimit(resource.RLIMIT_NOFILE)[0])


def _mount(source: Path | None, target: Path, flags: int, kind: bytes | None = None) -> None:
    origin = None if source is None else os.fsencode(source)
    checked(f"mount {target}", libc.mount(origin, os.fsencode(target), kind, ctypes.c_ulong(flags), None))


def _set_attributes(path: Path, attributes: _Attributes) -> None:
    size = ctypes.c_size_t(ctypes.sizeof(attributes))
    call = libc.syscall(MOUNT_SETATTR, AT_FDCWD, os.fsencode(path), AT_RECURSIVE, ctypes.byref(attributes), size)
    checked(f"mount_setattr {path}", call)


def _drop_capabilities() -> None:
    """Give up all rights in the namespaces, also for programs that are executed later."""
    forbid_new_privileges()
    header, none = (ctypes.c_uint32 * 2)(CAPABILITIES, 0), (ctypes.c_uint32 * 6)()
    checked("capset", libc.capset(header, none))
