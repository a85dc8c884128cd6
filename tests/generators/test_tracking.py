"""The tier `tracked`: the detector errs at the rates it is given, and the tracker does what it must with that."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import norm

from vbbench.camera import Camera, PanoramaCamera, PerspectiveCamera
from vbbench.errors import FileError
from vbbench.generation.tier import Sight
from vbbench.geometry import FloatArray, IntArray
from vbbench.parsing.toml_text import read_toml
from vbbench.sequence import Truth
from vbbench_generators.tiers.noise import Outline, see
from vbbench_generators.tiers.tracking.observing import Visible, detect, log_odds, track_video
from vbbench_generators.tiers.tracking.settings import DetectorModel, TrackingSettings, get_tracking
from vbbench_generators.tiers.tracking.tracker import (
    CentredDetections,
    Found,
    Tracker,
    associate,
    begin,
    correct,
    predict,
)

SETTINGS = get_tracking()
CAMERA = PerspectiveCamera()
FLAWLESS = replace(
    SETTINGS.detector,
    score_best=3.0,
    score_small=0.0,
    score_hidden=0.0,
    score_std=1e-9,
    top_std=0.0,
    bottom_std=0.0,
    side_std=0.0,
    edge_std=0.0,
    pull=0.0,
    pull_std=0.0,
    merge_rate=0.0,
    suppress_overlap=1.0,
    false_alarms=0.0,
)
DT = 0.1
SIZE = np.array([36.0, 100.0])


def rng() -> np.random.Generator:
    return np.random.default_rng(7)


def standing(frames: int, people: int, height: float, visible: float = 1.0) -> Visible:
    """People side by side far apart, all of one height in px."""
    box = np.array([0.0, 360.0, 0.36 * height, height])
    boxes = np.tile(box, (frames, people, 1))
    boxes[..., 0] = np.arange(people) * 1000.0
    return Visible(boxes, np.zeros((frames, people, 4)), np.full((frames, people), visible))


def found_in(people: Visible, model: DetectorModel, camera: Camera = CAMERA) -> list[CentredDetections]:
    return list(detect(people, model, camera, DT, np.ones(len(people.visible), bool), rng()))


def detections(*centres: float, scores: float | list[float] = 0.9) -> CentredDetections:
    """People 100 px tall whose centres stand in these columns."""
    boxes = np.array([[u, 360.0, *SIZE] for u in centres]).reshape(-1, 4)
    return CentredDetections(boxes, np.broadcast_to(np.asarray(scores, float), len(boxes)).copy())


def follow(frames: list[CentredDetections], period: float | None = None) -> list[Found]:
    tracker = Tracker(SETTINGS.tracker, DT, period)
    return [tracker.step(frame) for frame in frames]


# The detector


@pytest.mark.parametrize(("height", "visible"), [(200.0, 1.0), (60.0, 1.0), (30.0, 1.0), (200.0, 0.5), (100.0, 0.2)])
def test_misses_come_at_the_rate_that_the_model_says(height: float, visible: float) -> None:
    model = replace(SETTINGS.detector, false_alarms=0.0)
    scores = np.concatenate([d.scores for d in found_in(standing(400, 200, height, visible), model)])
    odds = log_odds(np.array(height), np.array(visible), model)
    for least in (SETTINGS.tracker.low, SETTINGS.tracker.high):
        wanted = norm.cdf((odds - np.log(least / (1.0 - least))) / model.score_std)
        assert np.mean(scores >= least) == pytest.approx(wanted, abs=0.015)


def test_miss_rates_stand_beside_those_of_the_benchmark() -> None:
    """CityPersons leaderboard: 6-13 % of people of 50 px and more hidden by at most 35 %, 25-53 % of others."""
    visible = np.linspace(0.0, 1.0, 101)
    least = np.log(SETTINGS.tracker.high / (1.0 - SETTINGS.tracker.high))
    odds = log_odds(np.full(101, 150.0), visible, SETTINGS.detector)
    missed = norm.cdf((least - odds) / SETTINGS.detector.score_std)
    assert 0.05 < missed[visible >= 0.9].mean() < 0.13
    assert 0.05 < missed[visible >= 0.65].mean() < 0.15  # the benchmark's people mostly show all
    assert 0.25 < missed[(visible >= 0.2) & (visible < 0.65)].mean() < 0.53


def test_jitter_is_as_wide_as_the_model_says() -> None:
    people = standing(2000, 50, 200.0)
    boxes = np.stack([d.boxes[np.argsort(d.boxes[:, 0])] for d in found_in(people, FLAWLESS_BUT_SHAKY)])
    top, bottom = boxes[..., 1] - boxes[..., 3] / 2, boxes[..., 1] + boxes[..., 3] / 2
    left = boxes[..., 0] - boxes[..., 2] / 2 - people.boxes[..., 0]
    wanted = np.hypot(0.02 * 200.0, 0.5), np.hypot(0.015 * 200.0, 0.5)
    assert (top.std(), bottom.std(), left.std()) == pytest.approx((wanted[0], wanted[0], wanted[1]), rel=0.05)
    assert top.mean() == pytest.approx(360.0 - 100.0, abs=0.2)
    noise = top - top.mean()
    assert np.mean(noise[1:] * noise[:-1]) / noise.var() == pytest.approx(
        np.exp(-DT / SETTINGS.detector.jitter_memory), abs=0.02
    )


FLAWLESS_BUT_SHAKY = replace(FLAWLESS, top_std=0.02, bottom_std=0.02, side_std=0.015, edge_std=0.5)


def test_hidden_edges_are_drawn_to_what_shows() -> None:
    people = standing(1, 3, 200.0, 0.5)
    hidden = people.hidden.copy()
    hidden[..., 3] = 80.0
    boxes = found_in(Visible(people.boxes, hidden, people.visible), replace(FLAWLESS, pull=0.25))[0].boxes
    np.testing.assert_allclose(boxes[:, 3], 200.0 - 0.25 * 80.0)
    np.testing.assert_allclose(boxes[:, 1] - boxes[:, 3] / 2, 260.0)


def test_who_shows_too_little_is_never_found() -> None:
    assert all(not len(d.scores) for d in found_in(standing(20, 5, 200.0, 0.05), FLAWLESS))


def test_people_in_one_anothers_way_are_merged_at_the_rate_given() -> None:
    people = standing(3000, 2, 100.0)
    people.boxes[:, 1, 0] = 8.0
    merged = found_in(people, replace(FLAWLESS, merge_rate=0.2))
    single = [d for d in merged if len(d.scores) == 1]
    assert len(single) / len(merged) == pytest.approx(0.2, abs=0.03)
    np.testing.assert_allclose(single[0].boxes[0], [4.0, 360.0, 44.0, 100.0])
    people.boxes[:, 1, 0] = 30.0  # they overlap by less
    assert all(len(d.scores) == 2 for d in found_in(people, replace(FLAWLESS, merge_rate=0.2)))


def test_merging_and_suppression_across_the_seam() -> None:
    people = standing(1, 2, 100.0)
    people.boxes[:, 0, 0], people.boxes[:, 1, 0] = 1438.0, 2.0
    camera = PanoramaCamera()
    (one,) = found_in(people, replace(FLAWLESS, merge_rate=1.0), camera)
    assert one.boxes[0, 0] % 1440 == 0.0
    assert one.boxes[0, 2] == 40.0
    (best,) = found_in(people, replace(FLAWLESS, suppress_overlap=0.7), camera)
    assert len(best.scores) == 1


def test_false_alarms_stand_as_many_as_the_model_says() -> None:
    model = replace(FLAWLESS, false_alarms=0.5, score_std=1.5)
    alarms = found_in(standing(20_000, 0, 100.0), model)
    assert np.mean([len(d.scores) for d in alarms]) == pytest.approx(0.5, rel=0.1)
    boxes = np.concatenate([d.boxes for d in alarms])
    feet = boxes[:, 1] + boxes[:, 3] / 2
    assert np.all(feet > 360.0)
    quiet = list(detect(standing(50, 0, 100.0), model, CAMERA, DT, np.zeros(50, bool), rng()))
    assert not any(len(d.scores) for d in quiet)


# The tracker


def test_the_filter_is_the_textbook_one() -> None:
    settings = SETTINGS.tracker
    boxes = np.array([[100.0, 200.0, 36.0, 100.0], [700.0, 300.0, 72.0, 200.0]])
    beliefs = begin(boxes, settings)
    mean = np.zeros((2, 8))
    mean[:, :4] = boxes
    height = boxes[:, 3]
    spread = [
        np.diag([(2 * settings.measurement * h) ** 2] * 4 + [(settings.start_speed * h) ** 2] * 4) for h in height
    ]
    motion = np.eye(8) + DT * np.eye(8, k=4)
    look = np.eye(4, 8)
    random = rng()
    for _ in range(6):
        for n in range(2):
            h = mean[n, 3]
            noise = np.diag([(settings.wander * h) ** 2 * DT] * 4 + [(settings.acceleration * h) ** 2 * DT] * 4)
            mean[n], spread[n] = motion @ mean[n], motion @ spread[n] @ motion.T + noise
        beliefs = predict(beliefs, DT, settings)
        np.testing.assert_allclose(beliefs.boxes, mean[:, :4])
        seen = boxes + random.normal(0.0, 3.0, boxes.shape)
        for n in range(2):
            total = look @ spread[n] @ look.T + np.eye(4) * (settings.measurement * mean[n, 3]) ** 2
            gain = spread[n] @ look.T @ np.linalg.inv(total)
            mean[n] = mean[n] + gain @ (seen[n] - look @ mean[n])
            spread[n] = spread[n] - gain @ look @ spread[n]
        beliefs = correct(beliefs, seen, settings, None)
        np.testing.assert_allclose(beliefs.mean[:, :, 0], mean[:, :4])
        np.testing.assert_allclose(beliefs.mean[:, :, 1], mean[:, 4:])
        for n in range(2):
            np.testing.assert_allclose(beliefs.spread[n, :, 1], np.diag(spread[n], k=4))
            np.testing.assert_allclose(beliefs.spread[n, :, 2], np.diag(spread[n])[4:])


def test_pairs_are_those_worth_most_together() -> None:
    tracks, seen = detections(0.0, 12.0).boxes, detections(10.0, 20.0).boxes
    rows, columns = associate(tracks, seen, 0.1)
    assert dict(zip(rows, columns, strict=True)) == {0: 0, 1: 1}  # not greedily 1-0
    assert not len(associate(tracks, seen, 0.99)[0])
    assert not len(associate(tracks, np.empty((0, 4)), 0.1)[0])


def test_two_people_who_pass_each_other_keep_their_ids() -> None:
    frames = []
    for t in range(40):
        left, right = 100.0 + 10.0 * t, 500.0 - 10.0 * t
        frames.append(detections(left, right))
    found = follow(frames)
    assert all(sorted(f.ids) == [0, 1] for f in found)
    for t in (0, 5, 35, 39):
        where = dict(zip(found[t].ids, found[t].boxes[:, 0], strict=True))
        assert where[0] == pytest.approx(100.0 + 10.0 * t, abs=12.0)


def test_a_gap_is_bridged_blindly() -> None:
    def at(t: int) -> CentredDetections:
        return detections() if 12 <= t < 19 else detections(100.0 + 8.0 * t)

    found = follow([at(t) for t in range(30)])
    assert [len(f.ids) for f in found[12:19]] == [0] * 7
    assert {int(i) for f in found for i in f.ids} == {0}
    assert found[20].boxes[0, 0] == pytest.approx(260.0, abs=5.0)


def test_a_gap_that_lasts_too_long_makes_a_new_track() -> None:
    lost = int(SETTINGS.tracker.lost_time / DT)
    for gap, tracks in ((lost, 1), (lost + 1, 2)):
        frames = [detections(100.0)] * 5 + [detections()] * gap + [detections(100.0)] * 5
        assert len({int(i) for f in follow(frames) for i in f.ids}) == tracks


def test_an_id_switches_when_somebody_steps_into_a_track() -> None:
    """One leaves where another appears: nothing but the box tells them apart."""
    found = follow([detections(100.0)] * 6 + [detections(106.0)] * 6)
    assert {int(i) for f in found for i in f.ids} == {0}


def test_low_scores_keep_tracks_and_begin_none() -> None:
    fading = [0.9, 0.9, 0.9, 0.3, 0.2, 0.15, 0.3, 0.9]
    found = follow([detections(100.0 + 3.0 * t, scores=s) for t, s in enumerate(fading)])
    assert [f.ids.tolist() for f in found] == [[0]] * 8
    assert [f.scores.tolist() for f in found] == [[s] for s in fading]
    assert not any(len(f.ids) for f in follow([detections(100.0, scores=0.3)] * 5))
    one_stage = replace(SETTINGS.tracker, low=SETTINGS.tracker.high)
    tracker = Tracker(one_stage, DT)
    alone = [tracker.step(detections(100.0 + 3.0 * t, scores=s)) for t, s in enumerate(fading)]
    assert [len(f.ids) for f in alone] == [1, 1, 1, 0, 0, 0, 0, 1]


def test_a_track_begins_with_its_second_detection() -> None:
    found = follow([detections(), detections(100.0), detections(102.0), detections()])
    assert [len(f.ids) for f in found] == [0, 0, 1, 0]
    flash = follow([detections(), detections(100.0), detections(), detections(100.0), detections()])
    assert not any(len(f.ids) for f in flash)


def test_across_the_seam_of_the_panorama() -> None:
    found = follow([detections((1400.0 + 6.0 * t) % 1440.0) for t in range(20)], period=1440.0)
    assert {int(i) for f in found for i in f.ids} == {0}
    assert all(len(f.ids) == 1 for f in found)


# Both together


def walkers(camera: Camera, frames: int = 60, people: int = 12) -> tuple[FloatArray, FloatArray, FloatArray, IntArray]:
    """Positions [T, K, 2], heights, poses and ids of people who walk about before a camera that stands."""
    random = rng()
    start, velocity = random.uniform((4, -6), (14, 6), (people, 2)), random.normal(0.0, 0.7, (people, 2))
    positions = start + velocity * (np.arange(frames) * DT)[:, None, None]
    return positions, random.normal(1.7, 0.07, people), np.zeros((frames, 3)), np.arange(people) * 3 + 5


@pytest.mark.slow
@pytest.mark.parametrize("camera", [PerspectiveCamera(), PanoramaCamera()], ids=lambda camera: camera.kind)
def test_a_flawless_detector_gives_everybody_a_track_of_their_own(camera: Camera) -> None:
    positions, heights, poses, people = walkers(camera)
    positions[..., 1] = np.linspace(-9, 9, 12) + 0.02 * positions[..., 1]  # in files, so that nobody hides anybody
    positions[..., 0] = 10.0
    made = _tracked(camera, positions, heights, poses, people, FLAWLESS)
    assert made.persons.shape[1] == len(people)
    for column in made.persons.T:
        assert len(set(column[column >= 0])) == 1
    assert set(made.persons[-1]) == set(people)
    exact = camera.project(np.stack([-positions[-1, :, 1], positions[-1, :, 0]], axis=-1), heights)
    place = np.searchsorted(people, made.persons[-1])
    np.testing.assert_allclose(made.boxes[-1], exact[place], atol=0.5)


def test_short_tracks_are_dropped_and_nobody_is_two() -> None:
    made = _tracked(CAMERA, *walkers(CAMERA), SETTINGS.detector)
    assert np.all((~np.isnan(made.boxes[..., 2])).sum(axis=0) >= SETTINGS.tracker.least_boxes)
    for row in made.persons:
        assert len(set(row[row >= 0])) == np.sum(row >= 0)
    assert np.all((made.persons >= 0) <= ~np.isnan(made.boxes[..., 2]))
    assert np.all((made.scores > 0.0) | np.isnan(made.scores))


def _tracked(
    camera: Camera,
    positions: FloatArray,
    heights: FloatArray,
    poses: FloatArray,
    people: IntArray,
    model: DetectorModel,
    seed: int = 7,
):
    boxes = camera.project(np.stack([-positions[..., 1], positions[..., 0]], axis=-1), heights[None])
    showing = see(positions, heights, poses, camera)
    settings = replace(SETTINGS, detector=model)
    sight = Sight(
        truth=Truth(poses=poses, positions=positions, heights=heights),
        people=people,
        seen=~np.isnan(boxes[..., 2]),
        watched=np.ones(len(poses), bool),
        camera=camera,
        dt=DT,
        observer="walker",
    )
    return track_video(sight, 1, boxes, showing, settings, Outline(), np.random.default_rng(seed))


# The file


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("score_memory = 0.3", "score_memroy = 0.3", "unknown key 'score_memroy'; did you mean 'score_memory'"),
        ("pull = 0.2 ", "pull = 1.2 ", "pull must be 0 to 1"),
        ("top_std = 0.035", "top_std = -0.035", "top_std must be 0 to"),
        ("lost_time = 1.0", "lost_time = 0.0", "lost_time must be 1e-09 to"),
        ("high = 0.6", "high = 0.05", "must not fall"),
        ("panorama_std = 3.7", "panorama_std = 0.0", "panorama_std must be 1e-09 to"),
    ],
)
def test_bad_settings_are_named(write: Callable[..., Path], old: str, new: str, message: str) -> None:
    import vbbench_generators

    text = (Path(vbbench_generators.__file__).parent / "detectors" / "model.toml").read_text("utf-8")
    assert old in text
    path = write(text.replace(old, new), "bad.toml")
    with pytest.raises(FileError, match=message) as caught:
        read_toml(path, TrackingSettings, "top level")
    assert str(path) in str(caught.value)
