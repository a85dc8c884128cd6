"""Start of the solver's process: it drops its rights irrevocably, then serves the requests of `remote`.

Landlock and namespaces, used by their system calls, work only on a process with one thread. This module therefore
imports nothing of the solver's, and not NumPy, whose libraries start threads.
Numbers are those of ``linux/landlock.h``, ``linux/sched.h``, ``linux/prctl.h`` and ``linux/capability.h``.
"""

import ctypes
import os
import site
import sys
import sysconfig
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import IO, Any

from vbbench.folders.work_folder import TRUTH, WORK, next_to
from vbbench.parallel.stopping import end_with_parent

SYSTEM = (
    *("/lib", "/lib32", "/lib64", "/usr/lib", "/usr/lib32", "/usr/lib64", "/usr/libexec", "/usr/share"),
    *("/usr/local/lib", "/usr/local/lib64", "/usr/local/share", "/usr/local/cuda", "/opt/rocm", "/nix/store"),
    *("/bin", "/usr/bin", "/usr/local/bin", "/usr/include", "/usr/local/include"),
    *("/etc/ld.so.cache", "/etc/ld.so.conf", "/etc/ld.so.conf.d", "/etc/localtime", "/etc/fonts", "/etc/OpenCL"),
    *("/proc/self", "/proc/cpuinfo", "/proc/meminfo", "/proc/stat", "/proc/sys/vm", "/proc/driver/nvidia"),
    *("/sys/devices/system", "/sys/bus/pci", "/sys/class/drm", "/sys/fs/cgroup", "/dev/urandom", "/dev/random"),
)
"""What programs read of a Linux system; missing paths are skipped."""

DEVICES = ("/dev/null", "/dev/zero", "/dev/full", "/dev/dri", "/dev/kfd")
"""Devices that programs write to and that keep nothing, and graphics cards (besides ``/dev/nvidia*``)."""

OF_DATASETS = frozenset(
    [
        *("dataset.json", "submission.json", "seed.json", "pyvenv.cfg"),
        *(f"{table}.{kind}" for table in ("poses", "positions", "given", "scenes") for kind in ("parquet", "csv")),
    ]
)
"""Files that mark a folder as a dataset, its truth, or answers to it; or as a Python environment, which is readable
only if it is in use."""

MOST_ENTRIES = 50_000
"""Entries searched for datasets below a folder of the user's; the rest stays closed."""


def readable_paths(hidden: Sequence[Path], needed: Sequence[Path] = ()) -> list[str]:
    """Readable paths, one for each rule; none contains any of the resolved paths ``hidden``.

    Parameters
    ----------
    needed : readable files and folders in addition to Python's, installed packages' and those of `sys.path`.
    """
    installed = [Path(place).resolve() for place in _installed()]
    roots = [*needed, *(Path(entry or os.curdir).resolve() for entry in sys.path)]
    own = [root for root in roots if not any(root.is_relative_to(place) for place in installed)]
    granted = [path for place in (*map(Path, SYSTEM), *installed) for path in _around(place, hidden)]
    search = _Search(hidden)
    return [str(path) for path in (*granted, *(path for root in own for path in search.open_parts(root)[1]))]


def folders_with(folder: Path) -> list[Path]:
    """The folder, its work folder, and that of its withheld truth."""
    place = folder.resolve()
    return [place, *(next_to(place, ending) for ending in (WORK, TRUTH))]


def device_paths() -> list[str]:
    """Devices that may be read and written in addition to the solver's own folder."""
    return [*DEVICES, *(str(path) for path in Path("/dev").glob("nvidia*"))]


def _installed() -> set[str]:
    """Folders of this Python and of its installed packages."""
    places = {sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib", "scripts")}
    for prefix in (sys.prefix, sys.base_prefix, sys.exec_prefix, sys.base_exec_prefix):
        places |= {f"{prefix}/{name}" for name in ("lib", "lib64", "bin", "share", "pyvenv.cfg")}
    return places | set(site.getsitepackages()) | ({site.getusersitepackages()} if site.ENABLE_USER_SITE else set())


def _around(place: Path, hidden: Iterable[Path]) -> Iterator[Path]:
    """``place``, or its entries that neither are nor contain a ``hidden`` path."""
    place = place if place.is_relative_to("/proc") else place.resolve()
    inside = [path for path in hidden if path.is_relative_to(place)]
    if not inside:
        if place.exists() and not any(place.is_relative_to(path) for path in hidden):
            yield place
    elif place not in inside:
        for entry in _entries(place):
            yield from _around(Path(entry.path), inside)


class _Search:
    """Looks for datasets in the folders of a solver's modules."""

    def __init__(self, hidden: Sequence[Path]) -> None:
        self._hidden, self._left, self._seen = frozenset(hidden), MOST_ENTRIES, set[Path]()

    def open_parts(self, folder: Path) -> tuple[bool, list[Path]]:
        """Whether the whole ``folder`` may be read, and otherwise its readable parts.

        Entries whose name starts with a dot (keys, settings, version control) are not readable.
        """
        if folder in self._seen or any(folder.is_relative_to(path) for path in self._hidden):
            return False, []
        self._seen.add(folder)
        if not folder.is_dir():
            return True, [folder] if folder.is_file() else []
        entries = _entries(folder)
        self._left -= len(entries)
        if self._left < 0 or any(entry.name in OF_DATASETS for entry in entries):
            return False, []
        whole, parts = True, list[Path]()
        for entry in sorted(entries, key=lambda entry: (not entry.is_file(), entry.name)):
            clean, found = self._open_entry(entry)
            whole, parts = whole and clean, [*parts, *found]
        return (True, [folder]) if whole else (False, parts)

    def _open_entry(self, entry: "os.DirEntry[str]") -> tuple[bool, list[Path]]:
        """The same for a folder's entry; links are skipped, since the kernel checks their targets."""
        path = Path(entry.path)
        if entry.is_symlink():
            return True, []
        if entry.name.startswith(".") or entry.name == "truth" or path in self._hidden:
            return False, []
        return self.open_parts(path) if entry.is_dir() else (True, [path])


def _entries(folder: Path) -> list["os.DirEntry[str]"]:
    try:
        with os.scandir(folder) as found:
            return list(found)
    except OSError:
        return []


CREATE_RULESET, ADD_RULE, RESTRICT_SELF = 444, 445, 446
"""System calls; their numbers are the same on every architecture but Alpha."""

PATH_BENEATH = 1
EXECUTE, WRITE_FILE, READ_FILE, READ_DIR = (1 << bit for bit in range(4))
READ = EXECUTE | READ_FILE | READ_DIR
TRUNCATE, IOCTL_DEV = 1 << 14, 1 << 15
FILE_RIGHTS = EXECUTE | WRITE_FILE | READ_FILE | TRUNCATE | IOCTL_DEV
RIGHTS = {1: (1 << 13) - 1, 2: (1 << 14) - 1, 3: (1 << 15) - 1, 5: (1 << 16) - 1}
"""Every right on files that can be denied, by the Landlock version that added the last of them."""

TCP_SINCE, TCP = 4, 0b11
SCOPES_SINCE, SCOPES = 6, 0b11
"""Binding and connecting; abstract sockets and signals of others."""

NEW_USER, NEW_IPC, NEW_NET = 0x10000000, 0x08000000, 0x40000000
SET_NO_NEW_PRIVS = 38
CAPABILITY_VERSION = 0x20080522


class _Ruleset(ctypes.Structure):
    _fields_ = (("files", ctypes.c_uint64), ("ports", ctypes.c_uint64), ("scopes", ctypes.c_uint64))


class _PathBeneath(ctypes.Structure):
    _pack_ = 1
    _fields_ = (("allowed", ctypes.c_uint64), ("parent", ctypes.c_int32))


def main(requests: IO[bytes], facts: dict[str, Any]) -> None:
    """Confine this process and serve the solver that ``facts`` name until ``requests`` end."""
    answers = _take_stdout()
    _confine(facts)
    from vbbench.solving.isolation.serving import serve  # with NumPy, whose libraries start threads

    serve(facts["name"], requests, answers)


def _take_stdout() -> IO[bytes]:
    """The pipe that was stdout; afterwards prints go to stderr, and stdin is empty."""
    answers = open(os.dup(1), "wb")  # noqa: PTH123, SIM115
    os.dup2(2, 1)
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.close(nothing)
    return answers


def _confine(facts: dict[str, Any]) -> None:
    with suppress(ImportError):  # Windows
        import resource

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    if sys.platform.startswith("linux"):
        leave_namespaces()
        if landlock_version():
            restrict(facts["readable"], facts["writable"])
        drop_capabilities()
    end_with_parent(facts["parent"])  # last: it starts a thread


def landlock_version() -> int:
    """Landlock's version in the running kernel; 0 if it is missing or switched off."""
    if not sys.platform.startswith("linux"):
        return 0
    return max(0, int(_libc().syscall(CREATE_RULESET, None, ctypes.c_size_t(0), ctypes.c_uint32(1))))


def restrict(readable: Iterable[str], writable: Iterable[str]) -> None:
    """Deny irrevocably access to all files except ``readable`` and ``writable`` and their contents.

    As far as the kernel supports it, TCP and access to the memory of other processes and signals to them are denied
    too. Child processes inherit all of this.

    Raises OSError if the kernel refuses.
    """
    found = landlock_version()
    handled = next(rights for since, rights in sorted(RIGHTS.items(), reverse=True) if since <= found)
    rules = _Ruleset(handled, TCP if found >= TCP_SINCE else 0, SCOPES if found >= SCOPES_SINCE else 0)
    size = 8 if found < TCP_SINCE else 16 if found < SCOPES_SINCE else 24
    ruleset = _call("landlock_create_ruleset", CREATE_RULESET, ctypes.byref(rules), ctypes.c_size_t(size), 0)
    try:
        for path in readable:
            _allow(ruleset, path, READ & handled)
        for path in writable:
            _allow(ruleset, path, handled)
        if _libc().prctl(SET_NO_NEW_PRIVS, 1, 0, 0, 0):
            raise _error("prctl")
        _call("landlock_restrict_self", RESTRICT_SELF, ruleset, 0)
    finally:
        os.close(ruleset)


def leave_namespaces() -> bool:
    """Leave the network, shared memory and root's rights over other processes; False if the kernel forbids it."""
    user, group = os.getuid(), os.getgid()
    if _libc().unshare(NEW_USER | NEW_IPC | NEW_NET):
        return False
    with suppress(OSError):  # if it fails, this process runs as user "nobody"
        for name, text in {"setgroups": "deny", "uid_map": f"{user} {user} 1", "gid_map": f"{group} {group} 1"}.items():
            Path("/proc/self", name).write_text(text, encoding="ascii")
    return True


def drop_capabilities() -> None:
    """Drop root's capabilities, and those of a new user namespace."""
    nothing = (ctypes.c_uint32 * 6)()
    _libc().capset((ctypes.c_uint32 * 2)(CAPABILITY_VERSION, 0), nothing)


def _allow(ruleset: int, path: str, rights: int) -> None:
    try:
        place = os.open(path, os.O_PATH | os.O_CLOEXEC)
    except OSError:  # it is gone, or not visible to us
        return
    try:
        here = rights if Path(f"/proc/self/fd/{place}").is_dir() else rights & FILE_RIGHTS
        rule = _PathBeneath(here, place)
        _call("landlock_add_rule", ADD_RULE, ruleset, PATH_BENEATH, ctypes.byref(rule), 0)
    finally:
        os.close(place)


def _call(name: str, number: int, *arguments: object) -> int:
    result = int(_libc().syscall(number, *arguments))
    if result < 0:
        raise _error(name)
    return result


def _error(name: str) -> OSError:
    number = ctypes.get_errno()
    return OSError(number, os.strerror(number), name)


def _libc() -> ctypes.CDLL:
    return ctypes.CDLL(None, use_errno=True)
