"""The ten worst sequences of ``map-batch`` on Hotel and ETH: contact sheets, and what is special about each.

``python -m benchmarks.map_gallery [--jobs 2]`` writes docs/images/map-worst-<split>.png and prints a table a split.
"""

import argparse
from functools import partial
from pathlib import Path

import numpy as np
from PIL import Image

from benchmarks.map_evaluation import Case, answer, evaluate
from benchmarks.map_floor import OWN_PRIOR, Floor, least_errors
from vbbench.files.dataset import Dataset
from vbbench.geometry import FloatArray
from vbbench.pictures.plotting import save_picture
from vbbench.pictures.plotting.bird import draw_bird
from vbbench.pictures.plotting.figure import person_colours
from vbbench.pictures.plotting.style import Rectangles, lay_out
from vbbench.pictures.replay import load_replay
from vbbench.sequence import Sequence, Truth
from vbbench_baselines.joint_map.batch import MapBatch
from vbbench_baselines.joint_map.prior import Prior, get_prior

PROTOCOL, WORST, COLUMNS = "sequential", 10, 5
PANEL, GAP, HEAD = (2.55, 2.2), (0.5, 0.72), 0.35
SHEET_WIDTH = 1800
IMAGES = Path(__file__).parents[1] / "docs" / "images"


def draw(dataset: Dataset, prior: Prior, chosen: FloatArray, errors: FloatArray, out: Path) -> None:
    """A contact sheet of the last frames of some sequences with errors (Δx, Δt, Δr) [N, 3]."""
    rows = -(-len(chosen) // COLUMNS)
    size = COLUMNS * (PANEL[0] + GAP[0]) + 0.1, rows * (PANEL[1] + GAP[1]) + 0.05
    corners = [(i % COLUMNS, rows - 1 - i // COLUMNS) for i in range(len(chosen))]
    places: Rectangles = {
        str(index): (GAP[0] + c * (PANEL[0] + GAP[0]), HEAD + r * (PANEL[1] + GAP[1]), *PANEL)
        for index, (c, r) in zip(chosen, corners, strict=True)
    }
    figure = lay_out(size, places)
    for index, axes, (dx, dt, _) in zip(chosen, figure.axes, errors, strict=True):
        estimate, _ = answer(dataset, MapBatch(prior=prior), PROTOCOL, int(index))
        last = int(np.flatnonzero(dataset.sequence(int(index)).observed.any(axis=1))[-1])
        replay = load_replay(dataset, int(index)).with_answer("map-batch", PROTOCOL, estimate)
        draw_bird(axes, replay, last, person_colours(replay, last))
        axes.set_title(f"{index}: Δx {dx:.2f}, Δt {dt:.2f} m", fontsize=8)
        axes.set(xlabel="", ylabel="")
        axes.tick_params(labelsize=6)
    save_picture(figure, out)
    with Image.open(out) as picture:
        small = picture.convert("RGB").resize((SHEET_WIDTH, round(picture.height * SHEET_WIDTH / picture.width)))
    small.quantize(256, method=Image.Quantize.FASTOCTREE).save(out, optimize=True)


def facts(sequence: Sequence, truth: Truth) -> list[str]:
    """Frames, people in a frame, least of them with two known frames behind, and the largest steps out of line."""
    seen = sequence.observed
    counts = seen.sum(axis=1)
    old = (np.cumsum(seen, axis=0) > 2) & seen
    known = old.sum(axis=1)[2:]
    speeds = np.linalg.norm(np.diff(truth.positions, axis=0), axis=-1)
    bends = np.linalg.norm(np.diff(truth.positions, 2, axis=0), axis=-1)
    own = np.linalg.norm(np.diff(truth.poses[:, :2], 2, axis=0), axis=-1)
    distance = np.linalg.norm(truth.positions - truth.poses[:, None, :2], axis=-1)[seen]
    return [
        f"{sequence.frames}",
        f"{counts.mean():.1f}",
        f"{known.min()}",
        f"{np.nanmedian(distance):.1f}",
        f"{np.nanmedian(speeds):.2f}",
        f"{np.nanmedian(bends):.2f} / {np.nanmax(bends):.2f}",
        f"{np.median(own):.2f} / {own.max():.2f}",
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sequences", type=int, default=1000)
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    for split, own in OWN_PRIOR.items():
        case = Case(split=split)
        with case.made() as dataset:
            found = evaluate(dataset, partial(MapBatch, prior=case.prior), PROTOCOL, options.sequences, options.jobs)
            worst = np.argsort(-found.errors[:, 0])[:WORST]
            chosen, errors = found.sequences[worst], found.errors[worst]
            draw(dataset, case.prior, chosen, errors, IMAGES / f"map-worst-{split}.png")
            heads = (
                "Δx / Δt / Δr | floor Δx | flagged | frames | people | known, least | distance | step | bend | own bend"
            )
            print(f"\n| {split} | {heads} |\n" + "|---" * 11 + "|")
            for row, index in zip(worst, chosen, strict=True):
                sequence = dataset.sequence(int(index))
                truth = dataset.truth(sequence)
                floor = Floor(prior=get_prior(own), batch=True)
                spread = floor.spread(dataset.problem(sequence), sequence, truth, PROTOCOL)
                cells = [" / ".join(f"{e:.2f}" for e in found.errors[row])]
                cells += [f"{least_errors(spread, sequence, PROTOCOL)[0]:.2f}", "yes" if found.flagged[row] else "no"]
                print(f"| {index} | " + " | ".join([*cells, *facts(sequence, truth)]) + " |", flush=True)


if __name__ == "__main__":
    main()
