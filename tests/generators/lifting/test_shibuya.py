"""A crowd photographed from above, annotated, and lifted to the ground again is where it was, within stated bounds.

The bounds are those asked of the split: horizon within 8 px, camera height within 5 %, distances between people within
10 %, with head boxes that are 12 % wrong.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from tests.lib.crohd_files import SEQINFO, lines_of, write_recording
from tests.lib.lifting_crowd import SIZE, Camera, ground_matrix, photograph, walk
from vbbench.cli import main
from vbbench.files.dataset import Dataset
from vbbench.generation.generator import Options
from vbbench.registry import load

CAMERA = Camera(focal=0.5 * SIZE[0] / np.tan(np.radians(40.0)), height=7.0)
PEOPLE, FRAMES, DT = 150, 300, 0.04


@dataclass(frozen=True, kw_only=True)
class Trip:
    """What the recording was made from, and what came back."""

    truth: np.ndarray
    recording: Path
    made: Dataset

    @property
    def calibration(self):
        return self.made.info.calibration

    def pairs(self):
        """True and lifted distances in m of people at least 1 m apart, every second."""
        people, lifted, _ = self.made.scene(0)
        kept = people <= PEOPLE  # a track that is cut goes on under a higher number
        apart, found = (
            _distances(places[::25]) for places in (self.truth[: len(lifted), people[kept] - 1], lifted[:, kept])
        )
        both = (apart > 1.0) & ~np.isnan(found)
        return apart[both], found[both]


def _distances(places):
    first, second = np.triu_indices(places.shape[1], 1)
    return np.linalg.norm(places[:, first] - places[:, second], axis=-1)


def record(folder, seed, directions, wander=0.15):
    """True places of people who walk in directions up to so many rad apart, and the recording of their heads."""
    rng = np.random.default_rng(seed)
    truth = walk(
        rng, PEOPLE, FRAMES, DT, rng.uniform(0.0, directions, PEOPLE), area=(-9.0, 4.0, 9.0, 28.0), wander=wander
    )
    heads = photograph(CAMERA, truth, DT, rng, size_noise=0.12, jitter=0.06, key=5, height=0.07)
    info = SEQINFO.replace("seqLength=90", f"seqLength={FRAMES}")
    return truth, write_recording(folder / "HT21-03", "\n".join(lines_of(heads)) + "\n", info=info)


@pytest.fixture(scope="module", params=[0, 1])
def trip(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("trip")
    truth, recording = record(folder, request.param, 2.0 * np.pi)
    out = folder / "lifted"
    assert main(["generate", "shibuya01", "--source", str(recording), "--out", str(out), "--limit", "3"]) == 0
    return Trip(truth=truth, recording=recording, made=Dataset(out))


def test_the_camera_comes_back(trip):
    focal = trip.calibration["focal"]
    assert abs(trip.calibration["horizon"]["value"] - CAMERA.horizon) < 8.0
    assert trip.calibration["camera_height"]["value"] == pytest.approx(CAMERA.height, rel=0.05)
    assert focal["low"] < CAMERA.focal < focal["high"]
    assert trip.calibration["pseudo_metric"]


def test_distances_between_people_come_back(trip):
    true, lifted = trip.pairs()
    assert len(true) > 10_000
    ratio = lifted / true
    assert np.median(ratio) == pytest.approx(1.0, abs=0.05)
    assert np.sqrt(np.mean((ratio - 1.0) ** 2)) < 0.10
    assert np.mean(np.abs(ratio - 1.0) < 0.10) > 0.85


def test_a_homography_takes_the_doubt_away(trip, tmp_path):
    np.savetxt(tmp_path / "H.txt", np.linalg.inv(ground_matrix(CAMERA)))
    out = tmp_path / "surveyed"
    wanted = ["--homography", str(tmp_path / "H.txt"), "--limit", "1", "--out", str(out)]
    assert main(["generate", "shibuya01", "--source", str(trip.recording), *wanted]) == 0
    surveyed = Trip(truth=trip.truth, recording=trip.recording, made=Dataset(out))
    assert not surveyed.calibration["pseudo_metric"]
    assert surveyed.made.info.caution is None
    assert surveyed.made.info.definition["files"][2][0] == "homography"
    assert surveyed.calibration["focal"]["value"] == pytest.approx(CAMERA.focal, rel=1e-6)
    true, lifted = surveyed.pairs()
    assert np.median(lifted / true) == pytest.approx(1.0, abs=0.002)
    assert np.sqrt(np.mean((lifted / true - 1.0) ** 2)) < 0.09  # people are not all 1.70 m tall


def test_a_crowd_that_walks_one_way_leaves_the_stretch_open(tmp_path):
    _, recording = record(tmp_path, 0, 0.0, wander=0.01)
    stretch = load("generator", "shibuya01").plan(Options(source=recording)).info.calibration["stretch"]
    assert stretch["low"] < CAMERA.focal / np.cos(CAMERA.tilt) < stretch["high"]
    assert stretch["high"] > 1.5 * stretch["low"]
