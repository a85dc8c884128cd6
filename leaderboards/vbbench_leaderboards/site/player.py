"""The player in a site: which sequences it shows, their pictures, and the files that it reads.

It reads an index per split, a file per sequence and tier, and a file per sequence and solver.
"""

import base64
import shutil
import zlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vbbench.camera import Camera
from vbbench.errors import VbbenchError
from vbbench.estimate import Estimate
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import INFO_FILE
from vbbench.files.submission import SUBMISSION_FILE
from vbbench.files.submission_tables import SubmittedEstimates
from vbbench.folders.work_folder import WorkFolder
from vbbench.geometry import FloatArray, IntArray, relative_to_world, world_to_relative
from vbbench.parallel.parts import check_jobs, in_parallel
from vbbench.pictures.backdrop import Backdrop
from vbbench.pictures.colours import PEOPLE_ON_DARK, PEOPLE_ON_LIGHT, person_slots
from vbbench.pictures.rendering import Backend, open_renderer, pictures, scene_of
from vbbench.protocol import get_protocol
from vbbench.sequence import Sequence, Truth
from vbbench_leaderboards.results.boards import HEADLINE_PROTOCOL, HEADLINE_TIER
from vbbench_leaderboards.results.folder import Boards, dataset_folder, submission_folder
from vbbench_leaderboards.results.result import Board, Result
from vbbench_leaderboards.site.words import provided

FOLDER = Path("data", "player")
"""Where the data lie in a site."""

WIDTH = 640
"""Width of a picture in px; one that the camera took is wider if it would be lower than `_LEAST_HEIGHT`."""

_LEAST_HEIGHT, _QUALITY = 160, 70
_CHOSEN_BY = ("dx", "dx_rel", "dt")
"""Figures by which sequences are chosen: the first that the truth allows."""

_INDEXED, _CAPPED = ("dx", "dt"), ("dx", "dt", "dr")

METRE, RADIAN, PIXEL = 1e-3, 1e-4, 0.1
"""To which places (m), headings (rad) and boxes (px) are rounded."""

ABOVE, BELOW = 60.0, 190.0
"""Rows above and below the horizon that are shown of a picture that closes on itself, in px."""

HORIZON_POINTS = 33
"""At so many columns the row of the horizon stands where it is not level, from the left border to the right one."""

LARGEST = 100_000_000
"""Quanta beyond which a number is cut off, so that its changes fit into 32 bits; 100 km in mm."""


@dataclass(frozen=True, kw_only=True)
class Films:
    """What the player is to show.

    Parameters
    ----------
    work : work folder of ``vbbench leaderboard rerun``, with datasets and submissions.
    sequences : at most so many of a split.
    pictures : who draws pictures to stand behind the boxes, into ``work``; by default those that are there are shown.
    footage : put small copies of the pictures that a camera took into ``work``.
    jobs : processes.
    """

    work: Path
    sequences: int = 24
    pictures: Backend | None = None
    footage: bool = False
    jobs: int = 1

    def __post_init__(self) -> None:
        check_jobs(self.jobs)


Playable = tuple[str, Boards, Mapping[str, Dataset]]
"""A split, its boards whose dataset, with its truth, and submissions are at hand, and tier → dataset."""


def write_player(site: Path, results: Boards, films: Films | None) -> dict[Board, tuple[str, ...]]:
    """Write the player's data into a site, of all that lies in the work folder.

    Raises VbbenchError if what lies in the work folder is not what the results are of, or cannot be read.

    Parameters
    ----------
    site : folder of the site.
    results : the results on the page, by board.
    films : which sequences can be played; ``None`` writes no data.

    Returns
    -------
    The boards that can be played, each with its solvers.
    """
    if films is None or films.sequences < 1:
        return {}
    playable = list(find_playable(films.work, results))
    for _ in in_parallel(partial(_write_split, site, films), playable, films.jobs):
        pass
    return {board: tuple(row.solver for row in rows) for _, boards, _ in playable for board, rows in boards.items()}


def find_playable(work: Path, boards: Boards) -> Iterator[Playable]:
    """The splits of which something can be played; raises VbbenchError where a dataset is not that of the results."""
    for split in sorted({board.split for board in boards}):
        datasets: dict[str, Dataset] = {}
        kept: dict[Board, tuple[Result, ...]] = {}
        for board in sorted(board for board in boards if board.split == split):
            folder = dataset_folder(work, board.split, board.tier)
            answers = {
                row.solver: submission_folder(work, board, row.solver) / SUBMISSION_FILE for row in boards[board]
            }
            there = tuple(row for row in boards[board] if answers[row.solver].is_file())
            if not there or not (folder / INFO_FILE).is_file():
                continue
            dataset = datasets.get(board.tier) or Dataset(folder)
            if not dataset.has_truth:
                continue
            for result in there:
                if result.dataset != dataset.info.id:
                    problem = f"{folder} is dataset {dataset.info.id}, {result.path} is of {result.dataset}"
                    way_out = "run 'vbbench leaderboard rerun' again, or build without --work"
                    raise VbbenchError(f"{problem}; {way_out}")
            datasets[board.tier], kept[board] = dataset, there
        if kept:
            yield split, kept, datasets


def choose_sequences(results: Boards, count: int, available: int) -> IntArray:
    """Numbers of at most ``count`` sequences, ascending, for all boards of a split.

    They lie evenly over the order of the middle solver's Δx, or where there is none Δx̃ or Δt; the smallest and the
    largest are among them.

    Parameters
    ----------
    results : the boards of one split.
    count : how many are wanted.
    available : number of sequences in the dataset.
    """
    rows = results[min(results, key=lambda one: (one.protocol != HEADLINE_PROTOCOL, one.tier != HEADLINE_TIER, one))]
    means = {row.solver: row.score["metrics"] for row in rows}
    metric = next((name for name in _CHOSEN_BY if means[rows[0].solver][name]["mean"] is not None), _CHOSEN_BY[0])
    ranked = sorted(rows, key=lambda row: (means[row.solver][metric]["mean"] or 0.0, row.solver))
    own = ranked[(len(ranked) - 1) // 2].per_sequence
    usable = np.isfinite(own.figures[metric]) & (own.sequence < available)
    numbers, errors = own.sequence[usable], own.figures[metric][usable]
    order = numbers[np.lexsort((numbers, errors))]
    places = np.unique(np.rint(np.linspace(0, len(order) - 1, min(count, len(order)))).astype(np.int64))
    return np.sort(order[places])


def _write_split(site: Path, films: Films, split: str, boards: Boards, tiers: Mapping[str, Dataset]) -> None:
    work, first = films.work, next(iter(tiers.values()))
    chosen = choose_sequences(boards, films.sequences, min(map(len, tiers.values())))
    if films.footage or films.pictures is not None:
        make_pictures(first, split, chosen.tolist(), work, None if films.footage else films.pictures)
    counts = copy_pictures(work, site, split, chosen)
    write_data(site, split, split_index(split, boards, first, chosen, counts))
    for tier, dataset in tiers.items():
        sequences = [dataset.sequence(number) for number in chosen.tolist()]
        clips = [(sequence, shown_truth(dataset, sequence)) for sequence in sequences]
        for sequence, truth in clips:
            values = encode_clip(dataset.camera(sequence), dataset.info.dt, sequence, truth)
            write_data(site, f"{split}/{tier}/{sequence.index}", values)
        for board, solver in (
            (board, row.solver) for board, own in boards.items() if board.tier == tier for row in own
        ):
            submitted = SubmittedEstimates(dataset, submission_folder(work, board, solver))
            for sequence, truth in clips:
                values = encode_estimate(truth, shown_estimate(dataset, submitted.of(sequence)))
                write_data(site, f"{board.key}/{sequence.index}/{solver}", values)


def split_index(
    split: str, boards: Boards, dataset: Dataset, chosen: IntArray, counts: Mapping[str, int]
) -> dict[str, Any]:
    """The index of a split as the page gets it, of the ``chosen`` sequences [S]; sequence → number of its pictures."""
    truth = dataset.info.truth
    columns = {"sequences": "sequence", "frames": "frames", "people": "people"}
    return {
        "split": split,
        "truth": truth,
        "palette": {"light": PEOPLE_ON_LIGHT, "dark": PEOPLE_ON_DARK},
        **{name: dataset.rows[column][chosen].tolist() for name, column in columns.items()},
        "pictures": dict(counts),
        "boards": {
            f"{board.protocol}-{board.tier}": {
                "tier": board.tier,
                "given": get_protocol(board.protocol).given,
                "caps": {name: get_protocol(board.protocol).caps[name] for name in _CAPPED},
                "solvers": {row.solver: _figures(row, chosen, relative=truth == "relative") for row in rows},
            }
            for board, rows in boards.items()
        },
    }


def _figures(result: Result, chosen: IntArray, *, relative: bool) -> dict[str, list[float | None]]:
    """A solver's figures in the chosen sequences, None where it has none; seen from the camera, Δx̃ stands for Δx."""
    own = result.per_sequence
    place = np.searchsorted(own.sequence, chosen).clip(max=len(own.sequence) - 1)
    there, found = own.sequence[place] == chosen, dict[str, list[float | None]]()
    for name in _INDEXED:
        figures = np.where(there, own.figures["dx_rel" if relative and name == "dx" else name][place], np.nan)
        found[name] = [round(value, 4) if np.isfinite(value) else None for value in figures.tolist()]
    return found


def picture_folder(work: Path, split: str, number: int) -> Path:
    """Where the pictures of a sequence lie in a work folder: ``00000.jpg`` and so on, one per frame."""
    return work / "pictures" / split / str(number)


def copy_pictures(work: Path, site: Path, split: str, chosen: IntArray) -> dict[str, int]:
    """Copy the pictures of the chosen sequences into a site; sequence → how many there are."""
    counts: dict[str, int] = {}
    for number in map(int, chosen):
        files = sorted(picture_folder(work, split, number).glob("[0-9]*.jpg"))
        target = picture_folder(site / FOLDER, split, number)
        for file in files:
            target.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(file, target / file.name)
        if files:
            counts[str(number)] = len(files)
    return counts


def make_pictures(dataset: Dataset, split: str, chosen: Iterable[int], work: Path, backend: Backend | None) -> None:
    """Put pictures of the chosen sequences into the work folder, those that are there already left alone.

    Raises VbbenchError if the truth is withheld, the backend cannot work here, or a file is no picture.

    Parameters
    ----------
    backend : who renders them; ``None`` for small copies of those that the camera took. Frames without one have a
        plain ground; sequences without any have no pictures.
    """
    for number in chosen:
        folder, sequence = picture_folder(work, split, number), dataset.sequence(number)
        if folder.is_dir():
            continue
        if backend is None:
            backdrop = Backdrop(dataset, sequence, widest=WIDTH, least=_LEAST_HEIGHT)
            if backdrop.is_recorded:
                _fill(folder, map(backdrop.picture, range(sequence.frames)))
        else:
            with open_renderer(backend, scene_of(dataset, sequence.scene)) as renderer:
                _fill(folder, (_small(picture.rgb) for picture in pictures(dataset, sequence, renderer)))


def _fill(folder: Path, frames: Iterable[NDArray[np.uint8]]) -> None:
    """Make a folder of JPEGs."""
    from PIL import Image

    with WorkFolder(folder) as place:
        place.begin()
        place.new.mkdir()
        for frame, rgb in enumerate(frames):
            Image.fromarray(rgb).save(place.new / f"{frame:05d}.jpg", quality=_QUALITY, optimize=True)
        place.publish()


def _small(rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
    from PIL import Image

    height, width = rgb.shape[:2]
    return np.asarray(Image.fromarray(rgb).resize((WIDTH, round(height * WIDTH / width)), Image.Resampling.LANCZOS))


def write_data(site: Path, name: str, values: dict[str, Any]) -> None:
    """Write one data file, which the page reads by its name; no site ever shows one that is half-written."""
    path = site / FOLDER / f"{name}.js"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(provided(f"player/{name}", values), encoding="utf-8")


def encode_clip(camera: Camera, dt: float, sequence: Sequence, truth: Truth) -> dict[str, Any]:
    """What is published of a sequence, and its truth.

    ``data`` holds, as `pack` has it, x, y, yaw of the observer, x, y of the people where they are known, u, v, l of the
    boxes, and a number where `sequential` gives a position.
    """
    given = sequence.given.positions[..., 0]
    boxes = [pack(column, PIXEL) for column in np.moveaxis(sequence.observations, -1, 0)]
    columns = [*_places(truth.poses, truth.positions, truth), *boxes, pack(0.0 * given, 1.0)]
    return {
        "frames": sequence.frames,
        "dt": dt,
        "picture": picture_of(camera),
        "tracks": sequence.tracks.tolist(),
        "colours": person_slots(camera, sequence, truth).tolist(),
        "origin": _origin(truth).tolist(),
        "data": as_text(columns),
    }


def picture_of(camera: Camera) -> dict[str, Any]:
    """What the player draws of a camera, whatever its model.

    ``width``, and ``top`` and ``height`` of the rows that are shown, in px; ``round``, whether the picture closes on
    itself; ``horizon``, its rows at columns evenly from border to border; ``view``, the azimuths of left and right
    border in rad clockwise from forward, or None.
    """
    width, height = camera.picture_size
    horizon = camera.horizon(np.linspace(0.0, width, HORIZON_POINTS))
    if np.ptp(horizon) == 0.0:
        horizon = horizon[:2]
    top, bottom = 0.0, float(height)
    if camera.period is not None:
        top, bottom = float(horizon.min()) - ABOVE, float(horizon.max()) + BELOW
    return {
        "width": width,
        "top": top,
        "height": bottom - top,
        "round": camera.period is not None,
        "horizon": np.round(horizon, 2).tolist(),
        "view": camera.view,
    }


def shown_truth(dataset: Dataset, sequence: Sequence) -> Truth:
    """What the player shows as true.

    Where people's places are known relative to the camera only, the camera stands at the origin of truth and estimates.
    """
    if dataset.info.truth != "relative":
        return dataset.truth(sequence)
    poses, places = np.zeros((sequence.frames, 3)), dataset.relative_truth(sequence)
    heights = np.full(len(sequence.tracks), np.nan)
    return Truth(poses=poses, positions=relative_to_world(places, poses), heights=heights)


def shown_estimate(dataset: Dataset, estimate: Estimate) -> Estimate:
    """What the player shows of an answer; see `shown_truth`."""
    if dataset.info.truth != "relative":
        return estimate
    places = world_to_relative(estimate.positions, estimate.poses)
    return Estimate(
        poses=np.full(estimate.poses.shape, np.nan),
        positions=relative_to_world(places, np.zeros(estimate.poses.shape)),
    )


def encode_estimate(truth: Truth, estimate: Estimate) -> dict[str, Any]:
    """A solver's estimate: ``data`` holds x, y, yaw of the observer, then x, y of the people, as in `encode_clip`."""
    return {"data": as_text([*_places(estimate.poses, estimate.positions, truth)])}


def _places(poses: FloatArray, positions: FloatArray, truth: Truth) -> Iterator[IntArray]:
    origin = _origin(truth)
    for axis in (0, 1):
        yield pack(poses[:, None, axis] - origin[axis], METRE)
    yield pack(poses[:, None, 2], RADIAN)
    for axis in (0, 1):
        yield pack(positions[..., axis] - origin[axis], METRE)


def _origin(truth: Truth) -> FloatArray:
    """A place [2] at whole metres near the start, so that places far from a map's origin are small numbers, too."""
    return np.rint(truth.poses[0, :2])


def pack(values: FloatArray, quantum: float) -> IntArray:
    """Numbers [K * T] of the values [T, K], track after track: 0 where there is none that is finite.

    Elsewhere a number is one more than the zig-zag of the change since the last one, in quanta.
    """
    there = np.isfinite(values.T)
    steps = np.clip(np.rint(values.T[there] / quantum), -LARGEST, LARGEST).astype(np.int64)
    changes, numbers = np.diff(steps, prepend=0), np.zeros(there.shape, np.int64)
    numbers[there] = ((changes << 1) ^ (changes >> 63)) + 1
    return numbers.ravel()


def as_text(columns: list[IntArray]) -> str:
    """Numbers on end, column after column, as base64: the lowest byte of every number, then every second, and so on."""
    numbers = np.concatenate(columns).astype("<u4")
    coder = zlib.compressobj(9, wbits=-15)
    data = coder.compress(numbers.view(np.uint8).reshape(-1, 4).T.tobytes()) + coder.flush()
    return base64.b64encode(data).decode("ascii")
