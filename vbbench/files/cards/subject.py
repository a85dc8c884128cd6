"""Subject of a card: everything that is published of a dataset, with the meaning, unit and key of each column."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from vbbench.files.cards.origin import Origin, Publisher
from vbbench.files.dataset_info import INFO_FILE, DatasetInfo
from vbbench.files.tables import CAMERA, FRAME_TABLE, ODOMETRY_TABLE, TRACK_TABLE, table_schema
from vbbench.parsing.json_text import canonical_digest, read_object


@dataclass(frozen=True)
class Column:
    """What a column means.

    Parameters
    ----------
    meaning : in words.
    unit : such as ``px``; empty for ids and counts.
    """

    meaning: str
    unit: str = ""

    @property
    def text(self) -> str:
        """The meaning with the unit."""
        return f"{self.meaning} ({self.unit})" if self.unit else self.meaning


@dataclass(frozen=True, kw_only=True)
class TableMeaning:
    """What a table holds.

    Parameters
    ----------
    about : one row of it, in words.
    key : the columns whose values together name a row.
    columns : every column that it can have.
    """

    about: str
    key: tuple[str, ...]
    columns: Mapping[str, Column]


_SEQUENCE = Column("number of the sequence")
_SCENE = Column("number of the scene")
_FRAME = Column("frame, from 0 in the sequence")
_TRACK = Column("number of the track, which names a box from frame to frame within its sequence")
_X, _Y = (Column(f"{name} on the ground plane, in the world of the sequence", "m") for name in "xy")
_YAW = Column("direction in which the camera looks, counter-clockwise from +x, in the world of the sequence", "rad")
_POSE = {"x": _X, "y": _Y, "yaw": _YAW}
_SIDES = {"f": ("forward", "m"), "l": ("left", "m"), "turn": ("turn", "rad")}


def _covariance(name: str, first: str, second: str) -> tuple[str, Column]:
    """The column of one element of the motion's covariance."""
    (one, unit), (other, unit2) = _SIDES[first], _SIDES[second]
    if first == second:
        return name, Column(f"variance of {one}", f"{unit}²")
    return name, Column(f"covariance of {one} and {other}", f"{unit}²" if unit == unit2 else f"{unit}·{unit2}")


TABLE_MEANINGS: dict[str, TableMeaning] = {
    "sequences": TableMeaning(
        about="One row per sequence: a run of frames of a scene, seen by one observer.",
        key=("sequence",),
        columns={
            "sequence": _SEQUENCE,
            "scene": Column("number of the scene that it is a part of; `scenes` in dataset.json has the names"),
            "observer": Column("person of the scene who carries the camera; −1 is nobody of the scene"),
            "first_frame": Column("frame of the scene that is frame 0 of the sequence"),
            "frames": Column("number of frames, those without any box included"),
            "people": Column("number of tracks"),
            "split": Column("name of the split that the sequence was made from"),
            CAMERA: Column("number of its camera, from 0, in `cameras` of dataset.json"),
        },
    ),
    "observations": TableMeaning(
        about="One row per box of a person: all that a solver sees, frame by frame.",
        key=("sequence", "frame", "track"),
        columns={
            "sequence": _SEQUENCE,
            "frame": _FRAME,
            "track": _TRACK,
            "u": Column("column of the box's centre in the picture", "px"),
            "v": Column("row of the box's centre in the picture, downwards", "px"),
            "l": Column("height of the box", "px"),
            "visible": Column("fraction of the person that is visible; of a detector's box, its score"),
        },
    ),
    "given": TableMeaning(
        about="One row per place that a solver is given: the observer's in frames 0 and 1, everybody else's in their "
        "first two frames with a box.",
        key=("sequence", "frame", "track"),
        columns={
            "sequence": _SEQUENCE,
            "frame": _FRAME,
            "track": Column("number of the track; −1 is the observer"),
            "x": _X,
            "y": _Y,
            "yaw": replace(_YAW, meaning=f"{_YAW.meaning}; NaN for everybody but the observer"),
        },
    ),
    ODOMETRY_TABLE: TableMeaning(
        about="One row per frame: how the observer measured its own motion since the frame before, in that frame's "
        "axes.",
        key=("sequence", "frame"),
        columns={
            "sequence": _SEQUENCE,
            "frame": _FRAME,
            "forward": Column("motion forward", "m"),
            "left": Column("motion to the left", "m"),
            "turn": Column("turn to the left", "rad"),
            **dict(
                _covariance(*names)
                for names in (
                    ("ff", "f", "f"),
                    ("fl", "f", "l"),
                    ("f_turn", "f", "turn"),
                    ("ll", "l", "l"),
                    ("l_turn", "l", "turn"),
                    ("turn_turn", "turn", "turn"),
                )
            ),
        },
    ),
    "truth/poses": TableMeaning(
        about="One row per frame: where the observer truly is.",
        key=("sequence", "frame"),
        columns={"sequence": _SEQUENCE, "frame": _FRAME, **_POSE},
    ),
    "truth/scenes": TableMeaning(
        about="One row per person and frame of a scene: where everybody truly is, in the world of the scene.",
        key=("scene", "frame", "person"),
        columns={
            "scene": _SCENE,
            "frame": Column("frame, from 0 in the scene"),
            "person": Column("number of the person"),
            "x": Column("x on the ground plane, in the world of the scene", "m"),
            "y": Column("y on the ground plane, in the world of the scene", "m"),
        },
    ),
    "truth/people": TableMeaning(
        about="One row per person of a scene.",
        key=("scene", "person"),
        columns={
            "scene": _SCENE,
            "person": Column("number of the person"),
            "height": Column("height of the person", "m"),
        },
    ),
    TRACK_TABLE: TableMeaning(
        about="One row where a track begins to stand for a person; it does so until its next row.",
        key=("sequence", "frame", "track"),
        columns={
            "sequence": _SEQUENCE,
            "frame": _FRAME,
            "track": _TRACK,
            "person": Column("number of the person of the scene; −1 is nobody, a false alarm"),
        },
    ),
    FRAME_TABLE: TableMeaning(
        about="One row per sequence: where the scene lies in its world. A point p of the scene is R(yaw)·p + (x, y) "
        "there.",
        key=("sequence",),
        columns={
            "sequence": _SEQUENCE,
            "x": Column("x of the scene's origin, in the world of the sequence", "m"),
            "y": Column("y of the scene's origin, in the world of the sequence", "m"),
            "yaw": Column("angle by which the scene is turned, counter-clockwise", "rad"),
        },
    ),
}
"""Every table that a dataset can have; `vbbench.files.tables.SCHEMAS` has the types."""

_RELATIVE = TABLE_MEANINGS["truth/scenes"]
RELATIVE_SCENES = replace(
    _RELATIVE,
    about="One row per person and frame of a recording: where everybody is as seen from the camera, whose own place "
    "was not measured.",
    columns={
        **_RELATIVE.columns,
        "x": Column("to the right of the camera", "m"),
        "y": Column("ahead of the camera", "m"),
    },
)
"""``truth/scenes`` where people were measured relative to the camera only."""


def meaning_of(table: str, *, relative: bool = False) -> TableMeaning:
    """What a table holds; ``relative``: its dataset knows only where people are from the camera."""
    return RELATIVE_SCENES if relative and table == "truth/scenes" else TABLE_MEANINGS[table]


_ORDER = ("observations", "given", "odometry", "sequences")


@dataclass(frozen=True, kw_only=True)
class Subject:
    """A dataset as its card shows it.

    Parameters
    ----------
    info : what is published about it.
    values : the same, as ``dataset.json`` has it.
    info_file : bytes and SHA-256 of ``dataset.json``.
    origin : where it comes from.
    publisher : what its publisher says.
    """

    info: DatasetInfo
    values: dict[str, Any]
    info_file: dict[str, Any]
    origin: Origin
    publisher: Publisher

    @property
    def id(self) -> str:
        """The dataset's id; as it is written, since computing it takes time."""
        return str(self.values["id"])

    @property
    def digest(self) -> str:
        """Digest of the values in ``dataset.json``."""
        return digest_of(self.values)

    @property
    def is_footage(self) -> bool:
        """Whether a real camera, or a game's, saw the boxes."""
        imported = self.info.definition.get("of")
        return "every" in (imported if isinstance(imported, dict) else self.info.definition)

    @property
    def tables(self) -> list[str]:
        """Names of the tables that lie in the folder, in the order in which a reader meets them."""
        return tables_here(self.info)

    def meaning(self, table: str) -> TableMeaning:
        """What a table holds."""
        return meaning_of(table, relative=self.info.truth == "relative")

    def columns(self, table: str) -> list[tuple[str, Any, str]]:
        """Name, Arrow type and meaning of every column of a table."""
        meanings = self.meaning(table).columns
        schema = table_schema(table, [CAMERA] if self.info.cameras else [])
        return [(field.name, field.type, meanings[field.name].text) for field in schema]


def read_info_file(folder: Path) -> tuple[dict[str, Any], dict[str, Any]]:
    """The values in ``dataset.json``, and its bytes and SHA-256."""
    data = (folder / INFO_FILE).read_bytes()
    values = read_object(folder / INFO_FILE, "generate the dataset again")
    return values, {"bytes": len(data), "sha256": hashlib.sha256(data).hexdigest()}


def digest_of(values: dict[str, Any]) -> str:
    """Digest of what a ``dataset.json`` says; those of older versions do not have it in them."""
    return str(values.get("digest") or canonical_digest(values))


def tables_here(info: DatasetInfo) -> list[str]:
    """Names of the tables that lie in the folder of a dataset: those of withheld truth do not."""
    names = [name for name in _ORDER if name in info.tables]
    truth = [name for name in sorted(info.tables) if name.startswith("truth/")]
    return names if info.seed is None else [*names, *truth]
