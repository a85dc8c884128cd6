"""The examples as a picture: a map with people's posteriors along their rays, and the observer's in ten frames."""

from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import Colormap, ListedColormap, to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from vbbench.geometry import FloatArray
from vbbench.pictures.plotting import style
from vbbench.pictures.plotting.posterior import density_level
from vbbench.pictures.plotting.style import Rectangles, lay_out
from vbbench.reproduction.posterior.study import Posteriors, ShownExample
from vbbench.reproduction.posterior.walking import WINDOW, along_walk

SHARES = (0.99, 0.95, 0.8, 0.5)
"""Probability inside each contour, the widest first."""
_WIDTH, _HEAD, _FOOT, _BLOCK = 14.0, 1.0, 0.35, 3.95  # inches; a block is an example with its title
_MAP = (0.65, 4.5, 3.15)  # left edge, width and height
_PANEL, _STEP, _LEFT, _COLUMNS = 1.5, 1.68, 5.55, 5
_MARGIN = 1.0  # m around everything on a map
_FILLED = colormaps["YlOrBr"](np.linspace(0.18, 0.82, len(SHARES)))


def plot_examples(found: Posteriors) -> Figure:
    """Draw every example, a block each."""
    blocks, half = found.examples, _half_width(found)
    height = _HEAD + len(blocks) * _BLOCK + _FOOT
    figure = lay_out((_WIDTH, height), _layout(len(blocks), height))
    parts = {axes.get_label(): axes for axes in figure.axes}
    colours = _frame_colours()
    for row, shown in enumerate(blocks):
        _draw_map(parts[f"map {row}"], shown, colours)
        for n in range(WINDOW):
            _draw_instant(parts[f"{row} {n}"], shown, n, half, colours)
        one = shown.example
        facts = f"sequence {one.sequence}, {one.people:.1f} people seen, spread of directions {one.spread:.2f}, "
        facts += f"of lines {one.lines:.2f}; mean entropy {_mean_entropy(shown):.2f} nats"
        x, y = _MAP[0] / _WIDTH, 1.0 - (_HEAD + row * _BLOCK + 0.22) / height
        figure.text(x, y, f"({chr(ord('a') + row)}) {one.title}", fontsize=11.0, weight="bold", color=style.INK)
        figure.text(_LEFT / _WIDTH, y, facts, fontsize=style.TEXT_SIZE, color=style.INK)
    _draw_head(figure, found, half)
    return figure


def _layout(blocks: int, height: float) -> Rectangles:
    places: Rectangles = {}
    for row in range(blocks):
        top = height - _HEAD - row * _BLOCK - 0.34
        places[f"map {row}"] = (_MAP[0], top - _MAP[2], *_MAP[1:])
        for n in range(WINDOW):
            left, down = _LEFT + n % _COLUMNS * _STEP, n // _COLUMNS * (_PANEL + 0.14)
            places[f"{row} {n}"] = (left, top - down - _PANEL, _PANEL, _PANEL)
    return places


def _draw_head(figure: Figure, found: Posteriors, half: float) -> None:
    left, height, split = _MAP[0] / _WIDTH, figure.get_figheight(), found.study.split
    title = "Posteriors of people along their viewing rays (left) and of the observer's place (right), ten frames each"
    figure.text(left, 1.0 - 0.34 / height, title, fontsize=12.5, weight="bold", color=style.INK)
    text = f"split {split}, one-step, seed {found.study.seed}; every square on the right is {2.0 * half:g} m wide, "
    text += "centred on the true place, in the axes of the map; a colour is a frame on both sides"
    figure.text(left, 1.0 - 0.58 / height, text, fontsize=style.TEXT_SIZE, color=style.INK)
    shares = zip(SHARES, _FILLED, strict=True)
    handles: list[Any] = [Patch(color=colour, label=f"{share:.0%}") for share, colour in shares]
    handles[-1].set_label(f"{SHARES[-1]:.0%} of the posterior")
    point: dict[str, Any] = {"linestyle": "none", "color": style.INK}
    handles += [
        Line2D([], [], marker="+", markersize=7, label="observer, true", **point),
        Line2D([], [], marker="o", markersize=2.6, label="person, true", **point),
        Line2D([], [], color=style.TRUTH, linewidth=1.4, label="the observer's true path"),
        Line2D([], [], color=style.UNSEEN, linewidth=0.6, label="viewing rays of the last frame"),
    ]
    place = (left, 1.0 - 0.64 / height)
    look: dict[str, Any] = {"frameon": False, "fontsize": style.TEXT_SIZE, "borderaxespad": 0.0, "borderpad": 0.2}
    figure.legend(handles=handles, loc="upper left", bbox_to_anchor=place, ncols=len(handles), **look)


def _half_width(found: Posteriors) -> float:
    """Half the side in m of every square: most posteriors with their true places fit."""
    reaches = []
    for shown in found.examples:
        for one in shown.instants:
            mean, covariance = one.place.moments()
            off = np.abs(mean - shown.poses[one.frame, :2]).max()
            reaches.append(off + 2.0 * float(np.sqrt(np.diag(covariance).max())))
    return float(np.ceil(10.0 * np.quantile(reaches, 0.9)) / 10.0) if reaches else 1.0


def _frame_colours() -> Colormap:
    """From the first frame to the last."""
    return ListedColormap(style.distance_colours()(np.linspace(0.0, 0.92, WINDOW)), "frames")


def _mean_entropy(shown: ShownExample) -> float:
    return float(np.mean([one.density.entropy for one in shown.instants])) if shown.instants else float("nan")


def _draw_map(axes: Axes, shown: ShownExample, colours: Colormap) -> None:
    frames = np.array(shown.example.frames)
    turned = along_walk(shown.poses[frames, :2])
    path = turned(shown.poses[frames, :2])
    axes.plot(*path.T, color=style.TRUTH, linewidth=1.4, zorder=2)
    axes.plot(*path.T, "+", color=style.INK, markersize=6, zorder=4)
    seen = [path]
    for one in shown.instants:
        _draw_streaks(axes, turned(one.places), one.probabilities, to_rgb(colours(one.frame - frames[0])))
        here = turned(shown.positions[one.frame])
        here = here[~np.isnan(here[:, 0])]
        axes.plot(*here.T, ".", color=style.INK, markersize=2.2, zorder=5)
        seen.append(here)
    if shown.instants:
        _draw_rays(axes, path[shown.instants[-1].frame - frames[0]], turned(shown.instants[-1].places))
    _frame_map(axes, np.concatenate(seen))
    axes.tick_params(labelsize=style.LABEL_SIZE + 1.0)


def _draw_streaks(
    axes: Axes, places: FloatArray, probabilities: FloatArray, colour: tuple[float, float, float]
) -> None:
    """Each person's posterior along its ray, the darker the more probable: [M, S, 2] and [M, S]."""
    for own, probability in zip(places, probabilities, strict=True):
        there = probability > 0.0
        line, mass = own[there], probability[there]
        pieces = np.stack([line[:-1], line[1:]], axis=1)
        strength = np.sqrt(0.5 * (mass[:-1] + mass[1:]) / mass.max())
        rgba = np.concatenate([np.tile(colour, (len(pieces), 1)), strength[:, None]], axis=1)
        axes.add_collection(LineCollection(list(pieces), colors=rgba, linewidths=3.4, zorder=3), autolim=False)


def _draw_rays(axes: Axes, here: FloatArray, places: FloatArray) -> None:
    """The last frame's viewing rays, from the observer's true place ``here`` [2] to the places [M, S, 2]."""
    ends = places[:, places.shape[1] // 2]
    rays = np.stack([np.broadcast_to(here, ends.shape), ends], axis=1)
    axes.add_collection(LineCollection(list(rays), colors=style.UNSEEN, linewidths=0.6, zorder=1.5), autolim=False)


def _frame_map(axes: Axes, points: FloatArray) -> None:
    """Set limits that hold all points [N, 2] at equal scale."""
    low, high = points.min(axis=0) - _MARGIN, points.max(axis=0) + _MARGIN
    box = axes.get_window_extent()
    size = np.array([box.width, box.height])
    spans = float(np.max((high - low) / size)) * size
    low, high = (low + high - spans) / 2.0, (low + high + spans) / 2.0
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    axes.set_aspect("equal")
    axes.set_xlabel("along the observer's walk (m)", fontsize=style.TEXT_SIZE, labelpad=1.0)
    axes.set_ylabel("to its left (m)", fontsize=style.TEXT_SIZE, labelpad=1.0)
    axes.grid(color=style.FAINT, linewidth=0.6)
    axes.set_axisbelow(True)


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
    turned = along_walk(shown.poses[np.array(shown.example.frames), :2])
    points = turned(place.points()) - turned(shown.poses[frame, :2])
    levels = [density_level(place.mass, share) for share in SHARES]
    filled: Any = [*levels, float(place.mass.max()) * 1.01]
    axes.contourf(points[..., 0], points[..., 1], place.mass, filled, colors=list(map(tuple, _FILLED)))
    axes.plot(0.0, 0.0, "+", color=style.INK, markersize=7)
    people = int((~np.isnan(shown.positions[frame, :, 0])).sum())
    axes.text(0.96, 0.04, f"{found[0].density.entropy:.1f} nats, {people} people", ha="right", va="bottom", **words)
