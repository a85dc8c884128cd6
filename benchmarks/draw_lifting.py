"""Draws docs/images/lifting.png: a recording with known truth, and what lifting makes of it.

python benchmarks/draw_lifting.py RECORDING OUT.png   (RECORDING as `vbbench export mot --heads` writes it)
"""

import json
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
import pyarrow.parquet as pq

from vbbench.generation.sources import Source
from vbbench_generators.lifting.heads import HeadBoxes, LiftingSettings
from vbbench_generators.lifting.lift import Lifted, lift
from vbbench_generators.recordings.readers.crohd import find_recording, read_heads

TRUE, FOUND = "#3b6ea5", "#d1495b"


def main(recording: Path, out: Path) -> None:
    archive = Source(path="none", url="", sha256="")
    boxes = read_heads(find_recording(recording.name, archive, recording, split="shibuya01"))
    lifted = lift(boxes, LiftingSettings())
    camera = json.loads((recording / "truth.json").read_text("utf-8"))["camera"]
    figure, axes = plt.subplots(2, 2, figsize=(12, 9), dpi=100, layout="constrained")
    draw_picture(axes[0, 0], boxes, lifted, camera)
    draw_residuals(axes[0, 1], boxes, lifted)
    draw_map(axes[1, 0], recording, lifted)
    draw_speeds(axes[1, 1], lifted)
    figure.savefig(out)


def draw_picture(axes: plt.Axes, boxes: HeadBoxes, lifted: Lifted, camera: dict[str, float]) -> None:
    now = boxes.frame == 500
    left, top, width, height = boxes.boxes[now].T
    found = lifted.calibration.horizon
    points = axes.scatter(left + width / 2, top + height / 2, c=np.sqrt(width * height), s=9, cmap="viridis")
    plt.colorbar(points, ax=axes, label="size of the box (px)")
    axes.axhspan(found.low, found.high, color=FOUND, alpha=0.35)
    axes.axhline(found.value, color=FOUND, lw=1.2, label=f"horizon found: {found.value:.1f}")
    axes.axhline(camera["horizon"], color=TRUE, lw=1.2, ls="--", label=f"true: {camera['horizon']:.1f}")
    axes.add_patch(plt.Rectangle((0, 0), *boxes.size, fill=False, color="0.5"))
    axes.set(xlim=(-30, boxes.size[0] + 30), ylim=(boxes.size[1] + 30, camera["horizon"] - 60))
    axes.set(title="One frame, and the horizon above it", xlabel="u (px)", ylabel="v (px)", aspect="equal")
    axes.legend(loc="upper right", fontsize=8, bbox_to_anchor=(1.0, 0.88))


def draw_residuals(axes: plt.Axes, boxes: HeadBoxes, lifted: Lifted) -> None:
    a, b, c = lifted.calibration.size_plane or (0.0, 0.0, 0.0)
    centre = boxes.boxes[:, :2] + (boxes.boxes[:, 2:] - boxes.size) / 2.0
    fitted = a + b * centre[:, 1] + c * centre[:, 0]
    relative = np.sqrt(boxes.boxes[:, 2] * boxes.boxes[:, 3]) / fitted - 1.0
    rows = centre[:, 1] + boxes.size[1] / 2.0
    edges = np.linspace(0, boxes.size[1], 28)
    bins = np.digitize(rows, edges) - 1
    spread = np.array([np.quantile(relative[bins == n], [0.05, 0.25, 0.5, 0.75, 0.95]) for n in range(27)])
    middle = (edges[1:] + edges[:-1]) / 2.0
    axes.fill_between(middle, spread[:, 0], spread[:, 4], color=FOUND, alpha=0.15, label="90 % of boxes")
    axes.fill_between(middle, spread[:, 1], spread[:, 3], color=FOUND, alpha=0.3, label="half of them")
    axes.plot(middle, spread[:, 2], color=FOUND, label="median")
    axes.axhline(0.0, color="0.4", lw=0.8)
    axes.set(title="Head sizes about their plane", xlabel="row (px)", ylabel="(size − plane) / plane")
    axes.legend(fontsize=8)


def draw_map(axes: plt.Axes, recording: Path, lifted: Lifted) -> None:
    table = pq.read_table(recording / "truth.parquet", filters=[("frame", "==", 500)])
    track, x, y = (table.column(name).to_numpy() for name in ("track", "right", "forward"))
    places = lifted.tracks.positions[500]
    known = np.isin(track, lifted.tracks.people)
    found = places[np.searchsorted(lifted.tracks.people, track[known])]
    axes.plot(np.stack([x[known], found[:, 0]]), np.stack([y[known], found[:, 1]]), color="0.6", lw=0.8, zorder=1)
    axes.scatter(x[known], y[known], s=14, facecolors="none", edgecolors=TRUE, label="true")
    axes.scatter(*found.T, s=7, color=FOUND, label="lifted")
    axes.plot(0, 0, "k^", ms=8, label="camera")
    axes.set(title="The ground, same frame", xlabel="X, right (m)", ylabel="Y, forward (m)", aspect="equal")
    axes.legend(fontsize=8, loc="lower right")


def draw_speeds(axes: plt.Axes, lifted: Lifted) -> None:
    steps = lifted.tracks.positions[50:] - lifted.tracks.positions[:-50]
    way = steps[::50][~np.isnan(steps[::50, :, 0])] / (50 * lifted.tracks.dt)
    way = way[np.hypot(*way.T) > 0.4]
    for stretch, colour, label in ((0.75, "0.65", "0.75 g"), (1.0, FOUND, "g found"), (1.33, "0.35", "1.33 g")):
        right, forward = way[:, 0], stretch * way[:, 1]
        bins = ((np.degrees(np.arctan2(forward, right)) + 195.0) // 30.0).astype(int) % 12
        speed = [np.median(np.hypot(right, forward)[bins == n]) for n in range(12)]
        axes.plot(np.arange(13) * 30 - 180, np.append(speed, speed[0]), "o-", ms=4, color=colour, label=label)
    axes.set(title="Median speed by direction", xlabel="direction of walking (°; 90 = forward)", ylabel="m/s")
    axes.set(xticks=range(-180, 181, 90), ylim=(0.7, 1.7))
    axes.legend(fontsize=8)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
