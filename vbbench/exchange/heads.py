"""A recording of people's heads from high above a simulated crowd, as MOTChallenge Head Tracking 21, with its truth.

A fixed camera sees the heads of a scene; nearer heads, bodies and street furniture hide some. Boxes are drawn as
annotators do: by hand in key frames, and interpolated between them.
"""

import io
import json
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Annotated

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from vbbench.errors import VbbenchError, user_mistakes
from vbbench.exchange.sequence_files import sequence_info
from vbbench.files.dataset import Dataset
from vbbench.folders.locks import loose_files
from vbbench.folders.replacing import write_bytes_atomically, write_text_atomically
from vbbench.geometry import BoolArray, FloatArray, IntArray, freeze, world_to_relative
from vbbench.parsing.numbers import Within, check_ranges
from vbbench.scene import Scene

TRUTH_TABLE, TRUTH_FACTS = "truth.parquet", "truth.json"
"""The true place of each head in every frame; the camera, the options and figures of the recording."""
WIDTH, HEIGHT = 1920, 1080
"""Of the picture in px."""
HEAD_HEIGHT = 1.58
"""Height in m over the ground of the head's centre of a person 1.70 m tall."""
FARTHEST = 10.0
"""Where a picture reaches the horizon, the ground counts as visible up to so many camera heights away."""


@dataclass(frozen=True, kw_only=True)
class HeadOptions:
    """A surveillance camera, and the noise of its annotations.

    Parameters
    ----------
    camera_height : height of the camera over the ground in m.
    tilt : angle in degrees below the horizon.
    fov : horizontal field of view in degrees.
    facing : direction of view in degrees, counter-clockwise from the world's x axis.
    box_noise : relative root mean square error of the widths and heights of boxes.
    """

    camera_height: Annotated[float, Within(HEAD_HEIGHT + 1.0, 1000.0, "m")] = 13.0
    tilt: Annotated[float, Within(1.0, 89.0, "degrees")] = 30.0
    fov: Annotated[float, Within(1.0, 150.0, "degrees")] = 60.0
    facing: Annotated[float, Within(-360.0, 360.0, "degrees")] = 90.0
    box_noise: Annotated[float, Within(0.0, 0.4)] = 0.12


@dataclass(frozen=True, kw_only=True)
class SurveillanceCamera:
    """A pinhole with square pixels and the principal point in the middle of the picture.

    A point (right, forward, up) m as seen from the ground below the camera has Z = forward·cos θ + (H − up)·sin θ along
    the optical axis and Y = (H − up)·cos θ − forward·sin θ below it; its column is cx + f·right/Z, its row cy + f·Y/Z.

    Parameters
    ----------
    width, height : size of the picture in px.
    focal : f in px.
    mount_height : H in m.
    tilt : θ in rad, down from the horizon.
    """

    width: int
    height: int
    focal: float
    mount_height: float
    tilt: float

    @property
    def middle(self) -> tuple[float, float]:
        """The principal point (cx, cy) in px."""
        return self.width / 2.0, self.height / 2.0

    @property
    def horizon(self) -> float:
        """Row in px of the horizon: cy − f·tan θ."""
        return self.middle[1] - self.focal * float(np.tan(self.tilt))

    def project(self, points: FloatArray) -> FloatArray:
        """Points [..., 3] (right, forward, up) m → [..., 3] (u px, v px, Z m); NaN behind the camera."""
        right, forward, drop = points[..., 0], points[..., 1], self.mount_height - points[..., 2]
        sin, cos = np.sin(self.tilt), np.cos(self.tilt)
        depth = forward * cos + drop * sin
        depth = np.where(depth > 0.0, depth, np.nan)
        (cx, cy), down = self.middle, drop * cos - forward * sin
        return np.stack([cx + self.focal * right / depth, cy + self.focal * down / depth, depth], axis=-1)

    def inside(self, places: FloatArray) -> BoolArray:
        """[...] whether places [..., ≥ 2] (u, v) px lie in the picture."""
        u, v = places[..., 0], places[..., 1]
        return np.asarray((u >= 0.0) & (u < self.width) & (v >= 0.0) & (v < self.height))

    def footprint(self, up: float = HEAD_HEIGHT) -> FloatArray:
        """Corners [4, 2] (right, forward) m of the picture on the plane ``up`` m over the ground.

        In the order near left, near right, far right, far left; the far end is cut at `FARTHEST` camera heights.
        """
        half, drop = np.arctan(self.height / 2.0 / self.focal), self.mount_height - up
        reach = FARTHEST * self.mount_height
        near, far = (
            drop / np.tan(angle) if np.tan(angle) > drop / reach else reach
            for angle in (self.tilt + half, self.tilt - half)
        )
        ends = np.array([near, near, far, far])
        depth = ends * np.cos(self.tilt) + drop * np.sin(self.tilt)
        side = np.array([-1.0, 1.0, 1.0, -1.0]) * depth * self.width / 2.0 / self.focal
        return np.stack([side, ends], axis=-1)

    def middle_of_view(self) -> float:
        """Distance in m from the camera forward to the centre of `footprint`."""
        (_, near), (wide_near, _), (wide_far, far), _ = self.footprint()
        return float(near + (far - near) * (wide_near + 2.0 * wide_far) / (3.0 * (wide_near + wide_far)))


def camera_of(options: HeadOptions) -> SurveillanceCamera:
    """The camera of the options; raises VbbenchError if one is out of range."""
    with user_mistakes():
        check_ranges(options)
    return SurveillanceCamera(
        width=WIDTH,
        height=HEIGHT,
        focal=WIDTH / 2.0 / float(np.tan(np.radians(options.fov) / 2.0)),
        mount_height=options.camera_height,
        tilt=float(np.radians(options.tilt)),
    )


HEAD = 0.24
"""Diameter of a head in m."""
BELOW_TOP = 0.12
"""How far in m the centre of the head is below the top of the person."""
SAME_TRACK = 1.0
"""A person who is back in the picture within so many seconds keeps the track."""


@dataclass(frozen=True, kw_only=True)
class Heads:
    """Heads in the picture, by track and frame.

    Parameters
    ----------
    frame : [N] from 0.
    track : [N] from 1, in order of appearance; a person who returns later has a new one.
    person : [N] the person, a column of the scene.
    ground : [N, 2] (right, forward) in m of the person from the ground below the camera.
    places : [N, 2] centre (u, v) of the head in px from 0.
    sizes : [N, 2] width and height of the head in px.
    depth : [N] distance in m along the optical axis.
    """

    frame: IntArray
    track: IntArray
    person: IntArray
    ground: FloatArray
    places: FloatArray
    sizes: FloatArray
    depth: FloatArray

    def __post_init__(self) -> None:
        count = len(self.frame)
        freeze(self, np.int64, frame=(count,), track=(count,), person=(count,))
        freeze(self, ground=(count, 2), places=(count, 2), sizes=(count, 2), depth=(count,))

    def __len__(self) -> int:
        return len(self.frame)

    def sorted_by(self, *names: str) -> "Heads":
        """The same rows in another order; the first name counts most."""
        order = np.lexsort([getattr(self, name) for name in reversed(names)])
        return Heads(**{field.name: getattr(self, field.name)[order] for field in fields(self)})


def see_heads(
    positions: FloatArray,
    heights: FloatArray,
    camera: SurveillanceCamera,
    station: FloatArray,
    *,
    dt: float,
) -> Heads:
    """Every head whose centre is in the picture, hidden or not.

    Parameters
    ----------
    positions : [T, K, 2] of the people in m, NaN = absent.
    heights : [K] in m.
    station : [3] (x, y, yaw) of the camera in m and rad.
    """
    ground = world_to_relative(positions, station)
    up = np.broadcast_to(heights - BELOW_TOP, ground.shape[:2])
    seen = camera.project(np.concatenate([ground, up[..., None]], axis=-1))
    person, frame = np.nonzero(camera.inside(seen).T)
    rows = seen[frame, person]
    sizes = np.repeat(camera.focal * HEAD / rows[:, 2:], 2, axis=1)
    return Heads(
        frame=frame,
        track=_tracks(person, frame, round(SAME_TRACK / dt)),
        person=person,
        ground=ground[frame, person],
        places=rows[:, :2],
        sizes=sizes,
        depth=rows[:, 2],
    ).sorted_by("track", "frame")


def _tracks(person: IntArray, frame: IntArray, gap: int) -> IntArray:
    """[N] tracks of rows sorted by person and frame: a new one where a person was away for more than ``gap`` frames."""
    begins = np.ones(len(frame), dtype=np.bool_)
    begins[1:] = (np.diff(person) != 0) | (np.diff(frame) > gap + 1)
    first = np.flatnonzero(begins)
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.lexsort([person[first], frame[first]])] = np.arange(1, len(first) + 1)
    return np.asarray(rank[np.cumsum(begins) - 1])


SHOULDER_WIDTH = 0.46
"""Width of a body in m, from the shoulders down to the ground."""
BELOW_HEAD = 0.18
"""How far in m the shoulders are below the head's centre."""
LEAST_VISIBLE = 0.15
"""Smaller visible fractions count as 0."""
POLES, POLE_WIDTH, POLE_END = 3, 0.012, (0.4, 0.8)
"""Lamp posts from the top of the picture down: number, width in picture widths, range of lower ends in its heights."""
BOARD = (0.04, 0.06)
"""Width and height of a sign, as fractions of the picture's."""
_SIDE = 7
_GRID = np.stack(np.meshgrid(*[(np.arange(_SIDE) + 0.5) / _SIDE - 0.5] * 2), axis=-1).reshape(-1, 2)
_SPOTS = _GRID[np.hypot(_GRID[:, 0], _GRID[:, 1]) <= 0.5]
"""[S, 2] spots of a head, in its widths and heights from its centre."""


def draw_screens(camera: SurveillanceCamera, rng: np.random.Generator) -> FloatArray:
    """[P, 4] (left, top, width, height) in px of objects before the crowd: `POLES` and a board."""
    left = rng.uniform(0.0, 1.0 - POLE_WIDTH, POLES)
    poles = np.column_stack([left, np.zeros(POLES), np.full(POLES, POLE_WIDTH), rng.uniform(*POLE_END, POLES)])
    board = [*rng.uniform([0.0, 0.0], 1.0 - np.array(BOARD)), *BOARD]
    return np.asarray(np.vstack([poles, board]) * np.tile([float(camera.width), float(camera.height)], 2))


def visible_fractions(heads: Heads, heights: FloatArray, camera: SurveillanceCamera, screens: FloatArray) -> FloatArray:
    """[N] visible fraction of each head: 0, or `LEAST_VISIBLE` to 1.

    A nearer head hides its ellipse, and its body the strip of `SHOULDER_WIDTH` from shoulders to feet.

    Parameters
    ----------
    heads : from `see_heads`.
    heights : [N] in m of each head's centre over the ground.
    screens : [P, 4] (left, top, width, height) in px; they hide whatever is behind.
    """
    shoulders = camera.project(np.column_stack([heads.ground, heights - BELOW_HEAD]))
    feet = camera.project(np.column_stack([heads.ground, np.zeros(len(heads))]))
    shares = np.ones(len(heads))
    order = np.argsort(heads.frame, kind="stable")
    for rows in np.split(order, np.flatnonzero(np.diff(heads.frame[order])) + 1):
        spots = heads.places[rows, None] + heads.sizes[rows, None] * _SPOTS
        covered = _by_screens(screens, spots)
        hidden, hiding = _candidates(heads, feet, rows)
        if len(hidden):
            behind, nearer = spots[hidden], rows[hiding]
            each = _by_heads(heads, nearer, behind)
            each |= _by_bodies(shoulders[nearer], feet[nearer], camera.focal, behind)
            first = np.flatnonzero(np.diff(hidden, prepend=-1))
            covered[hidden[first]] |= np.logical_or.reduceat(each, first, axis=0)
        shares[rows] = 1.0 - covered.mean(axis=1)
    return np.where(shares < LEAST_VISIBLE, 0.0, shares)


def _by_screens(screens: FloatArray, spots: FloatArray) -> BoolArray:
    """Mask [P, S] of points ``spots`` [P, S, 2] in px that any of the ``screens`` [M, 4] covers."""
    covered = np.zeros(spots.shape[:2], dtype=np.bool_)
    for left, top, width, height in screens:
        across, down = spots[..., 0] - left, spots[..., 1] - top
        covered |= (across >= 0.0) & (across < width) & (down >= 0.0) & (down < height)
    return covered


def _candidates(heads: Heads, feet: FloatArray, rows: IntArray) -> tuple[IntArray, IntArray]:
    """Pairs among ``rows`` of one frame: the farther head, ascending, and a nearer one that may hide it."""
    u, v = heads.places[rows].T
    across, high = heads.sizes[rows].T
    left, right = np.minimum(u, feet[rows, 0]), np.maximum(u, feet[rows, 0])
    half = across * (SHOULDER_WIDTH / HEAD / 2.0)
    overlapping = (u[:, None] + across[:, None] > left - half) & (u[:, None] - across[:, None] < right + half)
    level = (v[:, None] + high[:, None] > v - high) & (v[:, None] - high[:, None] < feet[rows, 1])
    nearer = heads.depth[rows] < heads.depth[rows, None]
    hidden, hiding = np.nonzero(overlapping & level & nearer)
    return hidden, hiding


def _by_heads(heads: Heads, hiding: IntArray, spots: FloatArray) -> BoolArray:
    """Mask [P, S] of points ``spots`` [P, S, 2] in px that the heads ``hiding`` [P] cover."""
    offset = (spots - heads.places[hiding, None]) / heads.sizes[hiding, None]
    return np.asarray(np.hypot(offset[..., 0], offset[..., 1]) <= 0.5)


def _by_bodies(shoulders: FloatArray, feet: FloatArray, focal: float, spots: FloatArray) -> BoolArray:
    """Mask [P, S] of ``spots`` [P, S, 2] in px that bodies from ``shoulders`` to ``feet``, [P, 3] (u, v, Z), cover."""
    along = (spots[..., 1] - shoulders[:, None, 1]) / (feet - shoulders)[:, None, 1]
    middle = shoulders[:, None, 0] + along * (feet - shoulders)[:, None, 0]
    depth = shoulders[:, None, 2] + along * (feet - shoulders)[:, None, 2]
    across = np.abs(spots[..., 0] - middle) <= focal * SHOULDER_WIDTH / 2.0 / depth
    return np.asarray(across & (along >= 0.0) & (along <= 1.0))


KEY_EVERY = 5
"""Frames from one box drawn by hand to the next."""
CORRELATION = 0.5
"""Correlation of the errors of a box's width and height."""
SMALLEST = 0.2
"""No box is drawn smaller than this part of the head."""


def draw_boxes(heads: Heads, noise: float, rng: np.random.Generator) -> FloatArray:
    """Boxes [N, 4] (left, top, width, height) in px from 0, with errors.

    Key frames are every `KEY_EVERY`-th, the first and the last of each track. There, width and height each have a
    relative normal error, and each side of the box moves by it, the centre by half. The boxes between are interpolated;
    the errors of key boxes are enlarged so that those of all boxes have the deviation ``noise``.

    Parameters
    ----------
    heads : sorted by track and frame.
    noise : root mean square of the relative errors of widths, and of heights.
    """
    keys = _keys(heads)
    part = np.arange(KEY_EVERY) / KEY_EVERY  # most boxes are means of two, whose error is smaller
    spread = noise * float(1.0 / np.sqrt(np.mean(part**2 + (1.0 - part) ** 2)))
    errors = rng.standard_normal((len(keys), 5))
    factor = 1.0 + spread * (np.sqrt(CORRELATION) * errors[:, :1] + np.sqrt(1.0 - CORRELATION) * errors[:, 1:3])
    sizes = heads.sizes[keys] * np.maximum(factor, SMALLEST)
    corners = heads.places[keys] + 0.5 * spread * errors[:, 3:] * heads.sizes[keys] - sizes / 2.0
    return _joined(heads, keys, np.concatenate([corners, sizes], axis=1))


def _keys(heads: Heads) -> IntArray:
    """Rows that are key boxes."""
    begins = np.diff(heads.track, prepend=-1) != 0
    ends = np.append(begins[1:], True)
    return np.flatnonzero(begins | ends | (heads.frame % KEY_EVERY == 0))


def _joined(heads: Heads, keys: IntArray, boxes: FloatArray) -> FloatArray:
    """Boxes [N, 4] of all rows from those [M, 4] of the rows ``keys``."""
    rows = np.arange(len(heads))
    before = np.searchsorted(keys, rows, side="right") - 1
    after = np.minimum(before + (keys[before] != rows), len(keys) - 1)
    start, end = heads.frame[keys[before]], heads.frame[keys[after]]
    part = ((heads.frame - start) / np.maximum(end - start, 1))[:, None]
    return np.asarray((1.0 - part) * boxes[before] + part * boxes[after])


PEDESTRIAN, STATIC, IGNORE, ON_VEHICLE = 1, 2, 3, 4
"""Classes of MOTChallenge Head Tracking 21."""
_KINDS = np.repeat([STATIC, ON_VEHICLE, PEDESTRIAN, IGNORE], [4, 3, 5, 2])
"""Classes of what does not count: people who sit, people on vehicles, reflections, and regions to ignore."""


def draw_others(camera: SurveillanceCamera, frames: int, rng: np.random.Generator) -> FloatArray:
    """Rows [N, 9] of ``gt.txt`` that are not scored, each at one place of the picture in every frame; ids are from 1.

    Reflections have the class of pedestrians, and confidence 0.
    """
    count = len(_KINDS)
    sizes = np.where(_KINDS[:, None] == IGNORE, [camera.width / 8.0, camera.height / 20.0], 0.02 * camera.height)
    corners = rng.uniform(0.0, [camera.width, camera.height] - sizes) + 1.0
    columns = [1 + np.arange(count), *corners.T, *sizes.T, _KINDS != PEDESTRIAN, _KINDS, np.ones(count)]
    return np.column_stack([np.repeat(1 + np.arange(frames), count), np.tile(np.column_stack(columns), (frames, 1))])


def export_heads(
    dataset: Dataset, out: Path | str, options: HeadOptions, *, sequence: int | None = None, seed: int = 0
) -> Path:
    """Simulate a camera above the crowd of a sequence, and write its head boxes as a folder of Head Tracking 21.

    The folder holds ``seqinfo.ini`` and ``gt/gt.txt`` (9 columns, frames and boxes counted from 1), and next to them
    `TRUTH_TABLE` (frame from 0, track, person, right, forward, x, y in m, u, v, size in px, visible) and `TRUTH_FACTS`.
    All people of the scene are recorded, the observer included. The same options and seed give the same bytes.

    Parameters
    ----------
    out : folder to write; its name is the recording's.
    sequence : number of the sequence; may be omitted if there is only one.
    seed : seed of the annotators' errors, and of annotated objects other than people.
    """
    out, camera = Path(out), camera_of(options)
    if seed < 0:
        raise VbbenchError(f"seed must be at least 0, not {seed}")
    with loose_files(out):
        number, scene = _photographed(dataset, sequence)
        yaw = float(np.radians(options.facing))  # from its station the crowd is in the middle of the camera's view
        ahead = camera.middle_of_view() * np.array([np.cos(yaw), np.sin(yaw)])
        station = np.append(scene.positions[scene.present].mean(axis=0) - ahead, yaw)
        heads = see_heads(scene.positions, scene.heights, camera, station, dt=scene.dt)
        if not len(heads):
            raise VbbenchError("the camera sees nobody; choose another height, tilt or field of view")
        rng = np.random.default_rng(np.random.SeedSequence([seed, number]))
        boxes = draw_boxes(heads, options.box_noise, rng)
        screens = draw_screens(camera, rng)
        visible = visible_fractions(heads, scene.heights[heads.person] - BELOW_TOP, camera, screens)
        others = draw_others(camera, scene.frames, rng)
        write_text_atomically(out / "gt" / "gt.txt", _truth_text(heads, boxes, visible, others))
        info = sequence_info(out.name, scene.dt, scene.frames, (camera.width, camera.height), ".jpg")
        write_text_atomically(out / "seqinfo.ini", info)
        write_bytes_atomically(out / TRUTH_TABLE, _truth_table(heads, visible, scene))
        facts = {
            "dataset": dataset.info.id,
            "sequence": number,
            "seed": seed,
            "options": asdict(options),
            "camera": {**asdict(camera), "horizon": camera.horizon},
            "station": dict(zip(("x", "y", "yaw"), station.tolist(), strict=True)),
            "screens": screens.tolist(),
            "head": {"diameter": HEAD, "below_top": BELOW_TOP},
            **_counts(heads, boxes, visible, scene),
        }
        write_text_atomically(out / TRUTH_FACTS, json.dumps(facts, indent=2) + "\n")
    return out


def _photographed(dataset: Dataset, sequence: int | None) -> tuple[int, Scene]:
    """The number of the sequence, and its scene limited to the sequence's frames."""
    if sequence is None and len(dataset) > 1:
        raise VbbenchError(f"{dataset.folder} has {len(dataset)} sequences; choose the one to record")
    one = dataset.sequence(sequence or 0)
    people, positions, heights = dataset.scene(one.scene)
    frames = slice(one.first_frame, one.first_frame + one.frames)
    return one.index, Scene(
        name=dataset.info.split, dt=dataset.info.dt, people=people, positions=positions[frames], heights=heights
    )


def _truth_text(heads: Heads, boxes: FloatArray, visible: FloatArray, others: FloatArray) -> str:
    """The lines of ``gt.txt``, by track and frame; rows that do not count follow with further ids."""
    ones = np.ones(len(heads))
    drawn = boxes + np.array([1.0, 1.0, 0.0, 0.0])
    people = np.column_stack([heads.frame + 1, heads.track, drawn, ones, PEDESTRIAN * ones, visible])
    others = others + np.array([0, heads.track.max(), 0, 0, 0, 0, 0, 0, 0])
    line = "{:.0f},{:.0f},{:.2f},{:.2f},{:.2f},{:.2f},{:.0f},{:.0f},{:.2f}\n"
    return "".join(line.format(*row) for row in np.vstack([people, others]).tolist())


def _truth_table(heads: Heads, visible: FloatArray, scene: Scene) -> bytes:
    world = scene.positions[heads.frame, heads.person]
    columns = {
        "frame": heads.frame.astype(np.int32),
        "track": heads.track.astype(np.int32),
        "person": scene.people[heads.person].astype(np.int32),
        "right": heads.ground[:, 0],
        "forward": heads.ground[:, 1],
        "x": world[:, 0],
        "y": world[:, 1],
        "u": heads.places[:, 0],
        "v": heads.places[:, 1],
        "size": heads.sizes[:, 1],
        "visible": visible,
    }
    sink = io.BytesIO()
    pq.write_table(pa.table(columns), sink, compression="zstd")
    return sink.getvalue()


def _counts(heads: Heads, boxes: FloatArray, visible: FloatArray, scene: Scene) -> dict[str, float]:
    """The size of the recording, and the error of its boxes."""
    errors = boxes[:, 2:] / heads.sizes - 1.0
    return {
        "tracks": int(heads.track.max()),
        "people": len(np.unique(heads.person)),
        "boxes": len(heads),
        "hidden": int(np.sum(visible == 0.0)),
        "frames": scene.frames,
        "dt": scene.dt,
        "box_error": float(np.sqrt(np.mean(errors**2))),
    }
