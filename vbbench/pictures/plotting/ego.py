"""The ego view: the panorama strip or perspective image with its boxes, as the camera saw them."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.patches import Rectangle

from vbbench.boxes import BOX_ASPECT
from vbbench.camera import Camera, PanoramaCamera, PerspectiveCamera
from vbbench.geometry import FloatArray, IntArray
from vbbench.pictures.plotting import labels, style
from vbbench.pictures.plotting.moment import Moment

STRIP_ASPECT = 0.22
"""Height of the panorama strip as a fraction of its width."""


def draw_ego(axes: Axes, moment: Moment, colours: ScalarMappable) -> None:
    """Draw the boxes of one moment; a box that crosses the seam of a panorama is drawn at both ends."""
    camera = moment.info.camera
    _set_window(axes, camera)
    axes.axhline(camera_horizon(camera), color="#9a9a9a", linewidth=0.8, linestyle=(0, (6, 3)), zorder=1, gid="horizon")
    # Boxes have no fill worth the name: small ones lie on top, so that none is lost behind somebody near.
    near_to_far = np.flatnonzero(moment.observed)[np.argsort(-moment.boxes[moment.observed, 2])]
    hues = [(float(r), float(g), float(b)) for r, g, b, _ in colours.to_rgba(moment.distances)]
    for order, k in enumerate(near_to_far):
        colour = hues[k]
        for u in _columns(camera, moment.boxes[k]):
            _draw_box(axes, u, moment.boxes[k], colour, f"box-{moment.sequence.tracks[k]}", 2.0 + order / 1000.0)
    _draw_labels(axes, moment, near_to_far)


def camera_horizon(camera: Camera) -> float:
    """Row in px of everything at the camera's own height."""
    return float(camera.cy) if isinstance(camera, PanoramaCamera | PerspectiveCamera) else 0.0


def _set_window(axes: Axes, camera: Camera) -> None:
    if isinstance(camera, PanoramaCamera):
        _set_strip(axes, camera)
    elif isinstance(camera, PerspectiveCamera):
        axes.set(xlim=(0, camera.width), ylim=(camera.height, 0), xlabel="u (px)", ylabel="v (px)")
    axes.set_aspect("equal")
    axes.apply_aspect()  # labels are placed by the size that the axes have from here on


def _set_strip(axes: Axes, camera: PanoramaCamera) -> None:
    rows = STRIP_ASPECT * camera.width
    axes.set(xlim=(0, camera.width), ylim=(camera.cy + 0.72 * rows, camera.cy - 0.28 * rows), ylabel="v (px)")
    axes.set_xlabel("u (px)")
    quarters = axes.secondary_xaxis("top")
    quarters.set_xticks(camera.width * np.arange(5) / 4.0, ["behind", "left 90°", "ahead", "right 90°", "behind"])
    quarters.tick_params(labelsize=style.TEXT_SIZE, length=3)
    for fraction in (0.25, 0.5, 0.75):
        axes.axvline(fraction * camera.width, color=style.FAINT, linewidth=0.8, zorder=0.5)


def _columns(camera: Camera, box: FloatArray) -> list[float]:
    """Centre columns at which a box shows: two where it crosses the seam."""
    u, half = float(box[0]), 0.5 * BOX_ASPECT * float(box[2])
    if not isinstance(camera, PanoramaCamera):
        return [u]
    return [u] + [u + camera.width] * (u < half) + [u - camera.width] * (u + half > camera.width)


def _draw_box(
    axes: Axes, u: float, box: FloatArray, colour: tuple[float, float, float], gid: str, zorder: float
) -> None:
    height = float(box[2])
    corner = (u - 0.5 * BOX_ASPECT * height, float(box[1]) - 0.5 * height)
    face = (*colour, 0.10)
    patch = Rectangle(corner, BOX_ASPECT * height, height, facecolor=face, edgecolor=colour, linewidth=1.2, gid=gid)
    axes.add_patch(patch).set_zorder(zorder)


def _draw_labels(axes: Axes, moment: Moment, people: IntArray) -> None:
    """One row of ids over the heads, each joined to its box; set upright where they would not fit in a line."""
    people = people[: style.MOST_LABELS]
    texts = [str(track) for track in moment.sequence.tracks[people]]
    widths = labels.text_extent(texts, style.LABEL_SIZE)[:, 0] + 2.0
    width = axes.get_xlim()[1]
    per_point = 72.0 / axes.figure.dpi * axes.transData.get_matrix()[0, 0]
    in_line = widths.sum() < 0.9 * width * per_point
    gap = (widths.max(initial=0.0) if in_line else 1.2 * style.LABEL_SIZE) / per_point
    u, tops = moment.boxes[people, 0], moment.boxes[people, 1] - 0.5 * moment.boxes[people, 2]
    places = labels.spread(u, gap, 0.7 * gap, width - 0.7 * gap)
    row = _label_row(axes, tops, camera_horizon(moment.info.camera))
    for text, place, column, top in zip(texts, places, u, tops, strict=True):
        _draw_label(axes, text, (column, top), (place, row), 0 if in_line else 90)


def _draw_label(axes: Axes, text: str, head: tuple[float, float], place: tuple[float, float], rotation: float) -> None:
    leader = {"arrowstyle": "-", "color": "#b0b0b0", "linewidth": 0.5, "shrinkA": 0, "shrinkB": 0}
    label = axes.annotate(text, head, place, ha="center", va="bottom", arrowprops=leader, annotation_clip=False)
    label.set(fontsize=style.LABEL_SIZE, color=style.INK, rotation=rotation, zorder=4, gid=f"id-{text}")


def _label_row(axes: Axes, tops: FloatArray, horizon: float) -> float:
    low, high = sorted(axes.get_ylim())
    pad = 0.05 * (high - low)
    return float(np.clip(min(np.min(tops, initial=horizon), horizon) - pad, low + 2.0 * pad, high))
