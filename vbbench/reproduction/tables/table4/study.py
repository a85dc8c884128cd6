"""Table 4 measured: split `street` with all inputs, every solver under both protocols."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np

from vbbench.camera import Camera
from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.folders.locks import loose_files
from vbbench.geometry import BoolArray, FloatArray
from vbbench.paper import COLUMNS, PROTOCOLS
from vbbench.registry import load
from vbbench.reproduction.making import Making
from vbbench.reproduction.tables.table4.inputs import Counts, Input, LinkedByTruth, count
from vbbench.scoring.scorecard import Summary
from vbbench.sequence import NOBODY

SPLIT = "street"
SOLVERS = ("vb-cv", "vb-sf", "vb-sf-literal", "map-causal")
JITTER = (0.0, 1.0, 2.0, 4.0)
"""Standard deviations in px of column, top and bottom of centre lines: exact, and drawn by hands ever more hasty."""
LEAST_TRACK = 4
"""The paper keeps who is tracked in more than three frames."""


@dataclass(frozen=True, kw_only=True)
class Table4Study:
    """What to measure.

    Parameters
    ----------
    solvers : registered names or ``module:attribute``.
    jitter : of centre lines in px, exact ones and drawn ones.
    sequences : of each input; ``None`` for as many as the scenario has.
    seed : of the datasets.
    """

    solvers: Sequence[str] = SOLVERS
    jitter: Sequence[float] = JITTER
    sequences: int | None = None
    seed: int = 0

    def check(self) -> None:
        """Raise VbbenchError if there is nothing to measure."""
        if not self.solvers:
            raise VbbenchError("nothing to measure: name a solver")
        if not self.jitter or len(set(self.jitter)) < len(self.jitter) or min(self.jitter) < 0.0:
            raise VbbenchError(f"jitter is one or more different numbers of px, 0 or more, not {list(self.jitter)}")

    @property
    def lines(self) -> tuple[Input, ...]:
        """Centre lines."""
        return tuple(Input(kind="cline", jitter=jitter) for jitter in self.jitter)

    @property
    def tracks(self) -> tuple[Input, ...]:
        """Boxes of the tracker: by the paper's rule, by the tracker's own, and by the paper's under true ids."""
        paper = Input(kind="tracked", least_track=LEAST_TRACK)
        return paper, Input(kind="tracked"), Input(kind="linked", least_track=LEAST_TRACK)

    @property
    def inputs(self) -> tuple[Input, ...]:
        """All."""
        return (*self.lines, *self.tracks)


@dataclass(frozen=True, kw_only=True)
class Measured:
    """Figures of a solver under a protocol on an input: metric → summary."""

    protocol: str
    solver: str
    input: Input
    summaries: Mapping[str, Summary]


@dataclass(frozen=True, kw_only=True)
class Example:
    """A frame as the observer sees it, with both inputs.

    Parameters
    ----------
    lines : [N, 3] (u, v, l) in px, the centre lines with the most jitter.
    boxes : [M, 3] (u, v, l) in px of the tracker.
    first : [M] whether the person behind a track is the one it began with.
    nobody : [M] whether nobody is behind it.
    """

    camera: Camera
    sequence: int
    frame: int
    lines: FloatArray
    boxes: FloatArray
    first: BoolArray
    nobody: BoolArray


@dataclass(frozen=True, kw_only=True)
class Table4:
    """The results: how many sequences, what each input has, and figures, a row each."""

    study: Table4Study
    sequences: int
    counts: Mapping[Input, Counts]
    rows: tuple[Measured, ...]
    example: Example

    def figures(self, protocol: str, solver: str, source: Input) -> Mapping[str, Summary]:
        """Metric → summary of one row."""
        (row,) = (row for row in self.rows if (row.protocol, row.solver, row.input) == (protocol, solver, source))
        return row.summaries

    def times(self, protocol: str, solver: str, tracked: Input, line: Input) -> dict[str, dict[str, float]]:
        """Metric → error with the tracker's boxes by that with centre lines, of means over sequences and frames."""
        above, below = (self.figures(protocol, solver, source) for source in (tracked, line))
        return {
            metric: {
                "sequences": above[metric].mean / below[metric].mean,
                "frames": above[metric].frame_mean / below[metric].frame_mean,
            }
            for metric in COLUMNS
        }


def measure_table4(study: Table4Study, out: Path | str, making: Making = Making()) -> Table4:  # noqa: B008
    """Generate, solve and score; datasets and submissions are kept in ``out``, and complete ones reused.

    Raises
    ------
    VbbenchError
        If an argument is invalid, or another dataset or submission is in the way.
    """
    study.check()
    with loose_files(Path(out)):
        datasets = {source: _dataset(source, study, Path(out), making) for source in study.inputs}
        rows = tuple(_rows(study, datasets, making))
    lines, tracks = datasets[study.lines[-1]], datasets[study.tracks[0]]
    return Table4(
        study=study,
        sequences=len(lines),
        counts={source: count(dataset) for source, dataset in datasets.items()},
        rows=rows,
        example=_example(lines, tracks),
    )


def _dataset(source: Input, study: Table4Study, out: Path, making: Making) -> Dataset:
    folder, options = out / source.name / "dataset", source.options(study.seed, study.sequences)
    if source.kind != "linked":
        return making.dataset(SPLIT, folder, options)
    return making.planned(LinkedByTruth(load("generator", SPLIT).plan(options)), folder)


def _rows(study: Table4Study, datasets: Mapping[Input, Dataset], making: Making) -> Iterator[Measured]:
    for protocol, (source, dataset) in product(PROTOCOLS, datasets.items()):
        for solver, score in making.scores(dataset, study.solvers, protocol):
            summaries = {metric: score.summaries[metric] for metric in COLUMNS}
            yield Measured(protocol=protocol, solver=solver, input=source, summaries=summaries)


def _example(lines: Dataset, tracks: Dataset) -> Example:
    """The first sequence in the frame in which most tracks have gone over to somebody else."""
    drawn, found = lines.sequence(0), tracks.sequence(0)
    persons, observed = tracks.track_persons(found), found.observed
    begun = persons[(persons != NOBODY).argmax(axis=0), np.arange(len(found.tracks))]
    nobody = persons == NOBODY
    frame = int((observed & ~nobody & (persons != begun)).sum(axis=1).argmax())
    seen = observed[frame]
    return Example(
        camera=tracks.camera(found),
        sequence=0,
        frame=frame,
        lines=drawn.observations[frame, drawn.observed[frame]],
        boxes=found.observations[frame, seen],
        first=(persons[frame] == begun)[seen],
        nobody=nobody[frame, seen],
    )
