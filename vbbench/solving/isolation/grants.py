"""Which files an isolated solver may read: Python and what is installed, its own modules, and no dataset.

The kernel's rules open whole folders. If a folder that a solver needs contains something that must stay hidden, the
other entries are listed instead.
"""

import os
import site
import sys
import sysconfig
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from vbbench.folders.swapping import TRUTH, WORK
from vbbench.folders.swapping import beside as named_beside

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
        *("dataset.json", "submission.json", "seed.json", "partitioned", "pyvenv.cfg"),
        *(f"{table}.{kind}" for table in ("poses", "positions", "given", "scenes") for kind in ("parquet", "csv")),
    ]
)
"""Files that mark a folder as a dataset, its truth, or answers to it; or as a Python environment, which is readable
only if it is in use."""

MOST_ENTRIES = 50_000
"""Entries searched for datasets below a folder of the user's; the rest stays closed."""


def readable_paths(hidden: Sequence[Path], needed: Sequence[Path] = ()) -> list[str]:
    """What may be read, a path for each rule; none contains any of ``hidden``, all of which are resolved.

    Parameters
    ----------
    needed : files and folders to open besides Python's, installed packages' and those of `sys.path`.
    """
    installed = [Path(place).resolve() for place in _installed()]
    roots = [*needed, *(Path(entry or os.curdir).resolve() for entry in sys.path)]
    own = [root for root in roots if not any(root.is_relative_to(place) for place in installed)]
    granted = [path for place in (*map(Path, SYSTEM), *installed) for path in _around(place, hidden)]
    search = _Search(hidden)
    return [str(path) for path in (*granted, *(path for root in own for path in search.open_parts(root)[1]))]


def beside(folder: Path) -> list[Path]:
    """The folder, and those that belong beside it: its work folder and withheld truth."""
    place = folder.resolve()
    return [place, *(named_beside(place, ending) for ending in (WORK, TRUTH))]


def device_paths() -> list[str]:
    """What may be read and written besides the solver's own folder."""
    return [*DEVICES, *(str(path) for path in Path("/dev").glob("nvidia*"))]


def _installed() -> set[str]:
    """Folders of this Python and of what is installed for it."""
    places = {sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib", "scripts")}
    for prefix in (sys.prefix, sys.base_prefix, sys.exec_prefix, sys.base_exec_prefix):
        places |= {f"{prefix}/{name}" for name in ("lib", "lib64", "bin", "share", "pyvenv.cfg")}
    return places | set(site.getsitepackages()) | ({site.getusersitepackages()} if site.ENABLE_USER_SITE else set())


def _around(place: Path, hidden: Iterable[Path]) -> Iterator[Path]:
    """``place``, or the entries of it around what is hidden."""
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
        """Whether the whole of ``folder`` may be read, and which parts of it may be.

        Entries whose name starts with a dot stay closed: keys, settings, version control.
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
