"""The posteriors of observer and people on ETH: ten frames of four examples, and entropies over all sequences.

The paper draws posteriors over ten frames for few and for more people, walking parallel and crossing, and states that
tails are heavier with few people, and that posteriors are sharper where people walk in diverse directions.

The observer counts as one of the walkers. With the directions α of everybody who moves, the **spread of directions** is
1 − |mean of exp(iα)|: 0 where all go one way, near 1 where as many come as go. The **spread of lines** is
1 − |mean of exp(2iα)|: 0 also where people walk along one line in opposite ways, greater where paths cross.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import Colormap, ListedColormap, to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from vbbench.errors import VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.generation.generator import Options
from vbbench.geometry import FloatArray, IntArray
from vbbench.pictures.plotting import style
from vbbench.protocol import START_FRAMES, get_protocol
from vbbench.registry import load, make_solver
from vbbench.reproduction.agreement import LEVEL, SEED, Errors, Estimate, spearman
from vbbench.reproduction.density import GridDensity, find_density
from vbbench.reproduction.grid import Making, Study, check_every, each, stride_of
from vbbench.reproduction.report import Report, paragraphs
from vbbench.scoring.block_bootstrap import Timeline
from vbbench.sequence import Sequence
from vbbench.solver import PosePosterior
from vbbench.solving.runner import frames_of, reveal
from vbbench.table import Table

STANDING = 0.3
"""In m/s; a slower person has no direction."""
WINDOW = 10
"""Frames of an example."""
FEW, MORE = 3, (5, 12)
"""People seen in the paper's sparse example, and in the crowded one; with more no picture shows them apart."""
RESAMPLES = 400

Columns = Mapping[str, Any]
"""Arrays [F] by name, of the same frames."""


def walking_of(dataset: Dataset) -> dict[str, Any]:
    """How people truly walk in the frames [F] of all sequences, from the third on.

    Columns are sequence and frame, the people seen, and the spreads of directions and of lines, NaN where they are of
    nobody.
    """
    found = []
    for sequence in dataset.sequences():
        truth, observed = dataset.truth(sequence), sequence.observed
        people = np.where(observed[..., None], truth.positions, np.nan)
        places = truth.poses[:, None, :2]
        velocity = np.diff(np.concatenate([people, places], axis=1), axis=0)[START_FRAMES - 1 :] / dataset.info.dt
        spread, lines = spreads(velocity)
        frames = np.arange(START_FRAMES, sequence.frames)
        numbers = np.full(len(frames), sequence.index), frames, observed[START_FRAMES:].sum(axis=1)
        found.append((*numbers, spread, lines))
    names = ("sequence", "frame", "people", "spread", "lines")
    return {name: np.concatenate(parts) for name, parts in zip(names, zip(*found, strict=True), strict=True)}


def spreads(velocity: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Spreads of directions and of lines, [F] each, of velocities [F, K, 2] in m/s, NaN = not known."""
    speed, angle = np.hypot(velocity[..., 0], velocity[..., 1]), np.arctan2(velocity[..., 1], velocity[..., 0])
    angle = np.where(speed >= STANDING, angle, np.nan)
    return directional_spread(angle), directional_spread(2.0 * angle)


def directional_spread(angle: FloatArray) -> FloatArray:
    """1 − |mean of exp(iα)| [F] of angles α [F, K] in rad, NaN = none."""
    known = ~np.isnan(angle)
    count = known.sum(axis=-1)
    total = np.abs(np.where(known, np.exp(1j * angle), 0.0).sum(axis=-1))
    return np.where(count > 0, 1.0 - total / np.maximum(count, 1), np.nan)


class Example(NamedTuple):
    """Ten frames of a sequence, what they are an example of, and means over them."""

    title: str
    sequence: int
    first: int
    people: float
    spread: float
    lines: float

    @property
    def frames(self) -> range:
        """The frames' numbers."""
        return range(self.first, self.first + WINDOW)


def pick_examples(walk: Columns) -> list[Example]:
    """Few and more people, each parallel and crossing, of all stretches of `WINDOW` frames; none where there is none.

    Few: at least `FEW` people in every frame, and never more than the sparsest such stretch has at most. More: as many
    as `MORE` says in every frame. Parallel: the least spread of directions. Crossing: the greatest product of the
    spreads of directions and of lines. Of equals, the first.
    """
    sequence, people, spread = walk["sequence"], walk["people"], walk["spread"]
    stretches = [
        slice(begin, begin + WINDOW)
        for begin in range(len(sequence) - WINDOW + 1)
        if sequence[begin] == sequence[begin + WINDOW - 1] and not np.isnan(spread[begin : begin + WINDOW]).any()
    ]
    most = {one.start: int(people[one].max()) for one in stretches}
    sparse = min((most[one.start] for one in stretches if people[one].min() >= FEW), default=FEW)
    kinds = {
        f"{FEW if sparse == FEW else f'{FEW} to {sparse}'} people": (FEW, sparse),
        f"{MORE[0]} to {MORE[1]} people": MORE,
    }
    orders: dict[str, Callable[[slice], float]] = {
        "parallel": lambda one: round(float(np.mean(spread[one])), 9),
        "crossing": lambda one: -round(float(np.mean(spread[one])) * float(np.mean(walk["lines"][one])), 9),
    }
    found = []
    for title, (low, high) in kinds.items():
        fitting = [one for one in stretches if people[one].min() >= low and most[one.start] <= high]
        for how, order in orders.items() if fitting else ():
            best = min(fitting, key=order)
            means = (float(np.mean(walk[name][best])) for name in ("people", "spread", "lines"))
            found.append(Example(f"{title}, {how}", int(sequence[best.start]), int(walk["frame"][best.start]), *means))
    return found


class FrameSample(NamedTuple):
    """Frames [F] of sequences [N] on a timeline: the sequence of each, ascending."""

    sequence: IntArray
    timeline: Timeline

    def rank_correlation(self, one: FloatArray, other: FloatArray) -> Estimate:
        """Spearman's ρ of columns [F] with its interval; frames with a NaN are removed.

        Intervals are quantiles over a bootstrap of blocks of time as long as the first column stays equal, in which
        sequences are drawn with all of their frames.
        """
        there, size = ~np.isnan(one), len(self.timeline.middle)
        number = np.bincount(self.sequence[there], minlength=size)
        mean = np.bincount(self.sequence[there], one[there], size) / np.maximum(number, 1)
        filled = np.where(number > 0, mean, mean[number > 0].mean())
        times = Errors(values=filled[None], timeline=self.timeline).counts(RESAMPLES, SEED).astype(np.int64)
        known = there & ~np.isnan(other)
        pair = np.stack([one[known], other[known]])
        drawn = np.array([correlation(*np.repeat(pair, row, axis=1)) for row in times[:, self.sequence[known]]])
        drawn = drawn[~np.isnan(drawn)]
        low, high = np.quantile(drawn, LEVEL).tolist() if len(drawn) else (np.nan, np.nan)
        return Estimate(correlation(*pair), low, high)


def correlation(one: FloatArray, other: FloatArray) -> float:
    """Spearman's ρ of columns [F]; NaN where either does not vary."""
    return float(spearman(one[None], other[None])[0])


SOLVER = "vb-sf"
"""The solver, whose class names in ``readings`` that of the paper's text."""
PROTOCOL = "one-step"
SAMPLES, SPACING = 41, 0.01
"""Places along a viewing ray, and how far apart they are in m of a person's height."""
PART = 8
"""Sequences that a process measures at a time."""
FIGURES = ("pose", "place", "beyond", "kurtosis", "error")
"""Columns of a frame: entropies in nats of pose and of its place; tails of the place; and error in m."""
WALKING = ("people", "spread")
_TAILS, _POSE = "few people, heavier tails", "entropy of the pose"
CLAIMS: tuple[tuple[str, str, str, str, str], ...] = (
    (_TAILS, "kurtosis of the place", "ρ with people", "people", "kurtosis"),
    (_TAILS, "mass beyond 3 σ", "ρ with people", "people", "beyond"),
    ("few people, wider", _POSE, "ρ with people", "people", "pose"),
    ("diverse, sharper", _POSE, "ρ with the spread", "spread", "pose"),
)
"""The paper's claims: what each states, what is measured of what, and the two columns."""


def text_reading() -> str:
    """The solver of the paper's text: heights from N(μ_h, σ_h²), nothing expected of the observer."""
    pair: tuple[str, str] = load("solver", SOLVER).readings["prior"]
    return pair[1]


def measured_solvers() -> dict[str, str]:
    """The solvers whose posteriors are measured, and what sets each apart; the first is drawn."""
    return {
        text_reading(): "the text: heights from N(1.70 m, σ_h²), nothing expected of the observer",
        SOLVER: "vb-sf as it is: heights learned, the observer expected to walk on",
    }


class Instant(NamedTuple):
    """One frame's posteriors.

    Of the observer's pose (x, y, yaw), and of its place on a finer grid; and of the people seen, places [M, S, 2] in m
    and probabilities [M, S] along their rays. The last is as in `FIGURES`.
    """

    frame: int
    density: GridDensity
    place: GridDensity
    places: FloatArray
    probabilities: FloatArray
    error: float


class ShownExample(NamedTuple):
    """An example with its posteriors, the true path [T, 3] and the true places [T, K, 2] of the people seen."""

    example: Example
    instants: list[Instant]
    poses: FloatArray
    positions: FloatArray


class Posteriors(NamedTuple):
    """The results: number of sequences, and of the same frames [F] how people walk and, by solver, `FIGURES`."""

    sequences: int
    walking: Columns
    sample: FrameSample
    tables: Mapping[str, Columns]
    examples: list[ShownExample]


@dataclass(frozen=True, kw_only=True)
class PosteriorStudy(Study):
    """Posteriors in every ``every``-th sequence of a recording, in all frames in which two people help."""

    name = "figure-posterior"
    split: str = "eth"
    every: int = 1
    seed: int = 0

    def check(self) -> None:
        """Raise VbbenchError if ``every`` is not a number of sequences."""
        check_every(self.every)

    def measure(self, out: Path, making: Making) -> Posteriors:
        """One dataset, whose frames are measured in parallel."""
        options = Options(seed=self.seed, stride=stride_of(self.every))
        dataset = making.dataset(self.split, out / "dataset", options)
        walk = walking_of(dataset)
        tables = {solver: _columns(dataset, solver, making.jobs) for solver in measured_solvers()}
        frames = list(zip(*(tables[SOLVER][name].tolist() for name in ("sequence", "frame")), strict=True))
        if not frames:
            raise VbbenchError(
                f"{dataset.folder}: in no frame do two people help to find the observer; take more sequences"
            )
        row_of = {
            key: row for row, key in enumerate(zip(walk["sequence"].tolist(), walk["frame"].tolist(), strict=True))
        }
        walking = {name: walk[name][[row_of[frame] for frame in frames]] for name in WALKING}
        rows, first = dataset.rows, dataset.rows["first_frame"].astype(np.int64)
        timeline = Timeline.of(rows["scene"].astype(np.int64), first, first + rows["frames"] - 1)
        examples = [_shown(dataset, example) for example in pick_examples(walk)]
        return Posteriors(
            sequences=len(dataset),
            walking=walking,
            sample=FrameSample(tables[SOLVER]["sequence"], timeline),
            tables=tables,
            examples=[one for one in examples if one.instants],
        )

    def report(self, found: Posteriors) -> Report:
        """Claims and examples, with a picture of these."""
        claims = {
            solver: [found.sample.rank_correlation(found.walking[along], own[what]) for *_, along, what in CLAIMS]
            for solver, own in found.tables.items()
        }
        some = "all sequences" if self.every == 1 else f"one in {self.every}"
        counts = {"frames": len(found.sample.sequence), "sequences": found.sequences}
        facts = paragraphs("posterior", some=some, solvers=measured_solvers(), **counts)
        return Report(
            name=self.name,
            title=f"Posteriors of observer and people: split {self.split}, one-step, seed {self.seed}",
            facts=facts,
            tables=[_claims_table(claims), _examples_table(found)],
            values={
                "split": self.split,
                "every": self.every,
                "seed": self.seed,
                "sequences": found.sequences,
                "frames": len(found.sample.sequence),
                "claims": {
                    solver: [
                        {"claim": claim, "of": what, "figure": how} | one._asdict()
                        for (claim, what, how, *_), one in zip(CLAIMS, estimates, strict=True)
                    ]
                    for solver, estimates in claims.items()
                },
                "examples": [shown.example._asdict() for shown in found.examples],
            },
            pictures={"": self.plot_examples(found)} if found.examples else {},
        )

    def plot_examples(self, found: Posteriors) -> Figure:
        """Draw every example: a map with people's posteriors along their rays, and the observer's in ten frames."""
        blocks, half = found.examples, _half_width(found.examples)
        height = _HEAD + len(blocks) * _BLOCK + _FOOT
        places: style.Rectangles = {}
        for row in range(len(blocks)):
            top = height - _HEAD - row * _BLOCK - 0.34
            places[f"map {row}"] = (_MAP[0], top - _MAP[2], *_MAP[1:])
            for n in range(WINDOW):
                left, down = _LEFT + n % _ACROSS * _STEP, n // _ACROSS * (_PANEL + 0.14)
                places[f"{row} {n}"] = (left, top - down - _PANEL, _PANEL, _PANEL)
        figure = style.lay_out((_WIDTH, height), places)
        parts = {str(axes.get_label()): axes for axes in figure.axes}
        colours = ListedColormap(style.distance_colours()(np.linspace(0.0, 0.92, WINDOW)), "frames")
        for row, shown in enumerate(blocks):
            _draw_map(parts[f"map {row}"], shown, colours)
            for n in range(WINDOW):
                _draw_instant(parts[f"{row} {n}"], shown, n, half, colours)
            one, entropy = shown.example, np.mean([instant.density.entropy for instant in shown.instants])
            facts = f"sequence {one.sequence}, {one.people:.1f} people seen, spread of directions {one.spread:.2f}, "
            facts += f"of lines {one.lines:.2f}; mean entropy {entropy:.2f} nats"
            x, y = _MAP[0] / _WIDTH, 1.0 - (_HEAD + row * _BLOCK + 0.22) / height
            figure.text(x, y, f"({chr(ord('a') + row)}) {one.title}", fontsize=11.0, weight="bold", color=style.INK)
            figure.text(_LEFT / _WIDTH, y, facts, fontsize=style.TEXT_SIZE, color=style.INK)
        title = (
            "Posteriors of people along their viewing rays (left) and of the observer's place (right), ten frames each"
        )
        text = f"split {self.split}, one-step, seed {self.seed}; every square on the right is {2.0 * half:g} m wide, "
        text += "centred on the true place, in the axes of the map; a colour is a frame on both sides"
        style.write_heading(figure, _MAP[0], title, text)
        handles = _example_handles()
        look: dict[str, Any] = {"frameon": False, "fontsize": style.TEXT_SIZE, "borderaxespad": 0.0, "borderpad": 0.2}
        look |= {"bbox_to_anchor": (_MAP[0] / _WIDTH, 1.0 - 0.64 / height), "ncols": len(handles)}
        figure.legend(handles=handles, loc="upper left", **look)
        return figure


def _columns(dataset: Dataset, solver: str, jobs: int) -> dict[str, Any]:
    """Sequence, frame and `FIGURES` [F] of all sequences."""
    calls = [(dataset, solver, first, min(first + PART, len(dataset))) for first in range(0, len(dataset), PART)]
    parts = each(posterior_rows, calls, jobs, f"posteriors of {solver.rpartition(':')[2]}", "part")
    rows = np.array([row for part in parts for row in part], dtype=np.float64).reshape(-1, 2 + len(FIGURES)).T
    sequence, frame = rows[:2].astype(np.int64)
    return {"sequence": sequence, "frame": frame, **dict(zip(FIGURES, rows[2:], strict=True))}


def posterior_rows(dataset: Dataset, solver: str, first: int, last: int) -> list[tuple[float, ...]]:
    """Sequence, frame and `FIGURES` of the frames of sequences first ≤ index < last."""
    return [
        (sequence.index, one.frame, one.density.entropy, one.place.entropy, *one.place.tails(), one.error)
        for sequence in dataset.sequences(first, last)
        for one in instants(dataset, sequence, solver)
    ]


def instants(dataset: Dataset, sequence: Sequence, solver: str, only: range | None = None) -> Iterator[Instant]:
    """The posteriors in the frames of a sequence, or in some ``only``, in which two people or more help.

    Raises VbbenchError if the solver reports none.
    """
    source: Any = make_solver(solver)
    if not isinstance(source, PosePosterior):
        raise VbbenchError(f"solver '{solver}' has no pose_energy of each frame and so no posterior; try vb-sf")
    truth = dataset.truth(sequence)
    given = get_protocol(PROTOCOL).select_given(sequence.given)
    source.start(dataset.problem(sequence, covariances=True))
    for shown in frames_of(sequence, given, reveal(given, sequence.observed, truth)):
        frame, answer = shown.index, source.step(shown)
        if frame < START_FRAMES or answer.fallback or answer.pose_covariance is None:
            continue
        if only is not None and frame not in only:
            continue
        energy = one_turn(source.pose_energy, answer.pose[2])
        density = find_density(energy, answer.pose, answer.pose_covariance)
        place = density.marginal().finer()
        error = float(np.hypot(*(answer.pose - truth.poses[frame])[:2]))
        yield Instant(frame, density, place, *source.ray_posterior(SAMPLES, SPACING), error)


def one_turn(energy: Callable[[FloatArray], FloatArray], yaw: float) -> Callable[[FloatArray], FloatArray]:
    """The energy of poses [N, 3] within half a turn of ``yaw``, inf beyond, so that no pose counts twice."""
    return lambda poses: np.where(np.abs(poses[:, 2] - yaw) <= np.pi, energy(poses), np.inf)


def _shown(dataset: Dataset, example: Example) -> ShownExample:
    sequence = dataset.sequence(example.sequence)
    truth = dataset.truth(sequence)
    found = list(instants(dataset, sequence, text_reading(), example.frames))
    return ShownExample(example, found, truth.poses, np.where(sequence.observed[..., None], truth.positions, np.nan))


def _short(solver: str) -> str:
    return f"`{solver.rpartition(':')[2]}`"


def _claims_table(claims: Mapping[str, list[Estimate]]) -> Table:
    cells = [
        ["–" if np.isnan(one.value) else f"{one.value:+.2f} [{one.low:+.2f}, {one.high:+.2f}]" for one in row]
        for row in zip(*claims.values(), strict=True)
    ]
    return Table(
        title="The paper's claims",
        facts=paragraphs("posterior_claims"),
        head=["claim", "of", "figure", *map(_short, claims)],
        rows=[[*claim[:3], *row] for claim, row in zip(CLAIMS, cells, strict=True)],
        names=3,
    )


def _examples_table(found: Posteriors) -> Table:
    rows = []
    for one, shown, *_ in found.examples:
        figures = [(instant.density.entropy, instant.place.entropy, instant.error) for instant in shown]
        pose, place, error = (np.mean(column) for column in zip(*figures, strict=True))
        spreads = [f"{one.people:.1f}", f"{one.spread:.2f}", f"{one.lines:.2f}"]
        frames = f"{one.first}–{one.frames[-1]}"
        rows.append([one.title, f"{one.sequence}", frames, *spreads, f"{pose:.2f}", f"{place:.2f}", f"{error:.3f}"])
    head = ["example", "sequence", "frames", "people", "spread", "of lines", "pose (nats)", "place", "Δt (m)"]
    return Table(title="The examples", facts=paragraphs("posterior_examples"), head=head, rows=rows)


_SHARES = (0.99, 0.95, 0.8, 0.5)
"""Probability inside each contour, the widest first."""
_WIDTH, _HEAD, _FOOT, _BLOCK = 14.0, 1.0, 0.35, 3.95  # inches; a block is an example with its title
_MAP = (0.65, 4.5, 3.15)  # left edge, width and height
_PANEL, _STEP, _LEFT, _ACROSS = 1.5, 1.68, 5.55, 5
_MARGIN = 1.0  # m around everything on a map
_FILLED = colormaps["YlOrBr"](np.linspace(0.18, 0.82, len(_SHARES)))


def _example_handles() -> list[Any]:
    shares = zip(_SHARES, _FILLED, strict=True)
    handles: list[Any] = [Patch(color=colour, label=f"{share:.0%}") for share, colour in shares]
    handles[-1].set_label(f"{_SHARES[-1]:.0%} of the posterior")
    point: dict[str, Any] = {"linestyle": "none", "color": style.INK}
    return [
        *handles,
        Line2D([], [], marker="+", markersize=7, label="observer, true", **point),
        Line2D([], [], marker="o", markersize=2.6, label="person, true", **point),
        Line2D([], [], color=style.TRUTH, linewidth=1.4, label="the observer's true path"),
        Line2D([], [], color=style.UNSEEN, linewidth=0.6, label="viewing rays of the last frame"),
    ]


def _half_width(examples: list[ShownExample]) -> float:
    """Half the side in m of every square: most posteriors with their true places fit."""
    reaches = []
    for shown in examples:
        for one in shown.instants:
            mean, covariance = one.place.moments()
            off = np.abs(mean - shown.poses[one.frame, :2]).max()
            reaches.append(off + 2.0 * float(np.sqrt(np.diag(covariance).max())))
    return float(np.ceil(10.0 * np.quantile(reaches, 0.9)) / 10.0)


def _draw_map(axes: Axes, shown: ShownExample, colours: Colormap) -> None:
    frames = np.array(shown.example.frames)
    turned = style.along_path(shown.poses[frames, :2])
    path = turned(shown.poses[frames, :2])
    axes.plot(*path.T, color=style.TRUTH, linewidth=1.4, zorder=2)
    axes.plot(*path.T, "+", color=style.INK, markersize=6, zorder=4)
    seen = [path]
    for one in shown.instants:
        colour = to_rgb(colours(one.frame - frames[0]))
        for line, mass in zip(turned(one.places), one.probabilities, strict=True):  # the darker the more probable
            line, mass = line[mass > 0.0], mass[mass > 0.0]
            strength = np.sqrt(0.5 * (mass[:-1] + mass[1:]) / mass.max())
            rgba = np.concatenate([np.tile(colour, (len(strength), 1)), strength[:, None]], axis=1)
            style.draw_lines(axes, np.stack([line[:-1], line[1:]], axis=1), rgba, 3.4, 3)
        here = turned(shown.positions[one.frame])
        here = here[~np.isnan(here[:, 0])]
        axes.plot(*here.T, ".", color=style.INK, markersize=2.2, zorder=5)
        seen.append(here)
    last = shown.instants[-1]
    ends = turned(last.places)[:, SAMPLES // 2]
    rays = np.stack([np.broadcast_to(path[last.frame - frames[0]], ends.shape), ends], axis=1)
    style.draw_lines(axes, rays, style.UNSEEN, 0.6, 1.5)
    points = np.concatenate(seen)
    style.fit(axes, points.min(axis=0) - _MARGIN, points.max(axis=0) + _MARGIN)
    axes.set_xlabel("along the observer's walk (m)", fontsize=style.TEXT_SIZE, labelpad=1.0)
    axes.set_ylabel("to its left (m)", fontsize=style.TEXT_SIZE, labelpad=1.0)
    style.draw_grid(axes)
    axes.tick_params(labelsize=style.LABEL_SIZE + 1.0)


def _draw_instant(axes: Axes, shown: ShownExample, n: int, half: float, colours: Colormap) -> None:
    """The observer's place in the n-th frame, about the true one."""
    frame = shown.example.first + n
    axes.set(xlim=(-half, half), ylim=(-half, half), xticks=[], yticks=[])
    for spine in axes.spines.values():
        spine.set(color=colours(n), linewidth=1.6)
    words: dict[str, Any] = {"transform": axes.transAxes, "fontsize": style.LABEL_SIZE + 0.5, "color": style.INK}
    axes.text(0.04, 0.96, f"frame {frame}", va="top", **words)
    found = [one for one in shown.instants if one.frame == frame]
    if not found:
        axes.text(0.5, 0.5, "nobody helps", ha="center", **words)
        return
    place = found[0].place
    turned = style.along_path(shown.poses[np.array(shown.example.frames), :2])
    points = turned(place.points()) - turned(shown.poses[frame, :2])
    levels: Any = [*(place.level(share) for share in _SHARES), float(place.mass.max()) * 1.01]
    axes.contourf(points[..., 0], points[..., 1], place.mass, levels, colors=list(map(tuple, _FILLED)))
    axes.plot(0.0, 0.0, "+", color=style.INK, markersize=7)
    people = int((~np.isnan(shown.positions[frame, :, 0])).sum())
    axes.text(0.96, 0.04, f"{found[0].density.entropy:.1f} nats, {people} people", ha="right", va="bottom", **words)
