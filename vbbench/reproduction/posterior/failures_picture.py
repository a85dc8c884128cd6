"""The worst sequences as a sheet of maps: where observer and people went, and where the solver put them."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from vbbench.pictures.plotting import style
from vbbench.pictures.plotting.style import Rectangles, draw_heading, lay_out
from vbbench.pictures.replay import Replay
from vbbench.reproduction.posterior.failures import PROTOCOL, SYMBOL, Failure
from vbbench.reproduction.posterior.study import Posteriors
from vbbench.reproduction.posterior.walking import along_walk

_COLUMNS, _PANEL, _STEP = 3, (4.0, 3.0), (4.6, 4.15)  # inches
_HEAD, _LEFT, _FOOT = 1.0, 0.65, 0.25
_REACH = 1.0  # m around everything
_FAR = 4.0  # m beyond the true paths, as far as an estimate may widen the map


def plot_failures(found: Posteriors) -> Figure:
    """Draw the worst sequences that share no frames."""
    shown = found.failures.shown
    rows = -(-len(shown) // _COLUMNS)
    height = _HEAD + rows * _STEP[1] + _FOOT
    panels: Rectangles = {
        f"{n}": (_LEFT + n % _COLUMNS * _STEP[0], height - _HEAD - n // _COLUMNS * _STEP[1] - 0.55 - _PANEL[1], *_PANEL)
        for n in range(len(shown))
    }
    figure = lay_out((_LEFT + _COLUMNS * _STEP[0], height), panels)
    for axes, (failure, replay) in zip(figure.axes, shown, strict=True):
        _draw_failure(axes, failure, replay)
    title = f"The worst sequences of {found.failures.solver}, {PROTOCOL}, of which no two share frames"
    facts = f"split {found.study.split}, seed {found.study.seed}; ranked by min({SYMBOL}, {found.failures.cap:g} m)"
    draw_heading(figure, _LEFT, title, facts, figure.axes[0])
    return figure


def _draw_failure(axes: Axes, failure: Failure, replay: Replay) -> None:
    truth, answer = replay.truth, replay.answer
    if truth is None or answer is None:
        return
    seen = replay.sequence.observed[..., None]
    turned = along_walk(truth.poses[:, :2])
    real, guessed = (turned(np.where(seen, one.positions, np.nan)) for one in (truth, answer.estimate))
    path, estimated = turned(truth.poses[:, :2]), turned(answer.estimate.poses[:, :2])
    _draw_paths(axes, real, style.TRUTH_TAIL, 2.2, "people, true")
    _draw_paths(axes, guessed, style.GIVEN, 0.9, "people, estimated")
    thick: dict[str, Any] = {"linewidth": 2.2, "marker": "o", "markersize": 3.0}
    axes.plot(*path.T, color=style.INK, label="observer, true (begins at the ring)", **thick)
    axes.plot(*estimated.T, color=style.ESTIMATE, label="observer, estimated", **thick)
    axes.plot(*path[0], marker="o", markersize=9, color=style.INK, fillstyle="none")
    known = np.concatenate([path, real[seen[..., 0]]])
    low, high = np.nanmin(known, axis=0), np.nanmax(known, axis=0)
    reached = np.concatenate([known, estimated.clip(low - _FAR, high + _FAR)])
    low, high = np.nanmin(reached, axis=0) - _REACH, np.nanmax(reached, axis=0) + _REACH
    size = np.array(_PANEL)
    spans = float(np.max((high - low) / size)) * size
    low, high = (low + high - spans) / 2.0, (low + high + spans) / 2.0
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    axes.set_xlabel("along the observer's walk (m)", fontsize=style.TEXT_SIZE, labelpad=1.0)
    axes.set_ylabel("to its left (m)", fontsize=style.TEXT_SIZE, labelpad=1.0)
    axes.grid(color=style.FAINT, linewidth=0.6)
    axes.set_axisbelow(True)
    facts = failure.facts
    causes = ", ".join(failure.causes) or "no known cause"
    lines = [
        f"{SYMBOL} {failure.error:.2f} m, Δt {failure.observer_error:.2f} m; {causes}",
        f"{facts.people:.1f} people seen; spread of directions {facts.spread:.2f}, of bearings {facts.bearings:.2f}",
    ]
    axes.text(0.0, 1.02, "\n".join(lines), transform=axes.transAxes, fontsize=style.TEXT_SIZE, va="bottom")
    axes.text(
        0.0, 1.155, f"sequence {failure.sequence}", transform=axes.transAxes, fontsize=10.5, weight="bold", va="bottom"
    )


def _draw_paths(axes: Axes, positions: Any, colour: str, width: float, label: str) -> None:
    """Paths of positions [T, K, 2]."""
    paths = list(np.swapaxes(positions, 0, 1))
    axes.add_collection(LineCollection(paths, colors=colour, linewidths=width, label=label), autolim=False)
