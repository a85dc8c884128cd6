"""How good a map made from a rendered film is: ``vbbench birdify`` on pictures of a dataset, against its truth.

``python -m benchmarks.film_to_map MAP --dataset DIR [--sequence 0] [--first 0]``, where MAP was made by ``vbbench
birdify`` from what ``vbbench export mot DIR --backend auto --sequence 0 --out MOT`` writes, or from those of its
pictures from frame ``first`` on. Prints how many boxes are right, and how far people and camera are from the truth:
no alignment but of the first frame, where the map's origin is.
"""

import argparse
from pathlib import Path

import numpy as np
import pyarrow.csv as pa_csv

from vbbench.exchange.box_rows import read_boxes, rows_in_frames
from vbbench.exchange.matching import match_boxes, true_rectangles
from vbbench.files.dataset import Dataset
from vbbench.geometry import FloatArray, world_to_relative, wrap_angle


def table(path: Path, *names: str) -> FloatArray:
    """Columns [N, M] of a CSV file."""
    columns = pa_csv.read_csv(path)
    return np.column_stack([columns[name].to_numpy() for name in names]).astype(np.float64)


def report(folder: Path, dataset: Dataset, number: int, start: int) -> str:
    """The figures as text."""
    sequence = dataset.sequence(number)
    truth, camera = dataset.truth(sequence), dataset.camera(sequence)
    real = true_rectangles(truth.positions, truth.heights, truth.poses, camera)
    boxes = read_boxes(folder / "recording" / "gt.txt", dataset.info.dt)
    rows = rows_in_frames(boxes, sequence.frames - start, dataset.info.dt)
    poses = {int(row[0]) - 1 + start: row[1:] for row in table(folder / "poses.csv", "frame", "x", "y", "yaw")}
    positions = table(folder / "positions.csv", "frame", "id", "x", "y")
    places = {(int(frame) - 1 + start, int(track)): place for frame, track, *place in positions}
    found = people = 0
    off, depth, seen_by = [], [], {}
    first = min(poses)
    for frame in sorted({n + start for n in rows.frame.tolist()} & poses.keys()):
        here, shown = np.flatnonzero(rows.frame == frame - start), np.flatnonzero(sequence.observed[frame])
        mine, theirs = match_boxes(rows.boxes[here], real[frame, shown], camera)
        found, people = found + len(mine), people + len(shown)
        for row, person in zip(here[mine], shown[theirs], strict=True):
            seen_by.setdefault(int(person), []).append(int(rows.track[row]))
            place = places.get((frame, int(rows.track[row])))
            if place is None:
                continue
            estimate = world_to_relative(np.array([place]), poses[frame])[0]
            actual = world_to_relative(truth.positions[frame, [person]], truth.poses[frame])[0]
            off.append(np.linalg.norm(estimate - actual))
            depth.append(np.linalg.norm(actual))
    path = np.array([poses[frame] for frame in sorted(poses)])
    true_path = truth.poses[sorted(poses)]
    moved = world_to_relative(true_path[:, :2], true_path[0])[:, ::-1] * [1.0, -1.0]
    away = np.linalg.norm(path[:, :2] - path[0, :2] - moved, axis=1)
    turned = np.abs(wrap_angle(path[:, 2] - path[0, 2] - (true_path[:, 2] - true_path[0, 2])))
    travelled = np.linalg.norm(np.diff(true_path[:, :2], axis=0), axis=1).sum()
    switches = sum(len(set(tracks)) - 1 for tracks in seen_by.values())
    relative = np.array(off) / np.array(depth)
    return "\n".join(
        [
            f"boxes: {found} of {people} people's found ({found / people:.0%}), {found / len(rows.frame):.0%} of "
            f"{len(rows.frame)} right; {len(seen_by)} people, tracks break or change {switches} times",
            f"people from the camera: off by {np.median(off):.2f} m (median), {np.mean(off):.2f} m (mean), "
            f"{np.median(relative):.0%} of their distance",
            f"camera, from frame {first}: off by {away.mean():.2f} m on average and {away[-1]:.2f} m at the end of "
            f"{travelled:.1f} m; heading by {turned.mean():.3f} rad",
        ]
    )


def main() -> None:
    """Parse and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("map", type=Path)
    parser.add_argument("--dataset", type=Path, required=True)
    parser.add_argument("--sequence", type=int, default=0)
    parser.add_argument("--first", type=int, default=0)
    asked = parser.parse_args()
    print(report(asked.map, Dataset(asked.dataset), asked.sequence, asked.first))


if __name__ == "__main__":
    main()
