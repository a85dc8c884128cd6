"""A moment of KITTI 0019 as the README shows it: boxes over a plain ground, and the map of truth and estimate.

``python -m benchmarks.draw_kitti --source KITTI [--solver vb-sf]`` writes docs/images/kitti-0019.png. KITTI's own
pictures are left out even where they are at hand: their licence does not allow to ship them here.
"""

import argparse
import tempfile
from pathlib import Path

from PIL import Image

from vbbench.generation import generate
from vbbench.generation.footage import FootageOptions
from vbbench.generation.generator import Options
from vbbench.pictures.backdrop import Backdrop
from vbbench.pictures.film import Film
from vbbench.pictures.replay import load_replay
from vbbench.solving import solve

SEQUENCE, FRAME, EVERY = 1, 16, 4
OUT = Path(__file__).parents[1] / "docs" / "images" / "kitti-0019.png"


def draw(source: Path, solver: str, out: Path) -> None:
    """Generate, solve under `sequential`, and draw one frame."""
    options = Options(source=source, footage=FootageOptions(sequences=("0019",), every=EVERY))
    with tempfile.TemporaryDirectory() as work:
        dataset = generate("kitti", Path(work, "kitti"), options)
        replay = load_replay(dataset, SEQUENCE, [solve(dataset, solver, "sequential", Path(work, "answer"))])
        plain = Backdrop(dataset, replay.sequence, frames=[])
        picture = Image.fromarray(next(Film(replay, plain).frames([FRAME])))
    picture.save(out, optimize=True)


def main() -> None:
    """Parse arguments and draw."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--source", type=Path, required=True, help="folder with training/label_02, calib and oxts")
    parser.add_argument("--solver", default="vb-sf")
    parser.add_argument("--out", type=Path, default=OUT)
    arguments = parser.parse_args()
    draw(arguments.source, arguments.solver, arguments.out)


if __name__ == "__main__":
    main()
