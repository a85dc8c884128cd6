"""Detections and tracks in a video: frames in between, the detector's errors, the camera's turn, few lost people."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.stats import norm

from benchmarks.tracker_table import Tally
from tests.lib.made_sight import DT, sight_of
from vbbench.boxes import overlaps, suppress
from vbbench.camera import Camera, PanoramaCamera, PerspectiveCamera
from vbbench.exchange.matching import match_boxes, match_tracks
from vbbench.generation.tier import Observations, Sight, get_tier
from vbbench.geometry import FloatArray, world_to_relative
from vbbench_generators._core import remaining, worths
from vbbench_generators.tiers.noise import Outline, see
from vbbench_generators.tiers.tracking import DetectorModel, get_tracking
from vbbench_generators.tiers.tracking.observing import (
    Film,
    Visible,
    carried,
    detect,
    estimated_turns,
    finer,
    log_odds,
    track_video,
)
from vbbench_generators.tiers.tracking.tracker import CentredDetections, from_centres

SETTINGS = get_tracking()
ERRORS = ("score_small", "score_hidden", "top_std", "bottom_std", "side_std", "edge_std", "pull", "pull_std")
FLAWLESS = replace(
    SETTINGS.detector,
    score_best=3.0,
    score_std=1e-9,
    suppress_overlap=1.0,
    **dict.fromkeys([*ERRORS, "merge_rate", "false_alarms"], 0.0),
)
CAMERAS = [PanoramaCamera(), PerspectiveCamera(), PanoramaCamera(pitch=0.1), PerspectiveCamera(pitch=-0.05, roll=0.03)]
VIDEO = 0.1
"""Seconds a frame of the films of detector and tracker alone."""


# Time between frames


@pytest.mark.parametrize(("rate", "steps"), [(25.0, 10), (2.5, 1), (1.0, 1), (7.0, 3), (5.0, 2)])
def test_every_so_many_fine_frames_one_is_a_frame_to_the_last_bit(rate: float, steps: int) -> None:
    rng = np.random.default_rng(3)
    places = rng.uniform(-9, 9, (6, 2)) + np.cumsum(rng.normal(0.4, 0.1, (12, 6, 2)), axis=0)
    yaw = np.cumsum(rng.normal(0.0, 0.8, 12))
    poses = np.column_stack([places[:, 0], np.arctan2(np.sin(yaw), np.cos(yaw))])
    positions = places[:, 1:]
    positions[:4, 0] = positions[9:, 1] = positions[5, 2] = np.nan
    seen = ~np.isnan(positions[..., 0])
    seen[3, 4] = False
    watched = np.arange(12) != 6
    fine, found = finer(sight_of(positions, poses, seen=seen, watched=watched), rate)
    assert found == steps
    assert len(fine.seen) == len(fine.watched) == len(fine.truth.poses) == 11 * steps + 1
    assert fine.dt == pytest.approx(DT / steps)
    np.testing.assert_array_equal(fine.truth.positions[::steps], positions)
    np.testing.assert_array_equal(fine.truth.poses[::steps], poses)
    np.testing.assert_array_equal(fine.seen[::steps], seen)
    np.testing.assert_array_equal(fine.watched[::steps], watched)


def test_who_walks_evenly_walks_evenly_between_frames_and_who_turns_does_not_jump() -> None:
    def walks(time: FloatArray) -> FloatArray:
        corner = 3.0 * np.stack([np.cos(0.5 * time), np.sin(0.5 * time)], axis=-1)
        return np.stack([np.stack([1.3 * time, -0.4 * time], axis=-1), corner], axis=1)

    time = DT * np.arange(10)
    fine, steps = finer(sight_of(walks(time), np.stack([time, 0.0 * time, 0.3 * time], axis=-1)))
    between = DT / steps * np.arange(len(fine.watched))
    exact, inside = walks(between), slice(steps, -steps)  # velocities of the ends are of one side only
    np.testing.assert_allclose(fine.truth.positions[:, 0], exact[:, 0])
    np.testing.assert_allclose(fine.truth.positions[inside, 1], exact[inside, 1], atol=1e-3)
    np.testing.assert_allclose(fine.truth.poses[:, 2], 0.3 * between)


def test_the_camera_turns_the_shorter_way() -> None:
    poses = np.zeros((4, 3))
    poses[:, 2] = [3.0, 3.1, -3.1, -3.0]
    fine, _ = finer(sight_of(np.zeros((4, 1, 2)), poses))
    turned = np.unwrap(fine.truth.poses[:, 2])
    assert np.all(np.diff(turned) > 0.0)
    assert turned[-1] == pytest.approx(2.0 * np.pi - 3.0)


def test_who_comes_and_goes_is_there_half_a_frame_longer_and_walks_straight_on() -> None:
    positions = np.full((6, 2, 2), np.nan)
    positions[2:4, 0] = [[0.0, 0.0], [0.4, 0.0]]
    positions[3, 1] = [5.0, 5.0]  # there in a single frame: nobody knows how fast
    fine, steps = finer(sight_of(positions))
    there = np.flatnonzero(fine.seen[:, 0])
    assert there.tolist() == list(range(2 * steps - steps // 2, 4 * steps - steps // 2))
    np.testing.assert_array_equal(~np.isnan(fine.truth.positions[..., 0]), fine.seen)
    np.testing.assert_allclose(fine.truth.positions[there, 0, 0], 0.04 * (there - 2 * steps), atol=1e-12)
    np.testing.assert_array_equal(fine.truth.positions[fine.seen[:, 1], 1], np.full((steps, 2), 5.0))


def test_nobody_and_a_single_frame() -> None:
    empty, steps = finer(sight_of(np.empty((3, 0, 2))))
    assert empty.truth.positions.shape == (2 * steps + 1, 0, 2)
    assert observed(sight_of(np.empty((3, 0, 2)))).boxes.shape[0] == 3
    assert finer(sight_of(np.zeros((1, 2, 2))))[0].truth.positions.shape == (1, 2, 2)


# The detector


def standing(frames: int, people: int, height: float, visible: float = 1.0, **edges: float) -> Visible:
    """People next to one another, far apart, all of one height in px; ``edges`` hide so many px of theirs."""
    boxes = np.tile([0.0, 360.0, 0.36 * height, height], (frames, people, 1))
    boxes[..., 0] = np.arange(people) * 1000.0
    hidden = np.zeros((frames, people, 4)) + [edges.get(name, 0.0) for name in ("left", "top", "right", "bottom")]
    return Visible(boxes, hidden, np.full((frames, people), visible))


def found_in(people: Visible, camera: Camera = CAMERAS[1], **changes: float) -> list[CentredDetections]:
    """The detections of a flawless detector but for these ``changes``."""
    watched = np.ones(len(people.visible), bool)
    return list(detect(people, replace(FLAWLESS, **changes), camera, VIDEO, watched, np.random.default_rng(7)))


@pytest.mark.parametrize(("height", "visible"), [(200.0, 1.0), (60.0, 1.0), (30.0, 1.0), (200.0, 0.5), (100.0, 0.2)])
def test_misses_come_at_the_rate_that_the_model_says(height: float, visible: float) -> None:
    model = replace(SETTINGS.detector, false_alarms=0.0)
    scores = np.concatenate([d.scores for d in found_in(standing(400, 200, height, visible), **vars(model))])
    odds = log_odds(np.array(height), np.array(visible), model)
    for least in (SETTINGS.tracker.low, SETTINGS.tracker.high):
        wanted = norm.cdf((odds - np.log(least / (1.0 - least))) / model.score_std)
        assert np.mean(scores >= least) == pytest.approx(wanted, abs=0.015)


def test_miss_rates_stand_next_to_those_of_the_benchmark() -> None:
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
    found = found_in(people, top_std=0.02, bottom_std=0.02, side_std=0.015, edge_std=0.5)
    boxes = np.stack([d.boxes[np.argsort(d.boxes[:, 0])] for d in found])
    top, bottom = boxes[..., 1] - boxes[..., 3] / 2, boxes[..., 1] + boxes[..., 3] / 2
    left = boxes[..., 0] - boxes[..., 2] / 2 - people.boxes[..., 0]
    wide, narrow = np.hypot(0.02 * 200.0, 0.5), np.hypot(0.015 * 200.0, 0.5)
    assert (top.std(), bottom.std(), left.std()) == pytest.approx((wide, wide, narrow), rel=0.05)
    assert top.mean() == pytest.approx(360.0 - 100.0, abs=0.2)
    noise, kept = top - top.mean(), np.exp(-VIDEO / SETTINGS.detector.jitter_memory)
    assert np.mean(noise[1:] * noise[:-1]) / noise.var() == pytest.approx(kept, abs=0.02)


def test_hidden_edges_are_drawn_to_what_shows() -> None:
    boxes = found_in(standing(1, 3, 200.0, 0.5, bottom=80.0), pull=0.25)[0].boxes
    np.testing.assert_allclose(boxes[:, 3], 200.0 - 0.25 * 80.0)
    np.testing.assert_allclose(boxes[:, 1] - boxes[:, 3] / 2, 260.0)


def test_who_shows_too_little_is_never_found() -> None:
    assert all(not len(d.scores) for d in found_in(standing(20, 5, 200.0, 0.05)))


def test_people_in_one_anothers_way_are_merged_at_the_rate_given() -> None:
    people = standing(3000, 2, 100.0)
    people.boxes[:, 1, 0] = 8.0
    merged = found_in(people, merge_rate=0.2)
    single = [d for d in merged if len(d.scores) == 1]
    assert len(single) / len(merged) == pytest.approx(0.2, abs=0.03)
    np.testing.assert_allclose(single[0].boxes[0], [4.0, 360.0, 44.0, 100.0])
    people.boxes[:, 1, 0] = 30.0  # they overlap by less
    assert all(len(d.scores) == 2 for d in found_in(people, merge_rate=0.2))


def test_merging_and_suppression_across_the_seam() -> None:
    people = standing(1, 2, 100.0)
    people.boxes[0, :, 0] = 1438.0, 2.0
    (one,) = found_in(people, PanoramaCamera(), merge_rate=1.0)
    assert one.boxes[0, 0] % 1440 == 0.0
    assert one.boxes[0, 2] == 40.0
    (best,) = found_in(people, PanoramaCamera(), suppress_overlap=0.7)
    assert len(best.scores) == 1


def test_false_alarms_stand_as_many_as_the_model_says() -> None:
    alarms = found_in(standing(20_000, 0, 100.0), false_alarms=0.5, score_std=1.5)
    assert np.mean([len(d.scores) for d in alarms]) == pytest.approx(0.5, rel=0.1)
    boxes = np.concatenate([d.boxes for d in alarms])
    assert np.all(boxes[:, 1] + boxes[:, 3] / 2 > 360.0)
    model, unwatched = replace(FLAWLESS, false_alarms=0.5), np.zeros(50, bool)
    quiet = detect(standing(50, 0, 100.0), model, CAMERAS[1], VIDEO, unwatched, np.random.default_rng(7))
    assert not any(len(d.scores) for d in quiet)


@pytest.mark.parametrize("period", [None, 400.0], ids=["borders", "panorama"])
def test_boxes_overlap_and_suppress_boxes_as_the_rest_of_the_package_does(period: float | None) -> None:
    rng = np.random.default_rng(4)
    boxes = rng.uniform((0.0, 0.0, 20.0, 40.0), (400.0, 100.0, 60.0, 120.0), (2, 60, 4))
    scores, width = rng.random(60), period or 0.0
    one, other = from_centres(boxes)
    shared = worths(boxes[0], boxes[1], np.ones(60), 0.0, width)
    np.testing.assert_allclose(shared, overlaps(one, other, period), atol=1e-12)
    order = np.argsort(-scores, kind="stable")
    kept = order[remaining(boxes[0], order, 0.4, width)[order]]
    np.testing.assert_array_equal(kept, suppress(one, scores, 0.4, period))
    assert 5 < len(kept) < 55


# Detector and tracker


def walkers(camera: Camera, *, apart: bool = False) -> Sight:
    """Twelve people who walk about before a camera that stands; ``apart``, they hide nobody."""
    rng = np.random.default_rng(7)
    start, velocity = rng.uniform((4, -6), (14, 6), (12, 2)), rng.normal(0.0, 0.7, (12, 2))
    positions = start + velocity * (np.arange(60) * VIDEO)[:, None, None]
    heights = rng.normal(1.7, 0.07, 12)
    if apart:
        positions[..., 1] = np.linspace(-9, 9, 12) + 0.02 * positions[..., 1]
        positions[..., 0] = 10.0
    return sight_of(positions, heights=heights, camera=camera, people=np.arange(12) * 3 + 5, dt=VIDEO)


def tracked(sight: Sight, model: DetectorModel) -> Observations:
    truth, outline = sight.truth, Outline()
    showing = see(truth.positions, truth.heights, truth.poses, sight.camera, outline)
    film = Film(sight=sight, every=1, boxes=sight.boxes, showing=showing)
    return track_video(film, replace(SETTINGS, detector=model), outline, np.random.default_rng(7))


@pytest.mark.slow
@pytest.mark.parametrize("camera", CAMERAS[:2], ids=lambda camera: camera.kind)
def test_a_flawless_detector_gives_everybody_a_track(camera: Camera) -> None:
    sight = walkers(camera, apart=True)
    made = tracked(sight, FLAWLESS)
    assert [len(set(column[column >= 0])) for column in made.persons.T] == [1] * len(sight.people)
    assert set(made.persons[-1]) == set(sight.people)
    place = np.searchsorted(sight.people, made.persons[-1])
    np.testing.assert_allclose(made.boxes[-1], sight.boxes[-1, place], atol=0.5)


def test_short_tracks_are_dropped_and_nobody_is_two() -> None:
    made = tracked(walkers(CAMERAS[1]), SETTINGS.detector)
    there = ~np.isnan(made.boxes[..., 2])
    assert np.all(there.sum(axis=0) >= SETTINGS.tracker.least_boxes)
    for row in made.persons:
        assert len(set(row[row >= 0])) == np.sum(row >= 0)
    assert np.all((made.persons >= 0) <= there)
    assert np.all((made.visible > 0.0) | np.isnan(made.visible))


def crowd(camera: Camera, turn: float = 0.0) -> Sight:
    """People who cross a square, seen by a walker who turns by ``turn`` rad a frame."""
    rng, time = np.random.default_rng(2), DT * np.arange(30)
    walks = time[:, None, None]
    positions = rng.uniform((3.0, -8.0), (18.0, 8.0), (14, 2)) + walks * rng.normal(0.0, 0.6, (14, 2))
    poses = np.column_stack([0.3 * time, 0.0 * time, turn * np.arange(30)])
    everybody = np.ones((30, 14), bool)
    return sight_of(
        positions, poses, rng.normal(1.7, 0.07, 14), camera=camera, people=np.arange(14) + 3, seen=everybody
    )


def observed(sight: Sight, seed: int = 5) -> Observations:
    return get_tier("tracked").observe(sight, np.random.default_rng(seed))


def tally(sight: Sight) -> Tally:
    counted = Tally()
    for seed in range(2):
        counted.add(sight, observed(sight, seed))
    return counted


@pytest.mark.parametrize("turn", [0.0, 0.5], ids=["straight", "turning"])
def test_few_are_missed_or_confused_at_the_rate_of_recordings(turn: float) -> None:
    counted = tally(crowd(PanoramaCamera(), turn=turn))
    assert counted.shown_found > 0.8 * counted.shown
    assert counted.found > 0.65 * counted.people
    assert counted.switches < 0.02 * counted.people
    assert counted.nobody < 0.05 * counted.people
    assert 0.78 < counted.overlap / counted.found < 0.9


def test_the_turn_taken_off_keeps_people_that_a_turning_camera_loses(monkeypatch: pytest.MonkeyPatch) -> None:
    sight = crowd(PanoramaCamera(), turn=0.5)
    steady = tally(sight)
    place = "vbbench_generators.tiers.tracking.observing.estimated_turns"
    monkeypatch.setattr(place, lambda yaw, *_: np.broadcast_to(np.eye(3), (len(yaw), 3, 3)))
    assert steady.found > 1.4 * tally(sight).found


def test_the_same_seed_gives_the_same_tracks_in_the_frames_of_the_dataset() -> None:
    sight = crowd(PerspectiveCamera())
    one, same, other = observed(sight), observed(sight), observed(sight, 6)
    np.testing.assert_array_equal(one.boxes, same.boxes)
    np.testing.assert_array_equal(one.persons, same.persons)
    assert one.boxes.shape != other.boxes.shape or not np.array_equal(one.boxes, other.boxes, equal_nan=True)
    assert len(one.boxes) == len(sight.watched)
    assert ((~np.isnan(one.boxes[..., 2])).sum(axis=0) >= SETTINGS.tracker.least_boxes).all()


# The camera's turn


def far_boxes(camera: Camera, yaw: float) -> FloatArray:
    """Boxes [N, 4] of people so far away that walking does not move them."""
    azimuth = np.linspace(-0.6, 0.6, 7)
    places = 40.0 * np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1)
    u, v, length = camera.project(world_to_relative(places, np.array([0.0, 0.0, yaw])), np.full(7, 1.7)).T
    return np.stack([u, v, 0.36 * length, length], axis=-1)


def turned(camera: Camera, turn: float) -> Any:
    return estimated_turns(np.array([1.0, 1.0 + turn]), camera, 0.0, np.random.default_rng(0))[1]


@pytest.mark.parametrize("camera", CAMERAS, ids=lambda camera: f"{camera.kind} {camera.pitch}")
@pytest.mark.parametrize("turn", [0.05, -0.1])
def test_boxes_are_carried_to_where_the_turned_camera_sees_them(camera: Camera, turn: float) -> None:
    moved, seen = carried(far_boxes(camera, 0.0), turned(camera, turn), camera), far_boxes(camera, turn)
    np.testing.assert_allclose(moved[:, [0, 1, 3]], seen[:, [0, 1, 3]], atol=0.02)


def test_what_is_behind_a_camera_with_borders_is_nowhere() -> None:
    camera = PerspectiveCamera()
    assert np.isnan(carried(far_boxes(camera, 0.0), turned(camera, np.pi), camera)).all()


def test_the_turn_is_as_uncertain_as_the_settings_say() -> None:
    camera = PanoramaCamera()
    turns = estimated_turns(np.zeros(4000), camera, 0.5, np.random.default_rng(1))
    px = np.arctan2(turns[:, 0, 2], turns[:, 0, 0]) * camera.focal
    assert px.std() == pytest.approx(0.5, rel=0.05)


def test_of_two_next_to_one_another_the_one_does_not_become_the_other() -> None:
    camera = PerspectiveCamera()
    true = np.array([[100.0, 100.0, 36.0, 100.0], [108.0, 100.0, 36.0, 100.0]])
    swapped = true[::-1] * [1.0, 1.0, 1.0, 0.99]
    found = np.stack([true, swapped, true])
    people, real = np.array([4, 9]), np.stack([true] * 3)
    assert match_tracks(found, real, people, camera).tolist() == [[4, 9], [9, 4], [4, 9]]
    assert match_tracks(found, real, people, camera, staying=True).tolist() == [[4, 9]] * 3
    apart = np.stack([true, swapped + 200.0 * np.eye(4)[0], true])
    assert match_tracks(apart, real, people, camera, staying=True)[1].tolist() == [-1, -1]
    kept = match_boxes(swapped, true, camera, paired=np.array([[True, False], [False, False]]))
    assert [rows.tolist() for rows in kept] == [[0, 1], [0, 1]]
