"""Whether committed results still hold: every file of a folder is checked, and all faults are found at once.

Figures are kept to float32, half a unit in the eighth digit; a recount must agree to a relative `ROUNDING`.
"""

import contextlib
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.errors import FileError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import INFO_FILE, DatasetInfo
from vbbench.files.submission import SUBMISSION_FILE, SubmissionInfo
from vbbench.geometry import FloatArray
from vbbench.parallel.parts import progress_bar
from vbbench.protocol import get_protocol
from vbbench.scoring import score
from vbbench.scoring.metrics import METRICS
from vbbench.scoring.scorecard import known, summarise
from vbbench_leaderboards.results.boards import SINGLE_PRECISION
from vbbench_leaderboards.results.dataset_record import BoardDataset
from vbbench_leaderboards.results.folder import read_datasets, read_results, record_paths, result_paths
from vbbench_leaderboards.results.result import Result, file_hashes, history_faults

ROUNDING = 1e-6
TOLERANCE, SINGLE_TOLERANCE = 1e-6, 1e-4
"""How far a figure scored again may lie from the committed one, in m or rad, or relative where it is larger than one;
and that of solvers in single precision, whose last digits depend on the processor."""

_LISTED = 5
_NOT_COMPARED = ("solver_version", "seconds_per_frame")


class ResultsError(VbbenchError):
    """Result files with faults; every one of them is listed."""

    def __init__(self, results: Path, faults: Iterable[str]) -> None:
        self.faults = tuple(faults)
        listing = (f"  {n}. {fault}" for n, fault in enumerate(self.faults, 1))
        super().__init__(f"{results}: {_count(len(self.faults), 'fault')}", *listing)


def check(
    results: Path, *, work: Path | None = None, datasets: Sequence[Path] = (), submissions: Sequence[Path] = ()
) -> str:
    """Check every file below ``results``; return what was checked, as one line of text.

    Raises ResultsError with every fault of every file.

    Parameters
    ----------
    work : work folder of ``rerun``; results whose submission is there, or is named, are scored again.
    datasets, submissions : more folders to score again with.
    """
    unusable: list[FileError] = []
    records = read_datasets(results, unusable=unusable)
    boards = read_results(results, records=records, unusable=unusable)
    usable = [result for rows in boards.values() for result in rows]
    at_hand = _datasets_at_hand(work, datasets)
    faults = [*_misplaced(results), *map(str, unusable)]
    for record in records.values():
        again = record_faults(record, at_hand[record.id]) if record.id in at_hand else ()
        faults += [f"{results / record.path}: {fault}" for fault in (*_contradictions(record), *again)]
    for result in usable:
        record = records[result.board.split, result.board.tier]
        own = (*count_faults(result, record), *history_faults(result.history, result.about.date))
        faults += [f"{results / result.path}: {fault}" for fault in (*own, *summary_faults(result))]
    faults += _unmatched(usable, submissions, at_hand)
    below = sorted(work.glob(f"submissions/*/*/*/{SUBMISSION_FILE}")) if work else []
    folders = [*submissions, *(path.parent for path in below if not path.parent.suffix)]
    rescored = list(_rescored(usable, folders, at_hand))
    for result, found in rescored:
        faults += [f"{results / result.path}: scores differently now: {fault}" for fault in found]
    if faults:
        raise ResultsError(results, faults)
    counts = f"{_count(len(usable), 'result')} on {_count(len(boards), 'board')}"
    return f"{results}: {counts} checked, no faults; {len(rescored)} scored again"


def _misplaced(results: Path) -> Iterator[str]:
    """Misplaced JSON files, names that are equal on some disks, or an empty folder."""
    placed = {*record_paths(results), *result_paths(results)}
    if not placed:
        yield f"{results}: no result is here; vbbench leaderboard add writes them"
    for path in sorted(path.relative_to(results) for path in results.rglob("*.json")):
        if path not in placed:
            yield f"{results / path}: is neither where a result nor where a record belongs; move or remove it"
    names = defaultdict(list)
    for path in sorted(placed):
        names[str(path).casefold()].append(path)
    for path in (path for _, *others in names.values() for path in others):
        yield f"{results / path}: differs from another file only in capitals; rename one"


def _contradictions(record: BoardDataset) -> Iterator[str]:
    """Where a record contradicts itself."""
    own = {"id": record.id, "split": record.split, "tier": record.tier, "camera": record.camera["kind"]}
    for name, value in own.items():
        if record.counts[name] != value:
            yield f"$.counts.{name}: is {record.counts[name]!r}, the record is of {value!r}"
    for protocol, part in record.scored.items():
        ascending = bool((part.sequence[1:] > part.sequence[:-1]).all())
        if not ascending or part.sequence[-1] >= record.counts["sequences"] or part.frames.min() < 1:
            yield f"$.scored.{protocol}: is not a list of the dataset's scored sequences"


def _datasets_at_hand(work: Path | None, named: Sequence[Path]) -> dict[str, Path]:
    """Dataset folders by id: those named, and those of the work folder that can be read."""
    found = {}
    for path in sorted(work.glob(f"datasets/*/{INFO_FILE}")) if work else []:
        with contextlib.suppress(VbbenchError):
            found[DatasetInfo.read(path.parent).id] = path.parent
    return found | {DatasetInfo.read(folder).id: folder for folder in named}


def _rescored(
    results: Sequence[Result], submissions: Iterable[Path], datasets: dict[str, Path]
) -> Iterator[tuple[Result, list[str]]]:
    """Results whose submission and dataset are available, with what scores differently now."""
    pairs = [(one, folder) for folder in submissions for one in _made_of(folder, results) if one.dataset in datasets]
    with progress_bar(len(pairs), "score again", unit="result") as bar:
        for result, folder in pairs:
            try:
                again = score(folder, datasets[result.dataset], sequences=result.per_sequence.sequence)
                yield result, drift(result, Result.of(again, folder, result.about, name=result.solver))
            except VbbenchError as error:
                yield result, [f"{folder} cannot be scored again: {error}"]
            bar.update()


def _unmatched(results: Sequence[Result], named: Iterable[Path], datasets: dict[str, Path]) -> Iterator[str]:
    """Why a named submission cannot be scored again."""
    for folder in named:
        found = _made_of(folder, results)
        if not found:
            yield f"{folder}: no result has its tables; add it with 'vbbench leaderboard add'"
        elif not any(result.dataset in datasets for result in found):
            yield f"{folder}: its dataset {found[0].dataset} is not available; name its folder, too"


def _made_of(folder: Path, results: Sequence[Result]) -> list[Result]:
    """The results that a submission's tables gave."""
    try:
        own = file_hashes(folder), SubmissionInfo.read(folder)
    except VbbenchError:
        return []
    key = own[0], own[1].dataset, own[1].protocol
    return [one for one in results if (one.submission, one.dataset, one.board.protocol) == key]


def count_faults(result: Result, record: BoardDataset) -> Iterator[str]:
    """Faults of all but the summaries: differences from the record, missing sequences, counts and coverage."""
    own, score = result.per_sequence, result.score
    yield from _unequal(
        {
            "dataset.camera": (result.camera, record.camera["kind"]),
            "dataset.seed": (result.seed, record.seed),
            "score.dataset": (score["dataset"], result.dataset),
            "score.split": (score["split"], result.board.split),
            "score.protocol": (score["protocol"], result.board.protocol),
            "score.protocol_version": (score["protocol_version"], get_protocol(result.board.protocol).version),
            "score.solver": (score["solver"], result.solver),
            "score.solver_version": (score["solver_version"], result.version),
            "score.caution": (score.get("caution"), record.caution),
            "score.sequences_in_dataset": (score["sequences_in_dataset"], record.counts["sequences"]),
        }
    )
    rows = list(_row_faults(result, record))
    yield from rows
    if rows:
        return
    frames, positions = int(own.frames.sum()), int(own.positions.sum())
    posed, placed = int(own.posed.sum()) / frames, int(own.placed.sum()) / positions if positions else 1.0
    yield from _unequal(
        {
            "score.sequences": (score["sequences"], len(own.sequence)),
            "score.frames": (score["frames"], frames),
            "score.positions": (score["positions"], positions),
            "score.pose_coverage": (score["pose_coverage"], posed),
            "score.position_coverage": (score["position_coverage"], placed),
            "score.coverage": (score["coverage"], min(posed, placed)),
        }
    )
    if (score["fallback_frames"] or 0) > frames:
        yield f"$.score.fallback_frames: is {score['fallback_frames']}, more than the {frames} scored frames"
    yield from _figure_faults(result, record)


def _row_faults(result: Result, record: BoardDataset) -> Iterator[str]:
    """Where the sequences of a result, or their counts, are not those that its board scores."""
    if result.board.protocol not in record.scored:
        yield f"$.protocol: {record.path} is older than {result.board.protocol}; remove it and add its results again"
        return
    own, wanted = result.per_sequence, record.scored[result.board.protocol]
    lacking, strange = np.setdiff1d(wanted.sequence, own.sequence), np.setdiff1d(own.sequence, wanted.sequence)
    for words, numbers in (("lacks", lacking), ("has, and the board does not,", strange)):
        if len(numbers):
            yield f"$.per_sequence: {words} {_some(numbers)}; solve and score the whole dataset"
    if not np.array_equal(own.sequence, wanted.sequence):
        if len(own.sequence) == len(wanted.sequence) or not (len(lacking) or len(strange)):
            yield "$.per_sequence: sequences are not in order, each once"
        return
    for name, theirs in vars(wanted).items():
        mine = getattr(own, name)
        if not np.array_equal(mine, theirs):
            yield f"$.per_sequence: {name} differs from the board's in {_some(own.sequence[mine != theirs])}"
    for name, part, whole in (("posed", own.posed, own.frames), ("placed", own.placed, own.positions)):
        short = part != whole if result.score["failure_policy"] == "refuse" else part > whole
        if short.any():
            yield f"$.per_sequence: {name} does not go with the failure policy in {_some(own.sequence[short])}"


def _figure_faults(result: Result, record: BoardDataset) -> Iterator[str]:
    """Figures where there can be none, missing ones, and those larger than their metric allows."""
    own, second = result.per_sequence, max(1, round(1.0 / record.dt)) * record.dt
    for name, figures in own.figures.items():
        metric = METRICS[name]
        there = own.positions > 0 if metric.over == "people" else own.frames > 0
        wrong = ~there & np.isfinite(figures) if metric.over == "people" else np.zeros(len(figures), bool)
        if metric.over != "seconds":
            wrong |= there & np.isnan(figures)
        wrong |= figures > {"rad": np.pi, "rad/s": np.pi / second}.get(metric.unit, np.inf) * (1 + ROUNDING)
        if wrong.any():
            yield f"$.per_sequence: {name} has impossible values in {_some(own.sequence[wrong])}"


def summary_faults(result: Result) -> Iterator[str]:
    """The summaries of a result that do not follow from its per-sequence figures."""
    own, protocol = result.per_sequence, get_protocol(result.board.protocol)
    summaries = summarise(own.timeline, protocol, own.figures, own.figures)
    for name, metric in METRICS.items():
        kept, fresh = result.score[metric.section][name], summaries[name].to_dict()
        for fault in (*_metric_faults(kept, fresh), *_frame_faults(kept, own.figures[name], own.frames, metric.over)):
            yield f"$.score.{metric.section}.{name}.{fault}"


def _metric_faults(kept: dict[str, Any], fresh: dict[str, Any]) -> Iterator[str]:
    for key in ("capped", "failure_rate", "mean", "std", "median", "p95", "blocks"):
        if not _close(kept[key], fresh[key], abs(fresh["mean"] or 0.0) if key == "std" else 0.0):
            yield _differs(key, kept[key], fresh[key])
    for key, end in (("capped_ci95", 0), ("capped_ci95", 1), ("ci95", 0), ("ci95", 1)):
        if not _close(kept[key][end], fresh[key][end]):
            yield _differs(f"{key}[{end}]", kept[key][end], fresh[key][end])


def _frame_faults(kept: dict[str, Any], figures: FloatArray, frames: FloatArray | Any, over: str) -> Iterator[str]:
    """Faults of the mean over frames, which follows where every frame has a figure, and of its spread.

    The spread is at least that of sequences. Of people and drift only whether there is any figure follows.
    """
    if over != "frames":
        for key in ("frame_mean", "frame_std"):
            if (kept[key] is None) != (not len(known(figures))):
                yield f"{key}: is {kept[key]}, which contradicts the per-sequence figures"
        return
    mean = float(np.average(figures, weights=frames))
    least = float(np.sqrt(np.average((figures - mean) ** 2, weights=frames)))
    if not _close(kept["frame_mean"], mean):
        yield _differs("frame_mean", kept["frame_mean"], mean)
    if kept["frame_std"] is None or kept["frame_std"] < least - ROUNDING * (least + mean):
        yield f"frame_std: is {kept['frame_std']}, the per-sequence figures alone spread by {least!r}"


def drift(old: Result, new: Result) -> list[str]:
    """Where two results of a solver on a board differ by more than the tolerance, one per line.

    Versions, times and descriptions are not compared.
    """
    tolerance = tolerance_of(new.solver)
    before, after = (
        {name: value for name, value in result.score.items() if name not in _NOT_COMPARED} for result in (old, new)
    )
    found = _value_differences(before, after, "score", tolerance)
    columns = [
        {name: getattr(rows, name) for name in vars(rows) if name != "figures"} | dict(rows.figures)
        for rows in (old.per_sequence, new.per_sequence)
    ]
    for name in dict.fromkeys([*columns[0], *columns[1]]):
        found += _column_differences(f"per_sequence.{name}", columns[0].get(name), columns[1].get(name), tolerance)
    return found


def tolerance_of(solver: str) -> float:
    """How far figures of a solver may lie from those that were committed."""
    return SINGLE_TOLERANCE if solver in SINGLE_PRECISION else TOLERANCE


def _value_differences(old: Any, new: Any, name: str, tolerance: float) -> list[str]:
    if isinstance(old, dict) and isinstance(new, dict):
        keys = dict.fromkeys([*old, *new])
        return [
            line for key in keys for line in _value_differences(old.get(key), new.get(key), f"{name}.{key}", tolerance)
        ]
    if isinstance(old, (list, tuple)) and isinstance(new, (list, tuple)) and len(old) == len(new):
        pairs = enumerate(zip(old, new, strict=True))
        return [line for n, pair in pairs for line in _value_differences(*pair, f"{name}[{n}]", tolerance)]
    both = isinstance(old, float) and isinstance(new, (int, float))
    same = abs(old - new) <= tolerance * max(1.0, abs(old)) if both else old == new
    return [] if same else [f"{name}: was {old!r}, is {new!r}"]


def _column_differences(name: str, old: FloatArray | None, new: FloatArray | None, tolerance: float) -> list[str]:
    if old is None or new is None or len(old) != len(new):
        counts = ["none" if column is None else f"{len(column)} values" for column in (old, new)]
        return [f"{name}: was {counts[0]}, is {counts[1]}"]
    far = np.abs(old - new)
    apart = far > tolerance * np.maximum(1.0, np.abs(old)) if old.dtype.kind == "f" else far > 0
    rows = np.flatnonzero(apart | (np.isnan(old) != np.isnan(new)))
    if not len(rows):
        return []
    worst = rows[np.nan_to_num(far[rows], nan=np.inf).argmax()]
    return [f"{name}: {len(rows)} of {len(old)} differ, most row {worst}: was {old[worst]}, is {new[worst]}"]


def record_faults(record: BoardDataset, folder: Path) -> Iterator[str]:
    """Where a dataset differs from its record.

    The bytes of tables depend on the library that wrote them; they must agree only if truth is withheld. The seed may
    then have been published since.
    """
    opened = Dataset(folder)
    if not opened.has_truth:
        return
    fresh, loose = vars(BoardDataset.of(opened)), ("tables",) if record.seed is not None else ("seed", "command")
    for name, value in fresh.items():
        if name != "scored" and value != vars(record)[name] and name not in loose:
            yield f"$.{name}: is {vars(record)[name]!r}, {folder} gives {value!r}"
    for protocol, recorded in record.scored.items():
        for column, numbers in vars(fresh["scored"][protocol]).items():
            if not np.array_equal(getattr(recorded, column), numbers):
                yield f"$.scored.{protocol}: {column} are not those that {folder} gives"


def _close(kept: float | None, fresh: float | None, scale: float = 0.0) -> bool:
    if kept is None or fresh is None:
        return kept is fresh
    return abs(kept - fresh) <= ROUNDING * max(abs(fresh), scale) + 1e-12


def _unequal(pairs: dict[str, tuple[Any, Any]]) -> Iterator[str]:
    yield from (f"$.{_differs(name, kept, wanted)}" for name, (kept, wanted) in pairs.items() if kept != wanted)


def _differs(name: str, kept: Any, wanted: Any) -> str:
    return f"{name}: is {kept!r}, must be {wanted!r}"


def _some(numbers: FloatArray | Any) -> str:
    listed = ", ".join(str(number) for number in numbers[:_LISTED])
    more = f" and {len(numbers) - _LISTED} more" if len(numbers) > _LISTED else ""
    return f"sequence{'s' if len(numbers) > 1 else ''} {listed}{more}"


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"
