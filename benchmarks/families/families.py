"""The families, as trials: what is solved, by which protocol."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

from benchmarks.families.places import WALKS, Places
from benchmarks.families.robot import Drive
from benchmarks.real_camera.measuring import Trial
from benchmarks.real_camera.scenes import with_gap
from vbbench.files.dataset import Dataset
from vbbench.sequence import Sequence, Truth

SPLITS = ("hotel", "eth-15fps", "students-resampled", "sim")
TIERS = ("noisy", "occluded", "tracked", "ideal", "field")
RATES = (2.5, 5.0, 10.0, 15.0, 30.0)
"""Hz."""
SEEDS = 3
BEFORE, GAPS = 5.0, (5.0, 20.0, 60.0)
"""s before a gap, and of gaps."""


@dataclass(frozen=True, kw_only=True)
class Family:
    """Something to score on.

    Parameters
    ----------
    name : what it is selected by.
    make : its trial.
    """

    name: str
    make: Callable[[Places], Trial]


def families(*, smoke: bool = False) -> list[Family]:
    """All families, or with ``smoke`` a few that need no data."""
    if smoke:
        return [
            Family(name="sim-noisy", make=partial(_board, split="sim", tier="noisy")),
            *_robot(seconds=8.0, seeds=1, crowds=(30,), rates=(5.0,)),
            Family(name="gap-robot-2s", make=partial(_robot_gap, seconds=2.0, drive=Drive(seconds=14.0, rate=5.0))),
        ]
    return [
        *_boards(),
        *_footage(),
        *_robot(seconds=60.0, seeds=SEEDS, crowds=(70, 30), rates=RATES),
        *_gaps(),
        *_walks(),
    ]


def _boards() -> Iterator[Family]:
    for split in SPLITS:
        for tier in TIERS:
            yield Family(name=f"{split}-{tier}", make=partial(_board, split=split, tier=tier))


def _board(places: Places, *, split: str, tier: str) -> Trial:
    return _trial(places.board(split, tier), "sequential")


def _footage() -> Iterator[Family]:
    for every in (4, 1):
        for found in (False, True):
            name = f"kitti-.{every}s-{'detector' if found else 'labels'}"
            yield Family(name=name, make=partial(_kitti, every=every, found=found))
    yield Family(name="kitti-.4s-labels-cold", make=partial(_kitti, every=4, found=False, protocol="cold-start"))
    for name, folder, every in (("argoverse2", "argoverse2/own", 4), ("nuscenes", "nuscenes/own", 5)):
        yield Family(name=name, make=partial(_own, name=name, folder=folder, every=every))
    yield Family(name="jrdb", make=lambda places: _trial(places.jrdb(), "cold-start"))


def _kitti(places: Places, *, every: int, found: bool, protocol: str = "sequential") -> Trial:
    return _trial(places.kitti(every, found=found), protocol)


def _own(places: Places, *, name: str, folder: str, every: int) -> Trial:
    return _trial(places.own(name, places.folder(folder), every), "sequential")


def _robot(*, seconds: float, seeds: int, crowds: tuple[int, ...], rates: tuple[float, ...]) -> Iterator[Family]:
    for people in crowds:
        for odometry in (True, False):
            for rate in rates:
                drive = Drive(people=people, seconds=seconds, rate=rate)
                name = f"robot-{people}-{'odometry' if odometry else 'alone'}-{rate:g}Hz"
                yield Family(name=name, make=partial(_drives, drive=drive, seeds=seeds, odometry=odometry))


def _drives(places: Places, *, drive: Drive, seeds: int, odometry: bool) -> Trial:
    trial = _trial(places.robot(drive, seeds), "cold-start")
    return trial if odometry else replace(trial, change=without_odometry)


def without_odometry(sequence: Sequence, _truth: Truth, _seed: int) -> Sequence:
    """The same where nothing measures how the camera moves."""
    return replace(sequence, given=replace(sequence.given, odometry=None))


def _gaps() -> Iterator[Family]:
    yield Family(name="gap-eth-15fps-5s", make=_eth_gap)
    for seconds in GAPS:
        drive = Drive(seconds=100.0, rate=5.0)
        yield Family(name=f"gap-robot-{seconds:g}s", make=partial(_robot_gap, seconds=seconds, drive=drive))


def _eth_gap(places: Places) -> Trial:
    dataset, wanted = places.board("eth-15fps", "noisy"), BEFORE + 5.0 + 4.0

    def lasts(truth: Truth) -> bool:
        return len(truth.poses) * dataset.info.dt >= wanted

    return replace(_gap(dataset, 5.0), chosen=lasts)


def _robot_gap(places: Places, *, seconds: float, drive: Drive) -> Trial:
    return _gap(places.robot(drive, 1 if places.smoke else SEEDS), seconds)


def _gap(dataset: Dataset, seconds: float) -> Trial:
    dt = dataset.info.dt
    change = with_gap("everybody", gap=round(seconds / dt), before=round(BEFORE / dt))
    return replace(_trial(dataset, "sequential"), change=change)


def _walks() -> Iterator[Family]:
    for name in WALKS:
        yield Family(name=f"walk-{name}", make=partial(_walk, name=name))


def _walk(places: Places, *, name: str) -> Trial:
    return _trial(places.walk(name), "cold-start")


def _trial(dataset: Dataset, protocol: str) -> Trial:
    return Trial(dataset=dataset, protocol=protocol, covariances=True)
