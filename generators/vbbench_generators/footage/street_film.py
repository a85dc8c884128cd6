"""Split ``street-film``: films of the rendered street, with the boxes that a detector found in them.

The tables in ``street_films`` have a row for each box, each place of a person and each pose of a camera, in whole
multiples of 1 / `SCALE`; ``benchmarks/street_films.py`` writes them.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from vbbench.camera import PerspectiveCamera
from vbbench.exchange.box_rows import rows_of
from vbbench.exchange.box_tables import UNLINKED
from vbbench.files.tables import file_sha256
from vbbench.generation.footage import Footage, FootageOptions, Recordings
from vbbench.generation.generator import Card, Options, bundled_card
from vbbench.geometry import FloatArray, IntArray
from vbbench.parsing.json_text import read_json
from vbbench.scene import Scene
from vbbench_generators.footage.split import READ_BY_ALL, FootageSplit, laid_out, named
from vbbench_generators.footage.tracks import FoundTracks, follow

FOLDER = Path(__file__).with_name("street_films")
DT = 0.1
"""Seconds per frame of every film."""
SCALE = {"px": 4.0, "m": 1000.0, "rad": 10000.0, "score": 250.0}
"""Steps in a unit of what the tables hold."""
SIDES = ("left", "top", "width", "height")
_BOX = dict.fromkeys(SIDES, pa.int16())
_PLACE = dict.fromkeys("xy", pa.int16())
TABLES: dict[str, dict[str, pa.DataType]] = {
    "boxes": {"frame": pa.uint8(), **_BOX, "score": pa.uint8()},
    "people": {"person": pa.uint8(), "frame": pa.uint8(), **_PLACE, **_BOX},
    "walks": {"frame": pa.uint8(), **_PLACE, "yaw": pa.int16()},
    "heights": {"person": pa.uint8(), "height": pa.int16()},
}
"""Columns of each table, after ``film``: detections; people, with a label unless its width is 0; where the camera went;
heights. None has the name of a dataset's truth, which an isolated solver may not read."""

CARD = bundled_card("vbbench_generators", "street-film")


@dataclass(frozen=True, kw_only=True)
class StreetFilmSplit(FootageSplit):
    """Films of eight seconds by walkers and robots; their tables come with the package."""

    reads: ClassVar[frozenset[str]] = READ_BY_ALL - {"source"}

    card: Card = CARD
    every: int = 4
    height_mean: float = 1.7
    height_std: float = 0.07
    pixel_std: float = 5.0
    mount_height_std: float = 0.06

    def recordings(self, options: Options) -> Recordings:
        """See `FootageSplit.recordings`."""
        asked = options.footage or FootageOptions()
        films, tables = read_films()
        known = {film["name"]: number for number, film in enumerate(films)}
        names = named("film", asked.sequences, known)
        made = {name: _film(films[known[name]], known[name], tables) for name in names}
        facts = {
            name: {
                "carried_by": films[known[name]]["carried_by"],
                "time": films[known[name]]["time"],
                "detected": tracks.detected.values(),
                "tracked": tracks.tracked.values(),
            }
            for name, (_, tracks) in made.items()
        }
        sums = {path.name: file_sha256(path) for path in sorted(FOLDER.iterdir())}
        return Recordings(
            footage=tuple(footage for footage, _ in made.values()),
            definition={"files": sums, "detector": "yolox_nano"},
            calibration={"summary": _summary(facts), "recordings": facts},
        )


Columns = dict[str, IntArray]


def read_films(folder: Path = FOLDER) -> tuple[list[dict[str, Any]], dict[str, Columns]]:
    """The facts of the films, and their tables as columns."""
    tables = {name: pq.read_table(folder / f"{name}.parquet") for name in TABLES}
    columns = {
        name: {column: table[column].to_numpy().astype(np.int64) for column in table.column_names}
        for name, table in tables.items()
    }
    return read_json(folder / "films.json"), columns


def _rows(tables: dict[str, Columns], table: str, film: int) -> Columns:
    kept = slice(*np.searchsorted(tables[table]["film"], [film, film + 1]))
    return {name: column[kept] for name, column in tables[table].items()}


def _unpacked(rows: Columns, unit: str, *names: str) -> FloatArray:
    return np.stack([rows[name] for name in names], axis=-1) / SCALE[unit]


def _film(facts: dict[str, Any], number: int, tables: dict[str, Columns]) -> tuple[Footage, FoundTracks]:
    """The footage of one film, and the tracks of its boxes."""
    poses, rows = _rows(tables, "walks", number), _rows(tables, "people", number)
    width, height = facts["width"], facts["height"]
    camera = PerspectiveCamera(
        width=width,
        height=height,
        cx=0.5 * width,
        cy=0.5 * height,
        focal=facts["focal"],
        mount_height=facts["mount_height"],
    )
    heights = _unpacked(_rows(tables, "heights", number), "m", "height")[:, 0]
    shape, at = (len(poses["frame"]), len(heights)), (rows["frame"], rows["person"])
    places = laid_out(shape, at, _unpacked(rows, "m", "x", "y"))
    labels = laid_out(shape, at, np.where(rows["width"][:, None] > 0, _unpacked(rows, "px", *SIDES), np.nan))
    tracks = _tracks(_rows(tables, "boxes", number), labels, camera)
    footage = Footage(
        name=facts["name"],
        camera=camera,
        dt=DT,
        tracks=tracks.tracks,
        boxes=tracks.boxes,
        visible=tracks.scores,
        poses=np.column_stack([_unpacked(poses, "m", "x", "y"), _unpacked(poses, "rad", "yaw")]),
        scene=Scene(name=facts["name"], dt=DT, people=np.arange(shape[1]), positions=places, heights=heights),
        persons=tracks.persons,
    )
    return footage, tracks


def _tracks(rows: Columns, labels: FloatArray, camera: PerspectiveCamera) -> FoundTracks:
    boxes, scores = _unpacked(rows, "px", *SIDES), _unpacked(rows, "score", "score")[:, 0]
    loose = np.full(len(scores), UNLINKED)
    found = rows_of(FOLDER / "boxes.parquet", rows["frame"], loose, boxes, scores)
    return follow(found, labels, np.arange(labels.shape[1]), camera, DT, size=camera.picture_size)


def _summary(facts: dict[str, dict[str, Any]]) -> str:
    names = ("recall", "precision")
    found, kept = (
        ", ".join(f"{name} {np.mean([one[what][name] for one in facts.values()]):.2f}" for name in names)
        for what in ("detected", "tracked")
    )
    robots = sum(one["carried_by"] == "robot" for one in facts.values())
    films = f"films: {len(facts)}, of which a robot carries the camera in {robots}"
    return f"{films}; boxes found: {found}; after tracking {kept}"


street_film = StreetFilmSplit()
