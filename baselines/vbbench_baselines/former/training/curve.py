"""The learning curve of a training: loss, and errors on held-out crowds, by number of windows."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes

from vbbench.pictures.plotting import save_picture
from vbbench.pictures.plotting.style import TEXT_SIZE, lay_out, write_heading
from vbbench.protocol import PROTOCOLS

SIZE, WIDE, HIGH = (9.6, 3.9), 3.9, 2.3
"""In inches: the picture, and each of its panels."""


def draw_curve(log: Sequence[Mapping[str, Any]], sequences: int, path: Path) -> None:
    """Draw the rows of the ``log`` of a training on so many ``sequences``."""
    panels = {"loss": (0.7, 0.6, WIDE, HIGH), "held out": (0.7 + WIDE + 0.9, 0.6, WIDE, HIGH)}
    figure = lay_out(SIZE, panels)
    loss, held_out = figure.axes
    write_heading(
        figure,
        0.7,
        "Training",
        f"{log[-1]['windows']:,} windows of {sequences:,} sequences, {log[-1]['seconds']:,.0f} s",
    )
    _draw(loss, log, ["loss"], "loss of a batch")
    shown = [f"{name} people" for name in PROTOCOLS if f"{name} people" in log[-1]]
    _draw(held_out, log, shown, "Δx on held-out sequences (m)")
    names = [name.removesuffix(" people") for name in shown]
    look: dict[str, Any] = {"fontsize": TEXT_SIZE, "frameon": False, "columnspacing": 1.0, "handlelength": 1.2}
    held_out.legend(names, loc="lower left", bbox_to_anchor=(-0.03, 1.0), ncols=4, **look)
    save_picture(figure, path)


def _draw(axes: Axes, log: Sequence[Mapping[str, Any]], names: Sequence[str], label: str) -> None:
    windows = [row["windows"] for row in log]
    for name in names:
        axes.plot(windows, [row[name] for row in log], "." if len(log) == 1 else "-")
    axes.set(xlabel="windows learned from", ylabel=label, ylim=(0.0, None))
    axes.xaxis.set_major_formatter("{x:,.0f}")
    axes.xaxis.get_major_locator().set_params(nbins=4)  # type: ignore[call-arg]
    axes.grid(alpha=0.3)
