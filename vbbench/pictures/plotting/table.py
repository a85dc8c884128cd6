"""A small table inside a figure: one row per answer, each with the line that it has in the figure."""

from collections.abc import Sequence
from typing import Any

from matplotlib.axes import Axes

from vbbench.pictures.plotting import style
from vbbench.pictures.plotting.looks import Look

ROW = 0.19
"""Height of a row in inches."""
_SWATCH, _GAP = 24.0, 16.0  # points


def draw_table(axes: Axes, head: Sequence[str], rows: Sequence[Sequence[str]], looks: Sequence[Look]) -> None:
    """Draw a table of texts, the first column after the line of the row's look, the others set to the right."""
    axes.set_axis_off()
    box = axes.get_window_extent()
    per_point = axes.figure.dpi / 72.0
    axes.set(xlim=(0.0, box.width / per_point), ylim=(len(rows) + 1.0, 0.0))
    right = _SWATCH + 6.0
    for c, cells in enumerate(zip(head, *rows, strict=True)):
        wide = max(map(style.text_width, cells))
        place, side = (right, "left") if c == 0 else (right + wide, "right")
        for r, cell in enumerate(cells):
            bold = "bold" if c == 0 and r > 0 else "normal"
            look: dict[str, Any] = {"ha": side, "va": "center", "fontsize": style.TEXT_SIZE, "fontweight": bold}
            colour = style.TRUTH if r == 0 else style.INK
            axes.text(place, r + 0.5, cell, color=colour, gid=f"cell-{r}-{c}", **look)
        right += wide * (1.15 if c == 0 else 1.0) + _GAP
    for r, own in enumerate(looks):
        axes.plot([0.0, _SWATCH], [r + 1.5, r + 1.5], color=own.colour, linestyle=own.dashes, linewidth=2.2)
