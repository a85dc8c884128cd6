"""What each part of the joint problem of rough cameras is worth: one left out at a time, the constants as they are.

``python -m benchmarks.real_camera_ablation --kitti ~/kitti [--only white,window] [--cache DIR] [--every 4]`` prints the
table of docs/real-cameras.md: `map-causal`, sequential, Δx / Δt in m. KITTI is the mean of six cells (three recordings,
.4 and .1 s), each the mean of its runs. Of tier `field`, every fourth sequence of Hotel and ETH seen from a vehicle.
"""

import argparse
import warnings
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from unittest.mock import patch

import numpy as np

from benchmarks.real_camera.cells import KITTI
from benchmarks.real_camera.measuring import Runs, Trial, measure
from benchmarks.real_camera.scenes import Scenes
from benchmarks.real_camera.targets import joined
from vbbench.camera import Camera
from vbbench.geometry import FloatArray
from vbbench.solver import Frame, FrameEstimate, Problem
from vbbench_baselines.common.bearings import Bearings, bearings_of
from vbbench_baselines.joint_map.causal import MapCausal
from vbbench_baselines.joint_map.real_camera import tracking
from vbbench_baselines.joint_map.real_camera.hands import Hands
from vbbench_baselines.joint_map.real_camera.noise import NoiseLearner
from vbbench_baselines.joint_map.real_camera.settings import Settings

NOTHING = 1e6
"""Standard deviation, scale or degrees of freedom of what tells nothing."""

Patch = Callable[[], AbstractContextManager[object]]
"""Takes a part out that no option does, as long as it is entered."""


def no_borders() -> AbstractContextManager[object]:
    """Boxes that the picture cuts are taken as whole ones."""

    def whole(camera: Camera, boxes: FloatArray) -> Bearings:
        seen = bearings_of(camera, boxes)
        return seen._replace(cut=np.zeros_like(seen.cut))

    return patch.object(tracking, "bearings_of", whole)


def always_going() -> AbstractContextManager[object]:
    """A vehicle moves in every frame."""
    made = Settings.observer
    return patch.object(Settings, "observer", lambda *asked: made(*asked)._replace(going=1_000_000))


def no_changes() -> AbstractContextManager[object]:
    """Tracks show the same people for ever."""
    return patch.object(Hands, "changes", lambda *_: {})


def all_forgotten() -> AbstractContextManager[object]:
    """What has left the window is not carried on."""
    return patch.object(tracking, "let_first_go", lambda *_: None)


def nothing_learned() -> AbstractContextManager[object]:
    """The noise stays as it is believed at first."""
    return patch.object(NoiseLearner, "learn", lambda *_: None)


def held(sigma: tuple[float | None, ...] = (None,) * 3, tau: float | None = None) -> AbstractContextManager[object]:
    """σ of some cues and τ of all stay so, whatever is learned."""
    learn = NoiseLearner.learn

    def learn_the_rest(learner: NoiseLearner, told: FloatArray) -> None:
        learn(learner, told)
        noise = learner.noise
        kept = [was if value is None else value for value, was in zip(sigma, noise.sigma, strict=True)]
        memory = noise.tau if tau is None else np.full(3, tau)
        learner.noise = noise._replace(sigma=np.array(kept), tau=memory)

    return patch.object(NoiseLearner, "learn", learn_the_rest)


ALL = Settings()
COLUMN, LENGTH, FOOT = ALL.noise


@dataclass(frozen=True, kw_only=True)
class Variant:
    """The solver without a part.

    Parameters
    ----------
    name : of the row.
    settings : the constants.
    without : takes out what no constant does.
    """

    name: str
    settings: Settings = ALL
    without: Patch = nullcontext


VARIANTS = {
    "all": Variant(name="all"),
    "white": Variant(
        name="white box noise (τ .01 s)",
        settings=replace(ALL, memory=(0.01,) * 3, noise_staying=NOTHING),
        without=partial(held, tau=0.01),
    ),
    "unlearned": Variant(name="noise not learned", without=nothing_learned),
    "borders": Variant(name="no border rule", without=no_borders),
    "edge": Variant(name="no near edge", settings=replace(ALL, edge=0.0, edge_std=0.001)),
    "foot": Variant(
        name="no foot cue",
        settings=replace(ALL, noise=(COLUMN, LENGTH, NOTHING)),
        without=partial(held, sigma=(None, None, NOTHING)),
    ),
    "length": Variant(
        name="no length cue",
        settings=replace(ALL, noise=(COLUMN, NOTHING, FOOT)),
        without=partial(held, sigma=(None, NOTHING, None)),
    ),
    "vehicle": Variant(name="vehicle law only", settings=replace(ALL, laws=(1.0, 0.0, 0.0))),
    "pedestrian": Variant(name="pedestrian laws only", settings=replace(ALL, laws=(0.0, 0.2, 0.4))),
    "drag": Variant(name="no pull to slowness", settings=replace(ALL, drag=0.0)),
    "standing": Variant(name="a vehicle never stands", without=always_going),
    "gaussian": Variant(name="Gaussian steps of the vehicle", settings=replace(ALL, vehicle_nu=(NOTHING,) * 3)),
    "sideways": Variant(name="no Cauchy law of slipping", settings=replace(ALL, slip=NOTHING)),
    "turning": Variant(name="no Cauchy law of turning", settings=replace(ALL, turn=NOTHING)),
    "return": Variant(name="people do not come back to their way", settings=replace(ALL, walk_b=(0.0, 0.0))),
    "sway": Variant(name="people sway no more within a stride", settings=replace(ALL, walk_b_growth=0.0)),
    "people": Variant(name="σ of people's walks fixed", settings=replace(ALL, walk_people=1e9)),
    "pace": Variant(name="people's pace not counted", settings=replace(ALL, pace=0.0)),
    "jumps": Variant(name="tracks never begin anew", without=no_changes),
    "past": Variant(name="what left the window forgotten", without=all_forgotten),
    "window": Variant(name="window of 40 frames", settings=replace(ALL, window=40)),
    "exact": Variant(name="camera taken for exact"),
}


class Lacking(MapCausal):
    """``map-causal`` without a part, which is missing only while it works: other variants use the same process."""

    def __init__(self, variant: Variant) -> None:
        super().__init__(real=None if variant is VARIANTS["exact"] else variant.settings)
        self._variant = variant

    def start(self, problem: Problem) -> None:
        """See `vbbench.solver.FrameSolver.start`."""
        with self._variant.without():
            super().start(problem)

    def step(self, frame: Frame) -> FrameEstimate:
        """See `vbbench.solver.FrameSolver.step`."""
        with self._variant.without():
            return super().step(frame)


def __getattr__(name: str) -> Callable[[], Lacking]:
    """Makers of the variants, as attributes of this module."""
    if name not in VARIANTS:
        raise AttributeError(name)
    return partial(Lacking, VARIANTS[name])


def cells(scenes: Scenes, name: str, every: int) -> Iterator[tuple[str, list[Runs]]]:
    """Where a variant is measured, and its runs in each cell of it."""

    def runs(dataset: Trial, stride: int = 1) -> Runs:
        return measure(dataset, f"{__spec__.name}:{name}", jobs=scenes.jobs, every=stride)

    footage = [scenes.footage(recording, step) for step in (4, 1) for recording in KITTI]
    yield "KITTI", [runs(Trial(dataset=dataset, protocol="sequential")) for dataset in footage]
    for split in ("hotel", "eth-15fps"):
        yield split, [runs(Trial(dataset=scenes.board(split, "field"), protocol="sequential"), every)]


def row(name: str, found: Iterator[tuple[str, list[Runs]]]) -> str:
    """A line of the table: means of cells' means, and the worst runs."""
    texts = []
    for _, parts in found:
        means = tuple(float(np.mean([np.nanmean(getattr(runs, field)) for runs in parts])) for field in ("dx", "dt"))
        worst = tuple(max(float(np.nanmax(getattr(runs, field))) for runs in parts) for field in ("dx", "dt"))
        texts += [joined(means), joined(worst)]
    return f"| {name} | " + " | ".join(texts) + " |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kitti", type=Path, required=True, help="KITTI's folder")
    parser.add_argument("--only", default="", metavar="VARIANT,...", help=", ".join(VARIANTS))
    parser.add_argument("--cache", type=Path, default=Path("out/real-camera"), help="where datasets are kept")
    parser.add_argument("--every", type=int, default=4, help="of field, only every so many-th sequence")
    parser.add_argument("--jobs", type=int, default=2)
    asked = parser.parse_args()
    names = [name for name in asked.only.split(",") if name] or list(VARIANTS)
    if unknown := set(names) - set(VARIANTS):
        parser.error(f"no variant {', '.join(sorted(unknown))}; there are {', '.join(VARIANTS)}")
    scenes = Scenes(kitti=asked.kitti, cache=asked.cache, jobs=asked.jobs)
    warnings.filterwarnings("ignore", "A worker stopped", UserWarning)
    places = [f"{place}{part}" for place in ("KITTI", "hotel, field", "eth, field") for part in ("", ", worst run")]
    print("| | " + " | ".join(places) + " |\n" + "|---" * 7 + "|")
    for name in names:
        print(row(VARIANTS[name].name, cells(scenes, name, asked.every)), flush=True)


if __name__ == "__main__":
    main()
