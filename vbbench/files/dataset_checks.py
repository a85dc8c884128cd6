"""Checks of a dataset's files: each key of ``dataset.json``, and whether its tables fit one another."""

import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vbbench.errors import FileError, is_printable, quoted
from vbbench.files.tables import SCHEMAS
from vbbench.geometry import BoolArray, IntArray
from vbbench.solver import BOX_EDGE, CARRIERS

TABLES = tuple(name for name in SCHEMAS if name not in ("poses", "positions", "heights"))
"""Names that a table of a dataset can have; no other name is ever used in a path."""

PUBLIC = ("sequences", "observations", "given")
"""The tables that every dataset has."""

TRUTH_TABLES = {
    "whole": ("truth/scenes", "truth/people", "truth/tracks", "truth/frames", "truth/poses"),
    "poses": ("truth/frames", "truth/poses"),
    "relative": ("truth/scenes", "truth/people", "truth/tracks"),
    "none": (),
}
"""The tables of truth, by what is known: everything, only the observer's poses, only where people are relative to it
(to the right and forward of the camera), nothing."""

ALWAYS = PUBLIC + TRUTH_TABLES["whole"]
"""The tables of a dataset whose truth is known."""

COUNTS = ("sequences", "frames", "observations", "people_min", "people_max")
"""The counts of every complete dataset."""

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,39}")
_ID = re.compile(r"[0-9a-f]{16}")
_SHA256 = re.compile(r"[0-9a-f]{64}")
_LARGEST_COUNT = 1 << 53
_LONGEST_TEXT = 1000

Fault = str | None
Check = Callable[[Any], Fault]


def find_fault(values: Mapping[str, Any]) -> Fault:
    """The first thing that is wrong with the object in a ``dataset.json``, by its key; ``None`` if nothing is."""
    checks = _CHECKS | _OPTIONAL
    for name in values:
        if name not in checks:
            return f"key {quoted(name)} is unknown"
    for name, check in checks.items():
        if name in values:
            fault = check(values[name])
            if fault is not None:
                return f"key '{name}' {fault}"
        elif name in _CHECKS:
            return f"key '{name}' is missing"
    tables = values["tables"]
    missing = [name for name in TRUTH_TABLES[values.get("truth", "whole")] if name not in tables]
    return f"key 'tables' lacks {', '.join(missing)}" if tables and missing else None


def _must_be(wanted: str, is_good: Callable[[Any], object]) -> Check:
    return lambda value: None if is_good(value) else f"is {quoted(value)}, not {wanted}"


def _text(longest: int = _LONGEST_TEXT) -> Check:
    return _must_be(
        f"text of 1 to {longest} printable characters",
        lambda value: isinstance(value, str) and 0 < len(value) <= longest and is_printable(value),
    )


def _like(pattern: re.Pattern[str], wanted: str) -> Check:
    return _must_be(wanted, lambda value: isinstance(value, str) and pattern.fullmatch(value))


def _number(least: float, most: float, *, above: bool = False) -> Check:
    """A number from ``least``, or ``above`` it, to ``most``."""

    def is_good(value: Any) -> bool:
        known = isinstance(value, (int, float)) and not isinstance(value, bool)
        return known and least <= value <= most and not (above and value == least)

    return _must_be(f"a number {'above' if above else 'from'} {least:g} to {most:g}", is_good)


def _whole(least: int, most: int | None = _LARGEST_COUNT) -> Check:
    def is_good(value: Any) -> bool:
        known = isinstance(value, int) and not isinstance(value, bool)
        return known and value >= least and (most is None or value <= most)

    return _must_be(f"a whole number from {least} on", is_good)


def _or_null(check: Check) -> Check:
    return lambda value: None if value is None else check(value)


def _each_of(checks: Mapping[str, Check]) -> Check:
    """An object with exactly these keys."""

    def check(value: Any) -> Fault:
        if not isinstance(value, dict) or set(value) != set(checks):
            return f"is {quoted(value)}, not an object with the keys {', '.join(checks)}"
        faults = ((name, checks[name](value[name])) for name in checks)
        return next((f"has '{name}', which {fault}" for name, fault in faults if fault), None)

    return check


def _scenes(value: Any) -> Fault:
    if not isinstance(value, list):
        return f"is {quoted(value)}, not a list of names"
    fault = next((fault for fault in map(_text(), value) if fault), None)
    return f"has a name that {fault}" if fault else None


def _camera(value: Any) -> Fault:
    """Parameters must be numbers; kind and ranges are checked when the camera is made."""
    if not isinstance(value, dict) or not isinstance(value.get("kind"), str):
        return f"is {quoted(value)}, not a camera: it has a 'kind' and its parameters"
    number = _number(-1e9, 1e9)
    faults = ((name, number(part)) for name, part in value.items() if name != "kind")
    return next((f"has {quoted(name)}, which {fault}" for name, fault in faults if fault), None)


def _cameras(value: Any) -> Fault:
    if not isinstance(value, list) or not value:
        return f"is {quoted(value)}, not a list of cameras"
    return next((fault for fault in map(_camera, value) if fault), None)


def _pictures(value: Any) -> Fault:
    """One entry a sequence: null, or where its pictures are."""
    if not isinstance(value, list):
        return f"is {quoted(value)}, not a list"
    check = _or_null(_each_of({"pattern": _text(), "first": _whole(0), "step": _whole(1)}))
    return next((f"has an entry that {fault}" for fault in map(check, value) if fault), None)


def _counts(value: Any) -> Fault:
    """Counts may be absent: those of a dataset in partitions are not known yet."""
    return None if value == {} else _each_of(dict.fromkeys(COUNTS, _whole(0)))(value)


def _tables(value: Any) -> Fault:
    if not isinstance(value, dict):
        return f"is {quoted(value)}, not an object of tables"
    facts = _each_of({"bytes": _whole(0), "rows": _whole(0), "sha256": _like(_SHA256, "a SHA-256 in hex")})
    for name, given in value.items():
        if name not in TABLES:
            return f"has {quoted(name)}, which is the name of no table; there are {', '.join(TABLES)}"
        fault = facts(given)
        if fault is not None:
            return f"has '{name}', which {fault}"
    missing = [name for name in PUBLIC if name not in value]
    return f"lacks {', '.join(missing)}" if value and missing else None


def _calibration(value: Any) -> Fault:
    """Its ``summary`` is printed; the rest is for programs."""
    if not isinstance(value, dict):
        return f"is {quoted(value)}, not an object"
    fault = _text()(value.get("summary"))
    return f"has 'summary', which {fault}" if fault else None


_CHECKS: dict[str, Check] = {
    "id": _like(_ID, "an id of 16 hex digits"),
    "split": _like(_NAME, "the name of a split"),
    "title": _text(),
    "camera": _camera,
    "tier": _like(_NAME, "the name of a tier"),
    "seed": _or_null(_whole(0, None)),
    "dt": _number(0, 1000, above=True),
    "height_mean": _number(0, 10, above=True),
    "height_std": _number(0, 10),
    "pixel_std": _number(0, 1e6),
    "scenes": _scenes,
    "definition": _must_be("an object", lambda value: isinstance(value, dict)),
    "caution": _or_null(_text()),
    "counts": _counts,
    "tables": _tables,
    "package_version": lambda value: None if value == "" else _text(80)(value),
    "format_version": _whole(1),
}

_OPTIONAL: dict[str, Check] = {
    "box_std": _number(0, 10),
    "tilt_std": _number(0, 10),
    "mount_height_std": _number(0, 1e3),
    "carried_by": _must_be(f"one of {', '.join(CARRIERS)}", lambda value: value in CARRIERS),
    "box_edge": _number(BOX_EDGE.least, BOX_EDGE.most),
    "calibration": _or_null(_calibration),
    "cameras": _cameras,
    "truth": _must_be(f"one of {', '.join(TRUTH_TABLES)}", lambda value: value in TRUTH_TABLES),
    "pictures": _pictures,
    "digest": _like(_SHA256, "a SHA-256 in hex"),
}


FEW_CELLS, CELLS_PER_ROW = 10**6, 5000
"""Most frames times people of a sequence or scene: the first number, or the second times its rows if that is more."""

Rows = dict[str, NDArray[Any]]
PathOf = Callable[[str], Path]


def check_sequence(path_of: PathOf, index: int, frames: int, boxes: Rows, given: Rows, tracks: IntArray) -> None:
    """Raise FileError if rows of sequence ``index`` contradict one another, or it would be nearly empty.

    Parameters
    ----------
    path_of : the path of a table, by name.
    frames : number of frames of the sequence.
    boxes, given : its rows of the tables ``observations`` and ``given``.
    tracks : [K] the observed tracks.
    """
    for name, rows in (("observations", boxes), ("given", given)):
        if not _all_below(rows["frame"], frames):
            raise _contradiction(path_of(name), f"sequence {index} has {frames:,} frames, and a row another one")
    people = given["track"][given["track"] >= 0]
    if not np.isin(people, tracks).all():
        raise _contradiction(path_of("given"), f"in sequence {index} it gives a person who is never observed")
    if frames * max(1, len(tracks)) > _most_cells(len(boxes["frame"]) + len(given["frame"])):
        problem = f"sequence {index} has {frames:,} frames with {len(boxes['frame']):,} boxes"
        raise _contradiction(path_of("sequences"), problem)


def check_scene(path_of: PathOf, scene: int, people: IntArray, rows: Rows, least: int) -> int:
    """Number of frames of a scene with ``people`` [K]: those of its rows, and the ``least`` that its sequences reach.

    Raises FileError if people are not in order, a row is of an unknown person or infinitely far, or the scene would be
    nearly empty.
    """
    if not (np.diff(people) > 0).all() or not np.isin(rows["person"], people).all():
        raise _contradiction(path_of("truth/people"), f"scene {scene} has people twice, unsorted or unknown")
    most = _most_cells(len(rows["frame"])) // max(1, len(people))
    if not _all_below(rows["frame"], most) or least > most:
        raise _contradiction(path_of("truth/scenes"), f"scene {scene} has a frame far from all others, or below 0")
    if np.isinf(rows["x"]).any() or np.isinf(rows["y"]).any():
        raise _contradiction(path_of("truth/scenes"), f"in scene {scene} a person is infinitely far")
    return max(least, int(rows["frame"].max(initial=-1)) + 1)


def check_poses(path_of: PathOf, index: int, frames: int, poses: Rows) -> None:
    """Raise FileError unless sequence ``index`` has a true pose in each of its ``frames``."""
    if not np.array_equal(poses["frame"], np.arange(frames)):
        raise _contradiction(path_of("truth/poses"), f"sequence {index} has {frames:,} frames")


def check_in_scene(path_of: PathOf, index: int, people: IntArray, nowhere: BoolArray | None = None) -> None:
    """Raise FileError if sequence ``index`` has no ``people`` [K] in its scene, or one seen is ``nowhere`` [T, K]."""
    if not len(people):
        raise _contradiction(path_of("truth/scenes"), f"the scene of sequence {index} is empty")
    if nowhere is not None and nowhere.any():
        frame = int(nowhere.any(axis=1).argmax())
        problem = f"in frame {frame} of sequence {index} a person is seen who is not in the scene then"
        raise _contradiction(path_of("truth/scenes"), problem)


def check_tracks(path_of: PathOf, index: int, frames: int, tracks: IntArray, rows: Rows) -> None:
    """Raise FileError unless the true persons of sequence ``index`` belong to its ``tracks`` [K] and ``frames``."""
    if not _all_below(rows["frame"], frames) or not np.isin(rows["track"], tracks).all():
        raise _contradiction(path_of("truth/tracks"), f"it names a box that sequence {index} does not have")


def check_frame(path_of: PathOf, index: int, rows: Rows) -> None:
    """Raise FileError unless there is one world of sequence ``index``, of finite numbers."""
    if len(rows["x"]) != 1 or not np.isfinite([rows[name][0] for name in ("x", "y", "yaw")]).all():
        raise _contradiction(path_of("truth/frames"), f"sequence {index} has no world of its own, or several")


def _all_below(values: NDArray[Any], end: int) -> bool:
    """Whether all are from 0 to ``end`` − 1."""
    return bool(((values >= 0) & (values < end)).all())


def _most_cells(rows: int) -> int:
    return max(FEW_CELLS, CELLS_PER_ROW * rows)


def _contradiction(path: Path, problem: str) -> FileError:
    return FileError(path, f"does not fit the other tables: {problem}; generate the dataset again")
