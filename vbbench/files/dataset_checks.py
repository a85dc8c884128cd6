"""Checks of a dataset's files: each key of ``dataset.json``, and the consistency of its tables."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from msgspec import UNSET, Meta, Struct, UnsetType, ValidationError, convert, defstruct
from msgspec.structs import asdict
from numpy.typing import NDArray

from vbbench.errors import FileError, is_printable, quoted
from vbbench.files.tables import SCHEMAS
from vbbench.geometry import BoolArray, IntArray
from vbbench.solver import BOX_EDGE, Carrier

TABLES = tuple(name for name in SCHEMAS if name not in ("poses", "positions", "heights"))
"""Names that a table of a dataset can have; no other name is ever used in a path."""

PUBLIC = ("sequences", "observations", "given")
"""The tables that every dataset has."""

Known = Literal["whole", "poses", "relative", "none"]
"""What is known of a dataset's truth: see `TRUTH_TABLES`."""

TRUTH_TABLES: dict[Known, tuple[str, ...]] = {
    "whole": ("truth/scenes", "truth/people", "truth/tracks", "truth/frames", "truth/poses"),
    "poses": ("truth/frames", "truth/poses"),
    "relative": ("truth/scenes", "truth/people", "truth/tracks"),
    "none": (),
}
"""The tables of truth, by what is known: everything, only the observer's poses, only where people are relative to it
(to the right and forward of the camera), nothing."""

ALWAYS = PUBLIC + TRUTH_TABLES["whole"]
"""The tables of a dataset whose truth is known."""

LONGEST_TEXT = 1000
Name = Annotated[str, Meta(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,39}\Z")]
Sha256 = Annotated[str, Meta(pattern=r"^[0-9a-f]{64}\Z")]
Count = Annotated[int, Meta(ge=0, le=1 << 53)]
Spread = Annotated[float, Meta(ge=0.0, le=10.0)]
CameraFacts = dict[str, Name | float]
"""Kind and parameters; their ranges are checked when the camera is made."""


class Text(str):
    """A text of 1 to 1000 characters that can be shown on one line."""


class TableFacts(Struct, forbid_unknown_fields=True):
    """Facts about one table of a dataset."""

    bytes: Count
    rows: Count
    sha256: Sha256


class PicturesFacts(Struct, forbid_unknown_fields=True):
    """Paths of the pictures of a sequence."""

    pattern: Text
    first: Count
    step: Annotated[int, Meta(ge=1, le=1 << 53)]


class CalibrationFacts(Struct):
    """The summary of a calibration is for people; its other keys are for programs."""

    summary: Text


TablesFacts = defstruct(
    "TablesFacts",
    [(name.replace("/", "_"), TableFacts | UnsetType, UNSET) for name in TABLES],
    rename={name.replace("/", "_"): name for name in TABLES},
    forbid_unknown_fields=True,
)


class CountsFacts(Struct, forbid_unknown_fields=True):
    """The counts of a dataset."""

    sequences: Count
    frames: Count
    observations: Count
    people_min: Count
    people_max: Count


class DatasetFacts(Struct, kw_only=True, forbid_unknown_fields=True):
    """The object in a ``dataset.json``."""

    id: Annotated[str, Meta(pattern=r"^[0-9a-f]{16}\Z")]
    split: Name
    title: Text
    camera: CameraFacts
    tier: Name
    seed: int | None
    dt: Annotated[float, Meta(gt=0.0, le=1000.0)]
    height_mean: Annotated[float, Meta(gt=0.0, le=10.0)]
    height_std: Spread
    pixel_std: Annotated[float, Meta(ge=0.0, le=1e6)]
    scenes: list[Text]
    definition: dict[str, Any]
    caution: Text | None
    counts: CountsFacts
    tables: TablesFacts  # type: ignore[valid-type]
    package_version: Annotated[str, Meta(max_length=80, pattern=r"^[ -~]*\Z")]
    format_version: int
    box_std: Spread = 0.0
    tilt_std: Spread = 0.0
    mount_height_std: Annotated[float, Meta(ge=0.0, le=1000.0)] = 0.0
    carried_by: Carrier = "unknown"
    box_edge: Annotated[float, Meta(ge=BOX_EDGE.least, le=BOX_EDGE.most)] | UnsetType = UNSET
    calibration: CalibrationFacts | None = None
    cameras: Annotated[list[CameraFacts], Meta(min_length=1)] | UnsetType = UNSET
    truth: Known = "whole"
    pictures: list[PicturesFacts | None] | UnsetType = UNSET
    digest: Sha256 | UnsetType = UNSET

    def __post_init__(self) -> None:
        if self.seed is not None and self.seed < 0:
            raise ValueError(f"Expected `int` >= 0, got {quoted(self.seed)} - at `$.seed`")
        given = asdict(self.tables)
        missing = [name for name in PUBLIC + TRUTH_TABLES[self.truth] if given[name.replace("/", "_")] is UNSET]
        if missing:
            raise ValueError(f"Object lacks {', '.join(missing)} - at `$.tables`")


def find_fault(values: Mapping[str, Any]) -> str | None:
    """The first fault of the object in a ``dataset.json``, with its place; ``None`` if there is none."""
    try:
        convert(values, DatasetFacts, dec_hook=_text)
    except UnicodeEncodeError:
        return "a text has half of a surrogate pair"
    except ValidationError as error:
        return str(error)
    return None


def _text(kind: type[Text], value: Any) -> Text:
    """Convert a value to a `Text`; a hook of msgspec."""
    if not isinstance(value, str) or not 0 < len(value) <= LONGEST_TEXT or not is_printable(value):
        raise ValueError(f"Expected text of 1 to {LONGEST_TEXT} printable characters, got {quoted(value)}")
    return kind(value)


FEW_CELLS, CELLS_PER_ROW = 10**6, 5000
"""Most frames times people of a sequence or scene: the first number, or the second times its rows if that is more."""

Rows = dict[str, NDArray[Any]]
PathOf = Callable[[str], Path]


def check_sequence(path_of: PathOf, index: int, frames: int, boxes: Rows, given: Rows, tracks: IntArray) -> None:
    """Raise FileError if rows of sequence ``index`` are inconsistent, or its arrays would be nearly empty.

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
    """Number of frames of a scene with ``people`` [K], at least the ``least`` that its sequences need.

    Raises FileError if people are not in order, a row has an unknown person or a position that is not finite, or the
    scene's arrays would be nearly empty.
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
    """Raise FileError if the scene of sequence ``index`` lacks ``people`` [K], or one seen is ``nowhere`` [T, K]."""
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
        raise _contradiction(path_of("truth/frames"), f"sequence {index} has no world, or several")


def _all_below(values: NDArray[Any], end: int) -> bool:
    """Whether all values are from 0 to ``end`` − 1."""
    return bool(((values >= 0) & (values < end)).all())


def _most_cells(rows: int) -> int:
    return max(FEW_CELLS, CELLS_PER_ROW * rows)


def _contradiction(path: Path, problem: str) -> FileError:
    return FileError(path, f"does not fit the other tables: {problem}; generate the dataset again")
