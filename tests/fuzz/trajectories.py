"""Kinds of trajectory files, each beside the plain oracle."""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from tests.fuzz.kind import Kind, Refused
from tests.fuzz.mutations import TEXT
from tests.fuzz.oracle import STRICTER, Row, boxes_of, finite, lines, rows_of
from tests.lib.mot_text import read_mot
from vbbench.exchange.tum import import_tum
from vbbench.generation.generator import Options
from vbbench_generators.recordings.loading import SceneFile, load_scenes
from vbbench_generators.recordings.readers.tables import obsmat, trajnet
from vbbench_generators.recordings.readers.tracks import read_homography
from vbbench_generators.recordings.readers.vsp import read_key_points, vsp
from vbbench_generators.recordings.recipe import get_recipe

HOMOGRAPHY = "0.02 0.001 -3\n-0.002 0.03 1.5\n0.00001 0.0002 1\n"
SPLINES = """2 - the number of splines
3 - Num of control points
0.0 0.0 0 90.0 - (2D point, m_id)
100.0 0.0 20 90.0 - (2D point, m_id)
100.0 50.0 35 -80.5 - (2D point, m_id)
2 - Num of control points
0.0 10.0 8 0.0 - (2D point, m_id)
0.0 70.0 32 0.0 - (2D point, m_id)
7 - number of line obstacles
-379.0 -300.0 380.0 -300.0 1 - left(x,y) right(x,y), type
"""
FRAMES, DT = 20, 0.4


def _walk(row: Callable[[int, int], str]) -> str:
    """Five people over some frames, one line each, with a comment before."""
    return "# made\n" + "".join(row(frame, person) for frame in range(6) for person in range(5)) + "\n"


TRAJNET = _walk(lambda frame, person: f"{10 * frame} {person}.0 {0.5 * frame + person / 3!r} {-1.25 * person}\n")
OBSMAT = _walk(lambda f, p: f"  {10 * f}.0e+00 {p} {0.5 * f + p / 3!r} 0.0 {-1.25 * p} 1.2 0.0 0.1\n")
MOT = "".join(
    f"{frame},{track},{100.5 + 3 * frame},{50 + track / 7!r},20,60.25,0.9,1,{1 - track / 10}\n"
    for frame in range(1, 9)
    for track in range(1, 4)
)
DETECTIONS = "# detections\n" + "".join(f"{f},-1,{10.5 + f},20,15,40,{0.1 * f},-1,-1,-1\n" for f in range(1, 9))
TUM = "# body: x forward, z up\n" + "".join(
    f"{f * DT!r} {0.5 * f!r} {-f / 3!r} 1.6 0 0 {math.sin(f / 8)!r} {math.cos(f / 8)!r}\n" for f in range(12)
)


@dataclass(frozen=True)
class _Oracle:
    """Compares what was read with what the plain reader finds.

    Parameters
    ----------
    rows : the plain reader.
    same : whether what was read holds what the rows say.
    """

    rows: Callable[[bytes], list[Row] | None]
    same: Callable[[object, list[Row]], bool]

    def __call__(self, content: bytes, outcome: object) -> str | None:
        rows = self.rows(content)
        if isinstance(outcome, Refused):
            stricter = any(re.search(reason, outcome.message) for reason in STRICTER.values())
            return f"the oracle reads it: {outcome.message}" if rows and not stricter else None
        if rows is None:
            return "the oracle cannot read it"
        return None if self.same(outcome, rows) else "the oracle reads other numbers"


def _same_scene(x: int, y: int) -> Callable[[object, list[Row]], bool]:
    """Everybody walks from place to place in the order of their frames, and frames keep their distances."""

    def same(scene: object, rows: list[Row]) -> bool:
        if sorted({int(row[1]) for row in rows}) != scene.people.tolist():
            return False
        for column, person in enumerate(scene.people.tolist()):
            own = sorted(row for row in rows if row[1] == person)
            there = np.flatnonzero(scene.present[:, column])
            if scene.positions[there, column].tolist() != [[row[x], row[y]] for row in own]:
                return False
            steps = {(b[0] - a[0]) / (m - n) for a, b, n, m in zip(own, own[1:], there, there[1:], strict=False)}
            if len(steps) > 1:
                return False
        return int(scene.present.sum()) == len(rows)

    return same


def _same_boxes(outcome: object, rows: list[Row]) -> bool:
    """Boxes are rows of the file, in its order, frames and corners from 1 in it.

    Rows of ground truth, 9 columns with flags and class 1 or none, count by flag, class and visibility.
    """
    plain = all(len(r) == 9 and r[6] in (0, 1) and r[7] in (-1, 1) for r in rows) and any(r[6] == 1 for r in rows)
    counted = [r for r in rows if not plain or (r[6] != 0 and r[8] != 0)]
    wanted = [(r[0] - 1, r[1], r[2] - 1, r[3] - 1, r[4], r[5], r[6] if len(r) > 6 else 1.0) for r in counted]
    columns = [outcome.frame, outcome.track, *outcome.boxes.T, outcome.scores]
    found = list(zip(*(column.tolist() for column in columns), strict=True))
    if any(row[1] > 2**31 - 1 for row in wanted):  # such ids are numbered from 1 on
        wanted, found = ([(row[0], *row[2:]) for row in rows] for rows in (wanted, found))
    if np.isnan(outcome.scores).any():  # 0 or -1 throughout says nothing
        wanted, found = ([row[:-1] for row in rows] for rows in (wanted, found))
    rest = iter(wanted)
    return found == wanted if plain else all(any(one == row for row in rest) for one in found)


def _poses_of(content: bytes) -> list[Row] | None:
    """Rows of eight numbers with white space between, or a comma in every line; a ninth may follow a rotation."""
    for width in (8, 9):
        commas = all(line.count(",") == width - 1 for line in lines(content, errors="replace") or ())
        rows = rows_of(content, width=width, commas=commas, errors="replace")
        if rows and (width == 8 or math.isclose(math.hypot(*rows[0][4:8]), 1.0, abs_tol=1e-3)):
            return [row[:8] for row in rows]
    return None


def _same_poses(outcome: object, rows: list[Row]) -> bool:
    frames, poses = outcome  # type: ignore[misc]
    wanted = sorted((round(row[0] / DT), row[1], row[2]) for row in rows)
    turns = np.exp(1j * poses[:, 2])
    rotations = [complex(r[7], r[6]) ** 2 / abs(complex(r[7], r[6])) ** 2 for r in sorted(rows)]
    return list(zip(frames.tolist(), *poses[:, :2].T.tolist(), strict=True)) == wanted and np.allclose(turns, rotations)


def _same_matrix(outcome: object, rows: list[Row]) -> bool:
    return np.array_equal(np.asarray(outcome), np.array(rows))


def _vsp_oracle(content: bytes, outcome: object) -> str | None:
    """Key points as the plainest reader finds them: a count, then so many lines, and so on."""
    if isinstance(outcome, Refused):
        return None
    text = lines(content) or []
    found, row = [], 1
    for _ in range(int(text[0].split("-")[0])):
        count = int(text[row].split("-")[0])
        cells = [line.split(" - ")[0].replace(",", " ").split() for line in text[row + 1 : row + 1 + count]]
        found.append([[finite(cell) for cell in line] for line in cells])
        row += 1 + count
    read = [[[*point, frame] for point, frame in zip(k.points.tolist(), k.frame, strict=True)] for k in outcome]
    return None if read == [[line[:3] for line in keys] for keys in found] else "the oracle reads other key points"


def _file(name: str, text: str) -> Callable[[Path], object]:
    return lambda folder: (folder / name).write_text(text, encoding="utf-8", newline="")


def _own_file(folder: Path) -> object:
    """As the split ``custom`` takes it, whatever format it has."""
    homography = folder / "H.txt" if (folder / "H.txt").is_file() else None
    return load_scenes(get_recipe("custom"), Options(source=folder / "mine.txt", dt=DT, homography=homography))


def _own_files(folder: Path) -> None:
    _file("mine.txt", SPLINES)(folder)
    _file("H.txt", "0.01 0 0\n0 0.01 0\n0 0 1\n")(folder)


def _text(
    name: str, file: str, text: str, read: Callable[[Path], object], oracle: Callable[..., str | None], weight: int
) -> Kind:
    """A kind of one file of text."""
    return Kind(
        name=name,
        make=_file(file, text),
        target=file,
        mutations=TEXT,
        read=lambda folder: read(folder / file),
        oracle=oracle,
        weight=weight,
    )


def _numbers(width: int, same: Callable[[object, list[Row]], bool]) -> _Oracle:
    """Rows of so many numbers."""
    return _Oracle(partial(rows_of, width=width, commas=True), same)


def _sampled(path: Path) -> object:
    """Key points, after they have been sampled and put on the ground."""
    vsp.read(SceneFile(path=path, dt=DT, frame_step=10, homography=np.diag([0.01, 0.01, 1.0])))
    return read_key_points(path)


BOXES, POSES = _Oracle(boxes_of, _same_boxes), _Oracle(_poses_of, _same_poses)
KINDS = (
    _text(
        "trajnet",
        "tracks.txt",
        TRAJNET,
        lambda path: trajnet.read(SceneFile(path=path, dt=DT)),
        _numbers(4, _same_scene(2, 3)),
        6,
    ),
    _text(
        "obsmat",
        "obsmat.txt",
        OBSMAT,
        lambda path: obsmat.read(SceneFile(path=path, dt=DT)),
        _numbers(8, _same_scene(2, 4)),
        4,
    ),
    _text("homography", "H.txt", HOMOGRAPHY, read_homography, _numbers(3, _same_matrix), 3),
    _text("vsp", "a.vsp", SPLINES, _sampled, _vsp_oracle, 6),
    Kind(name="own-file", make=_own_files, target="mine.txt", mutations=TEXT, read=_own_file, weight=3),
    Kind(name="own-homography", make=_own_files, target="H.txt", mutations=TEXT, read=_own_file, weight=2),
    _text("mot", "sequence-000000.txt", MOT, partial(read_mot, frames=FRAMES), BOXES, 5),
    _text("detections", "det.txt", DETECTIONS, partial(read_mot, frames=FRAMES), BOXES, 3),
    _text("tum", "sequence-000000.txt", TUM, lambda path: import_tum(path, DT), POSES, 5),
)
"""Trajectories, and the homographies that put them on the ground."""
