"""The observer's location posterior of one frame: as a landscape over the bird's-eye view, and close up."""

from pathlib import Path
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle

from vbbench.files.dataset import Dataset
from vbbench.geometry import FloatArray
from vbbench.pictures.plotting import style
from vbbench.pictures.plotting.bird import draw_bird
from vbbench.pictures.plotting.captions import cautions, draw_legend, draw_scale, draw_title
from vbbench.pictures.plotting.figure import middle_frame, person_colours
from vbbench.pictures.plotting.saving import check_ending, save_picture
from vbbench.pictures.plotting.style import Rectangles, lay_out
from vbbench.pictures.replay import Replay, load_replay
from vbbench.protocol import START_FRAMES
from vbbench.solving.posterior import Posterior, find_posterior

_SIZE = (13.7, 7.3)
_PARTS: Rectangles = {
    "bird": (0.6, 0.55, 6.9, 6.1),
    "close": (8.35, 2.75, 5.1, 3.9),
    "scale": (8.35, 1.75, 2.1, 0.14),
    "energy": (8.35, 0.95, 2.1, 0.14),
    "legend": (10.65, 0.1, 2.95, 1.95),
}
_SHARES: dict[float, Literal["-", ":"]] = {0.95: ":", 0.5: "-"}
"""Probability inside each contour, and its line."""

_MAP = "YlOrBr"
_GRID = 141  # points a side
_EDGE = 9.0  # excess of −ln p at the edge of the close-up: p is e⁻⁹ of its maximum there


def plot_posterior(
    dataset: Dataset, index: int, *, solver: str = "vb-cv", protocol: str = "one-step", frame: int | None = None
) -> Figure:
    """Draw a solver's posterior of the observer's location in one frame.

    Parameters
    ----------
    dataset, index : the sequence.
    solver : a registered name or ``module:attribute`` of a `vbbench.solver.LocationPosterior`.
    protocol : what the solver is given.
    frame : frame of the sequence, from 0; by default the fullest of the middle third.

    Raises
    ------
    VbbenchError
        As `vbbench.solving.posterior.find_posterior` does.
    """
    if frame is None:
        frame = max(START_FRAMES, middle_frame(dataset.sequence(index)))
    posterior = find_posterior(dataset, index, frame, solver=solver, protocol=protocol)
    replay = load_replay(dataset, index).with_answer(solver, protocol, posterior.estimate)
    colours = person_colours(replay, frame)
    figure = lay_out(_SIZE, _PARTS, cautions(replay))
    parts = {axes.get_label(): axes for axes in figure.axes}
    draw_bird(parts["bird"], replay, frame, colours)
    _draw_landscape(parts["bird"], parts["energy"], posterior)
    grid = _close_up(parts["close"], posterior, replay.known.poses[frame])
    _draw_close_up(parts["close"], posterior, replay, frame, *grid)
    x, y = grid
    outline = Rectangle((x[0], y[0]), np.ptp(x), np.ptp(y), fill=False, edgecolor=style.INK, linewidth=0.8, zorder=5)
    parts["bird"].add_patch(outline).set_gid("close-up")
    draw_scale(parts["scale"], colours)
    draw_legend(parts["legend"], replay, frame, _handles())
    draw_title(figure, replay, frame)
    return figure


def plot_posterior_to_file(dataset: Dataset, index: int, out: Path | str, **options: Any) -> Path:
    """Draw a posterior into a PNG, PDF or SVG file; see `plot_posterior` for the options."""
    check_ending(out)
    save_picture(plot_posterior(dataset, index, **options), out)
    return Path(out)


def _draw_landscape(axes: Axes, scale: Axes, posterior: Posterior) -> None:
    """Paint how much −ln p grows away from the estimate, in powers of ten."""
    x, y = (np.linspace(*limits, _GRID) for limits in (axes.get_xlim(), axes.get_ylim()))
    excess = posterior.excess(x, y).clip(1.0)
    norm = LogNorm(1.0, max(10.0, float(excess.max())))
    painted = _paint(axes, x, y, excess, gid="landscape", norm=norm, cmap=f"{_MAP}_r", alpha=0.45)
    bar = scale.figure.colorbar(painted, cax=scale, orientation="horizontal")
    bar.outline.set_linewidth(0.5)
    scale.tick_params(labelsize=style.TEXT_SIZE)
    scale.set_title("map: −ln p of a place above the best", fontsize=style.TEXT_SIZE, loc="left")


def _paint(axes: Axes, x: FloatArray, y: FloatArray, values: FloatArray, **look: Any) -> AxesImage:
    """Values [M, N] at the points of x [N] and y [M] as a picture under everything else."""
    look |= {"extent": (x[0], x[-1], y[0], y[-1]), "origin": "lower", "aspect": "auto"}
    return axes.imshow(values, interpolation="bilinear", zorder=0.2, **look)


def _close_up(axes: Axes, posterior: Posterior, known: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The grid of the close-up: as far as the posterior reaches, and the true place where it is known."""
    away = np.nanmax(np.abs(known[:2] - posterior.pose[:2]), initial=0.0)
    half = max(posterior.reach(_EDGE), 1.2 * float(away))
    steps = np.linspace(-half, half, _GRID)
    box = axes.get_window_extent()
    return posterior.pose[0] + steps * box.width / box.height, posterior.pose[1] + steps


def _draw_close_up(axes: Axes, posterior: Posterior, replay: Replay, frame: int, x: FloatArray, y: FloatArray) -> None:
    density = np.exp(-posterior.excess(x, y))
    _paint(axes, x, y, density, gid="density", cmap=_MAP, vmin=0.0)
    for share, line in _SHARES.items():
        axes.contour(x, y, density, [density_level(density, share)], colors=style.INK, linestyles=line, linewidths=0.9)
    if replay.truth is not None:
        _draw_place(axes, replay.known.poses[frame], style.TRUTH, "place-truth")
    _draw_place(axes, posterior.pose, style.ESTIMATE, "place-estimate")
    axes.set(xlabel="x (m)", ylabel="y (m)")
    long, short = spread(density, x, y)
    text = f"the observer's place: σ = {long:.3f} m and {short:.3f} m along its axes"
    axes.set_title(text, fontsize=style.TEXT_SIZE, loc="left")


def density_level(density: FloatArray, share: float) -> float:
    """The density above which lies ``share`` of the probability of a grid."""
    falling = np.sort(density, axis=None)[::-1]
    mass = np.cumsum(falling)
    return float(falling[np.searchsorted(mass, share * mass[-1]).clip(max=len(falling) - 1)])


def spread(density: FloatArray, x: FloatArray, y: FloatArray) -> tuple[float, float]:
    """Standard deviations in m along the principal axes of the density [M, N] on the grid of x [N] and y [M]."""
    grid = np.stack(np.meshgrid(x, y)).reshape(2, -1)
    variances = np.linalg.eigvalsh(np.cov(grid, aweights=density.ravel())).clip(0.0)
    return float(np.sqrt(variances[1])), float(np.sqrt(variances[0]))


def _draw_place(axes: Axes, pose: FloatArray, colour: str, gid: str) -> None:
    axes.plot(*pose[:2], marker="o", markersize=7.5, color=colour, markeredgecolor="white", zorder=6, gid=gid)


def _handles() -> list[Line2D]:
    look: dict[str, Any] = {"color": style.INK, "linewidth": 0.9}
    return [
        Line2D([], [], linestyle=line, label=f"close up: {share:.0%} of the posterior", **look)
        for share, line in _SHARES.items()
    ]
