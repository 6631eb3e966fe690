"""The sandbox that separates a plug-in from the files and processes of the run, by the best means that the kernel offers.

SECURITY.md says what each of the four kinds guarantees. A worker has its own home, cache and temporary folder as well.

Namespaces use three processes, keeper, init and plug-in. The keeper creates a user namespace, in which it may create the others
without privileges outside; a mount namespace, in which the protected folders and the kernel's settings are read-only, and the
folders above them cannot be moved, because each is a mount point; and a PID namespace, in which the kernel kills all processes
when its first one, init, ends. The keeper ends with the status of the plug-in's process, and init ends with the keeper.

Landlock (Linux 5.13) grants rights beneath folders and refuses them elsewhere, permanently and for all descendants. Writing is
allowed in all that neither is nor contains a protected folder, so that nothing can be created beside one.

See the manual pages user_namespaces(7), pid_namespaces(7), mount_setattr(2), and https://docs.kernel.org/userspace-api/landlock.html.
"""

import ctypes
import os
import resource
import signal
import site
import sys
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path

from numba.core import caching, config

from frictionbench.harness.plans.plan import Plugin
from frictionbench.harness.process import checked, die_with_parent, forbid_new_privileges, hide_memory, libc
from frictionbench.problems.compiled import PACKAGE
from frictionbench.solvers.plugins import files

NAMESPACES, LANDLOCK, FILES_ONLY, GROUPS = "namespaces", "landlock", "landlock, files only", "process groups"
MOST_FILE = 2**30  # largest file in bytes: an answer takes far less
CREATE_RULESET, ADD_RULE, RESTRICT_SELF = 444, 445, 446  # system calls of Landlock
VERSION, PATH_BENEATH = 1, 1  # the flag that asks for the interface's version; the type of rule
WRITE_FILE, TRUNCATE = 1 << 1, 1 << 14
FOLDER_RIGHTS = sum(1 << bit for bit in range(4, 14))  # to remove files, create files of each type, and move between folders
TRUNCATES, SCOPES = 3, 6  # the first versions that restrict truncation, and signals and abstract sockets
SCOPED = 3
NEW_MOUNTS, NEW_SHARED_MEMORY, NEW_USERS, NEW_PROCESSES = 0x00020000, 0x08000000, 0x10000000, 0x20000000  # linux/sched.h
BIND, RECURSIVE, PRIVATE = 0x1000, 0x4000, 1 << 18  # linux/mount.h
MOUNT_SETATTR, AT_FDCWD, AT_RECURSIVE, READ_ONLY = 442, -100, 0x8000, 1
SHARED_MEMORY = Path("/dev/shm")
SETTINGS = Path("/proc/sys")  # the kernel's; root executes the program named in core_pattern
CAPABILITIES = 0x20080522  # version 3 of the structures of capset(2)


def best() -> str:
    """Return the best sandbox on this machine. Namespaces are tried in a separate process."""
    pid = os.fork()
    if pid == 0:
        try:
            _enter_namespaces([Path(sys.prefix).resolve()], [Path(config.CACHE_DIR)])
        except OSError:
            os._exit(1)
        os._exit(0)
    if os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]) == 0:
        return NAMESPACES
    version = landlock_version()
    return LANDLOCK if version >= SCOPES else FILES_ONLY if version else GROUPS


def use_scratch(scratch: Path, kernels: Path) -> None:
    """Give this process and its children another home, cache and folder of kernels, and bound the size of their files."""
    os.environ["PYTHONUSERBASE"] = site.getuserbase()
    os.environ["HOME"] = os.environ["XDG_CACHE_HOME"] = str(scratch)
    os.environ["NUMBA_CACHE_DIR"] = config.CACHE_DIR = str(kernels)  # both, since numba may read its variables again
    _, most = resource.getrlimit(resource.RLIMIT_FSIZE)
    bound = MOST_FILE if most == resource.RLIM_INFINITY else min(MOST_FILE, most)
    resource.setrlimit(resource.RLIMIT_FSIZE, (bound, bound))


def confine(sandbox: str, folder: Path, plugins: Iterable[Plugin], *writable: Path) -> None:
    """Confine the calling process before it runs a plug-in's code. With namespaces, the call returns in another process.

    writable: folders to which it may write; the folders of other workers are beside them. Errors: OSError.
    """
    if sandbox == GROUPS:
        return
    caches = Path(config.CACHE_DIR).parent
    named = [file for plugin in plugins for file in files(plugin.source)]
    code: list[str | Path] = [PACKAGE.parent, sys.prefix, sys.base_prefix, site.getusersitepackages(), *filter(None, sys.path)]
    others = [path.parent for path in writable]
    places = [folder, folder / "problems", caches, *others, *map(Path, code), *named]
    resolved = {path.resolve() for path in places if path.exists()}
    protected = sorted(path for path in resolved if resolved.isdisjoint(path.parents))  # without those inside another one
    (_enter_namespaces if sandbox == NAMESPACES else _restrict)(protected, [path.resolve() for path in writable])


def tolerate_unusable_caches() -> None:
    """Make numba compile, instead of raising, where the cache is read-only, on a full disk, or damaged by a power cut."""
    load, save = caching.Cache.load_overload, caching.Cache.save_overload

    def loaded(self: caching.Cache, *wanted: object) -> object:
        with suppress(Exception):
            return load(self, *wanted)
        with suppress(OSError):
            self.flush()
        return None

    def saved(self: caching.Cache, *compiled: object) -> None:
        with suppress(OSError):
            save(self, *compiled)

    caching.Cache.load_overload, caching.Cache.save_overload = loaded, saved


class _Ruleset(ctypes.Structure):
    _fields_ = (("files", ctypes.c_uint64), ("network", ctypes.c_uint64), ("scoped", ctypes.c_uint64))


class _Beneath(ctypes.Structure):
    _pack_ = 1
    _fields_ = (("rights", ctypes.c_uint64), ("folder", ctypes.c_int32))


def landlock_version() -> int:
    """Return the version of Landlock's interface; 0 if the kernel has none, or one that does not restrict truncation."""
    version = int(libc.syscall(CREATE_RULESET, None, 0, VERSION))
    return version if version >= TRUNCATES else 0


def _restrict(protected: Sequence[Path], writable: Sequence[Path]) -> None:
    """Give up the rights to write to protected folders, except writable ones, and from version 6 on to signal other processes.

    Errors: OSError.
    """
    scopes = landlock_version() >= SCOPES
    rules = _Ruleset(WRITE_FILE | TRUNCATE | FOLDER_RIGHTS, 0, SCOPED if scopes else 0)
    size = ctypes.sizeof(rules) if scopes else ctypes.sizeof(ctypes.c_uint64)
    ruleset = checked("landlock_create_ruleset", libc.syscall(CREATE_RULESET, ctypes.byref(rules), size, 0))
    try:
        for path in (*_beside(protected), *writable):
            _grant(ruleset, path)
        forbid_new_privileges()
        checked("landlock_restrict_self", libc.syscall(RESTRICT_SELF, ruleset, 0))
    finally:
        os.close(ruleset)


def _beside(protected: Sequence[Path]) -> list[Path]:
    """Return the topmost files and folders, without links, that neither are protected nor contain anything protected."""
    above = {parent for path in protected for parent in path.parents}
    topmost: list[Path] = []
    for folder in above:
        with suppress(PermissionError):
            topmost += [path for path in folder.iterdir() if path not in above and not path.is_symlink()]
    return [path for path in topmost if path not in protected]


def _grant(ruleset: int, path: Path) -> None:
    try:
        opened = os.open(path, os.O_PATH | os.O_NOFOLLOW | os.O_CLOEXEC)
    except (FileNotFoundError, PermissionError):  # a temporary file that is gone, or a path without the right to write
        return
    try:
        rights = WRITE_FILE | TRUNCATE | (FOLDER_RIGHTS if path.is_dir() else 0)
        rule = _Beneath(rights, opened)
        checked("landlock_add_rule", libc.syscall(ADD_RULE, ruleset, PATH_BENEATH, ctypes.byref(rule), 0))
    finally:
        os.close(opened)


class _Attributes(ctypes.Structure):
    _fields_ = tuple((name, ctypes.c_uint64) for name in ("set", "clear", "propagation", "users"))


def _enter_namespaces(protected: Sequence[Path], writable: Sequence[Path]) -> None:
    """Return in a new process in new namespaces, where the protected folders are read-only except for `writable`.

    The calling process becomes the keeper and does not return. Errors: OSError, in the calling process or in the new one.
    """
    user, group = os.getuid(), os.getgid()
    checked("unshare", libc.unshare(NEW_USERS | NEW_MOUNTS | NEW_SHARED_MEMORY | NEW_PROCESSES))
    for name, line in (("setgroups", "deny"), ("uid_map", f"{user} {user} 1"), ("gid_map", f"{group} {group} 1")):
        with open(f"/proc/self/{name}", "w", encoding="ascii") as mapping:
            mapping.write(line)
    _mount(None, Path("/"), PRIVATE | RECURSIVE)
    for above in sorted({above for path in protected for above in path.parents} - {Path("/")}):
        _mount(above, above, BIND | RECURSIVE)  # a mount point cannot be moved
    for path in (*protected, Path("/sys")):
        _mount(path, path, BIND | RECURSIVE)
        _set_attributes(path, _Attributes(set=READ_ONLY))
    for path in writable:
        _mount(path, path, BIND)
        _set_attributes(path, _Attributes(clear=READ_ONLY))
    used = any(path.is_relative_to(SHARED_MEMORY) for path in (*protected, *writable, Path.cwd()))
    if SHARED_MEMORY.is_dir() and not used:
        _mount(Path("tmpfs"), SHARED_MEMORY, 0, kind=b"tmpfs")  # its files end with the worker
    os.chdir(os.getcwd())  # into the new mounts: through the old ones everything could be written to
    status_end, status_writer = os.pipe()
    if os.fork():
        _close_others(status_end)
        status = os.read(status_end, 4)
        _end_as(int.from_bytes(status, "little") if status else 1 << 8)  # no status: init could not start the process
    die_with_parent(0)
    os.close(status_end)
    _mount(Path("proc"), Path("/proc"), 0, kind=b"proc")
    _mount(SETTINGS, SETTINGS, BIND)
    _set_attributes(SETTINGS, _Attributes(set=READ_ONLY))
    if process := os.fork():
        hide_memory()
        _close_others(status_writer)
        _be_init(process, status_writer)
    os.close(status_writer)
    _drop_capabilities()


def _be_init(process: int, status_writer: int) -> None:
    """Wait for orphans and for the process, and report its status. When init ends, the kernel kills all others."""
    try:
        while True:
            pid, status = os.wait()
            if pid == process:
                os.write(status_writer, status.to_bytes(4, "little"))
                break
    finally:
        os._exit(0)


def _end_as(status: int) -> None:
    """End with the exit code or the signal that the status gives."""
    code = os.waitstatus_to_exitcode(status)
    if code < 0:
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        signal.pthread_sigmask(signal.SIG_SETMASK, ())
        if -code not in (signal.SIGKILL, signal.SIGSTOP):
            signal.signal(-code, signal.SIG_DFL)
        os.kill(os.getpid(), -code)
    os._exit(max(code, 0))


def _close_others(kept: int) -> None:
    """Close all descriptors but one, so that readers of the plug-in's pipes see them closed when the plug-in closes them."""
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
    """Give up all rights in the namespaces, including those of programs executed later."""
    forbid_new_privileges()
    header, none = (ctypes.c_uint32 * 2)(CAPABILITIES, 0), (ctypes.c_uint32 * 6)()
    checked("capset", libc.capset(header, none))
