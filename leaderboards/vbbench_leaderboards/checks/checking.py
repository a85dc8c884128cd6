"""Checks a folder of results: every file, and all faults of all files at once."""

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
from vbbench_leaderboards.results.result import Result, history_faults, table_hashes


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

    Parameters
    ----------
    work : work folder of ``rerun``; results whose submission is there, or is named, are scored again.
    datasets, submissions : more folders to score again with.

    Raises
    ------
    ResultsError
        With every fault of every file.
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
        faults += [f"{results / result.path}: {fault}" for fault in own]
    faults += [f"{results / result.path}: {fault}" for result, fault in summary_faults(usable)]
    faults += _unmatched(usable, submissions, at_hand)
    rescored = list(_rescored(usable, _submissions_at_hand(work, submissions), at_hand))
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
    for _, *others in names.values():
        for path in others:
            yield f"{results / path}: differs from another file only in capitals; rename one"


def _contradictions(record: BoardDataset) -> Iterator[str]:
    """Where a record contradicts itself."""
    counts, own = record.counts, {"id": record.id, "split": record.split, "tier": record.tier}
    for name, value in {**own, "camera": record.camera["kind"]}.items():
        if counts[name] != value:
            yield f"$.counts.{name}: is {counts[name]!r}, the record is of {value!r}"
    for protocol, part in record.scored.items():
        ascending = bool((part.sequence[1:] > part.sequence[:-1]).all())
        if not ascending or part.sequence[-1] >= counts["sequences"] or part.frames.min() < 1:
            yield f"$.scored.{protocol}: is not a list of the dataset's scored sequences"


def _datasets_at_hand(work: Path | None, named: Sequence[Path]) -> dict[str, Path]:
    """Dataset folders by id: those named, and those of the work folder that can be read."""
    found = {}
    for path in sorted(work.glob(f"datasets/*/{INFO_FILE}")) if work else []:
        with contextlib.suppress(VbbenchError):
            found[DatasetInfo.read(path.parent).id] = path.parent
    return found | {DatasetInfo.read(folder).id: folder for folder in named}


def _submissions_at_hand(work: Path | None, named: Sequence[Path]) -> list[Path]:
    """Submission folders: those named, and those of the work folder."""
    below = sorted(work.glob(f"submissions/*/*/*/{SUBMISSION_FILE}")) if work else []
    return [*named, *(path.parent for path in below if not path.parent.suffix)]


def _rescored(
    results: Sequence[Result], submissions: Iterable[Path], datasets: dict[str, Path]
) -> Iterator[tuple[Result, list[str]]]:
    """Results whose submission and dataset are available, with what scores differently now."""
    pairs = [
        (result, folder) for folder in submissions for result in _made_of(folder, results) if result.dataset in datasets
    ]
    with progress_bar(len(pairs), "score again", unit="result") as bar:
        for result, folder in pairs:
            yield result, _differences(result, folder, datasets[result.dataset])
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
    try:
        hashes, info = table_hashes(folder), SubmissionInfo.read(folder)
    except VbbenchError:
        return []
    return [
        result
        for result in results
        if result.submission == hashes and (result.dataset, result.board.protocol) == (info.dataset, info.protocol)
    ]


def _differences(result: Result, folder: Path, dataset: Path) -> list[str]:
    try:
        again = score(folder, dataset, sequences=result.per_sequence.sequence)
        fresh = Result.of(again, folder, result.about, name=result.solver)
    except VbbenchError as error:
        return [f"{folder} cannot be scored again: {error}"]
    return drift(result, fresh)


def _count(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"


ROUNDING = 1e-6
_LISTED = 5


def count_faults(result: Result, record: BoardDataset) -> Iterator[str]:
    """Faults of all but the summaries: differences from the record, missing sequences, counts and coverage."""
    yield from _declared_faults(result, record)
    rows = list(_row_faults(result, record))
    yield from rows
    if not rows:
        yield from _total_faults(result)
        yield from _figure_faults(result, record)


def summary_faults(results: Iterable[Result]) -> Iterator[tuple[Result, str]]:
    """Results with the summaries that do not follow from their per-sequence figures."""
    for result in results:
        own, protocol = result.per_sequence, get_protocol(result.board.protocol)
        fresh = summarise(own.timeline, protocol, own.figures, own.figures)
        for name, metric in METRICS.items():
            said = result.score[metric.section][name]
            for fault in _metric_summary_faults(said, fresh[name].to_dict(), result, name):
                yield result, f"$.score.{metric.section}.{name}.{fault}"


def _declared_faults(result: Result, record: BoardDataset) -> Iterator[str]:
    score = result.score
    pairs = {
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
    yield from _unequal(pairs)


def _row_faults(result: Result, record: BoardDataset) -> Iterator[str]:
    if result.board.protocol not in record.scored:
        yield f"$.protocol: {record.path} is older than {result.board.protocol}; remove it and add its results again"
        return
    own, wanted = result.per_sequence, record.scored[result.board.protocol]
    for words, numbers in (
        ("lacks", np.setdiff1d(wanted.sequence, own.sequence)),
        ("has, and the board does not,", np.setdiff1d(own.sequence, wanted.sequence)),
    ):
        if len(numbers):
            yield f"$.per_sequence: {words} {_some(numbers)}; solve and score the whole dataset"
    if len(own.sequence) == len(wanted.sequence) and not np.array_equal(own.sequence, wanted.sequence):
        yield "$.per_sequence: sequences are not in order, each once"
    if not np.array_equal(own.sequence, wanted.sequence):
        return
    for name, theirs in vars(wanted).items():
        mine = getattr(own, name)
        if not np.array_equal(mine, theirs):
            yield f"$.per_sequence: {name} differs from the board's in {_some(own.sequence[mine != theirs])}"
    for name, part, whole in (("posed", own.posed, own.frames), ("placed", own.placed, own.positions)):
        short = part != whole if result.score["failure_policy"] == "refuse" else part > whole
        if short.any():
            yield f"$.per_sequence: {name} does not go with the failure policy in {_some(own.sequence[short])}"


def _total_faults(result: Result) -> Iterator[str]:
    own, score = result.per_sequence, result.score
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


def _figure_faults(result: Result, record: BoardDataset) -> Iterator[str]:
    own = result.per_sequence
    second = max(1, round(1.0 / record.dt)) * record.dt
    for name, figures in own.figures.items():
        metric = METRICS[name]
        there = own.positions > 0 if metric.over == "people" else own.frames > 0
        wrong = ~there & np.isfinite(figures) if metric.over == "people" else np.zeros(len(figures), bool)
        if metric.over != "seconds":
            wrong |= there & np.isnan(figures)
        largest = {"rad": np.pi, "rad/s": np.pi / second}.get(metric.unit, np.inf)
        wrong |= figures > largest * (1 + ROUNDING)
        if wrong.any():
            yield f"$.per_sequence: {name} has impossible values in {_some(own.sequence[wrong])}"


def _metric_summary_faults(said: dict[str, Any], fresh: dict[str, Any], result: Result, name: str) -> Iterator[str]:
    scale = abs(fresh["mean"] or 0.0)
    for key in ("capped", "failure_rate", "mean", "std", "median", "p95", "blocks"):
        if not _close(said[key], fresh[key], scale if key == "std" else 0.0):
            yield _differs(key, said[key], fresh[key])
    for key, end in (("capped_ci95", 0), ("capped_ci95", 1), ("ci95", 0), ("ci95", 1)):
        if not _close(said[key][end], fresh[key][end]):
            yield _differs(f"{key}[{end}]", said[key][end], fresh[key][end])
    yield from _frame_summary_faults(said, result, name)


def _frame_summary_faults(said: dict[str, Any], result: Result, name: str) -> Iterator[str]:
    """The mean over frames follows where every frame has a figure: of poses; their spread is that of sequences or more.

    Of people and drift it is known whether there is any.
    """
    figures, frames = result.per_sequence.figures[name], result.per_sequence.frames
    if METRICS[name].over != "frames":
        for key in ("frame_mean", "frame_std"):
            if (said[key] is None) != (not len(known(figures))):
                yield f"{key}: is {said[key]}, the per-sequence figures say otherwise"
        return
    mean = float(np.average(figures, weights=frames))
    least = float(np.sqrt(np.average((figures - mean) ** 2, weights=frames)))
    if not _close(said["frame_mean"], mean):
        yield _differs("frame_mean", said["frame_mean"], mean)
    if said["frame_std"] is None or said["frame_std"] < least - ROUNDING * (least + mean):
        yield f"frame_std: is {said['frame_std']}, the per-sequence figures alone spread by {least!r}"


def _close(said: float | None, fresh: float | None, scale: float = 0.0) -> bool:
    if said is None or fresh is None:
        return said is fresh
    return abs(said - fresh) <= ROUNDING * max(abs(fresh), scale) + 1e-12


def _unequal(pairs: dict[str, tuple[Any, Any]]) -> Iterator[str]:
    for name, (said, wanted) in pairs.items():
        if said != wanted:
            yield f"$.{_differs(name, said, wanted)}"


def _differs(name: str, said: Any, wanted: Any) -> str:
    return f"{name}: is {said!r}, must be {wanted!r}"


def _some(numbers: FloatArray | Any) -> str:
    listed = ", ".join(str(number) for number in numbers[:_LISTED])
    more = f" and {len(numbers) - _LISTED} more" if len(numbers) > _LISTED else ""
    return f"sequence{'s' if len(numbers) > 1 else ''} {listed}{more}"


TOLERANCE, SINGLE_TOLERANCE = 1e-6, 1e-4
"""How far a figure may lie from the other, in m or rad, or in parts of it where it is larger than one; and those of
solvers that count with 24 bits, whose last digits depend on the processor."""

_NOT_COMPARED = ("solver_version", "seconds_per_frame")


def drift(old: Result, new: Result) -> list[str]:
    """Where two results of a solver on a board differ by more than the tolerance, one per line.

    Versions, times and descriptions are not compared.
    """
    return _value_differences(_comparable(old), _comparable(new), "", tolerance_of(new.solver))


def tolerance_of(solver: str) -> float:
    """How far figures of a solver may lie from those that were committed."""
    return SINGLE_TOLERANCE if solver in SINGLE_PRECISION else TOLERANCE


def record_faults(record: BoardDataset, folder: Path) -> Iterator[str]:
    """Where a dataset differs from its record.

    The bytes of tables depend on the library that wrote them; they must agree only if truth is withheld. The seed may
    then have been published since.
    """
    opened = Dataset(folder)
    if not opened.has_truth:
        return
    fresh, loose = BoardDataset.of(opened), ("tables",) if record.seed is not None else ("seed", "command")
    for name, value in vars(fresh).items():
        if name == "scored":
            yield from _scored_faults(record, fresh, folder)
        elif value != vars(record)[name] and name not in loose:
            yield f"$.{name}: is {vars(record)[name]!r}, {folder} gives {value!r}"


def _scored_faults(record: BoardDataset, fresh: BoardDataset, folder: Path) -> Iterator[str]:
    for protocol, recorded in record.scored.items():
        for column, numbers in vars(fresh.scored[protocol]).items():
            if not np.array_equal(getattr(recorded, column), numbers):
                yield f"$.scored.{protocol}: {column} are not those that {folder} gives"


def _comparable(result: Result) -> dict[str, Any]:
    own = result.per_sequence
    columns = {name: values for name, values in vars(own).items() if name != "figures"} | own.figures
    score = {name: value for name, value in result.score.items() if name not in _NOT_COMPARED}
    return {"score": score, "per_sequence": {name: _plain(values) for name, values in columns.items()}}


def _plain(values: Any) -> list[float | None]:
    return [None if np.isnan(value) else float(value) for value in values]


def _value_differences(old: Any, new: Any, name: str, tolerance: float) -> list[str]:
    if isinstance(old, dict) and isinstance(new, dict):
        keys = dict.fromkeys([*old, *new])
        below = {key: f"{name}.{key}".lstrip(".") for key in keys}
        return [line for key in keys for line in _value_differences(old.get(key), new.get(key), below[key], tolerance)]
    if isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        return _differences_of_rows(old, new, name, tolerance)
    return [] if _same(old, new, tolerance) else [f"{name}: was {_short(old)}, is {_short(new)}"]


def _differences_of_rows(old: list[Any], new: list[Any], name: str, tolerance: float) -> list[str]:
    rows = [row for row, pair in enumerate(zip(old, new, strict=True)) if not _same(*pair, tolerance)]
    if not rows:
        return []
    worst = max(rows, key=lambda row: abs((old[row] or 0.0) - (new[row] or 0.0)))
    return [f"{name}: {len(rows)} of {len(old)} differ, most row {worst}: was {old[worst]}, is {new[worst]}"]


def _same(old: Any, new: Any, tolerance: float) -> bool:
    if isinstance(old, float) and isinstance(new, (int, float)):
        return abs(old - new) <= tolerance * max(1.0, abs(old))
    return bool(old == new)


def _short(value: Any) -> str:
    return f"{len(value)} values" if isinstance(value, (dict, list)) else repr(value)
