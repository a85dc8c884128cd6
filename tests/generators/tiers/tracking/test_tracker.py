"""The tracker: its filter against the textbook's, whom it links, and what makes and ends tracks."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import vbbench_generators
from vbbench.errors import FileError
from vbbench.parsing.toml_text import read_toml
from vbbench_generators.tiers.tracking import TrackerSettings, TrackingSettings, get_tracking
from vbbench_generators.tiers.tracking.tracker import (
    CentredDetections,
    Found,
    Tracker,
    associate,
    begin,
    correct,
    predict,
)

SETTINGS = get_tracking().tracker
DT = 0.1


def detections(*centres: float, score: float = 0.9) -> CentredDetections:
    """People 100 px tall whose centres stand in these columns."""
    boxes = np.array([[u, 360.0, 36.0, 100.0] for u in centres]).reshape(-1, 4)
    return CentredDetections(boxes, np.full(len(boxes), score))


def follow(
    frames: list[CentredDetections], period: float | None = None, settings: TrackerSettings = SETTINGS
) -> list[Found]:
    tracker = Tracker(settings, DT, period)
    return [tracker.step(frame) for frame in frames]


def ids(found: list[Found]) -> list[list[int]]:
    return [sorted(one.ids.tolist()) for one in found]


def test_the_filter_is_the_textbook_one() -> None:
    boxes = np.array([[100.0, 200.0, 36.0, 100.0], [700.0, 300.0, 72.0, 200.0]])
    beliefs, rng = begin(boxes, SETTINGS), np.random.default_rng(7)
    means = np.pad(boxes, ((0, 0), (0, 4)))
    first = np.repeat([2 * SETTINGS.measurement, SETTINGS.start_speed], 4)
    covariances = [np.diag((first * height) ** 2) for height in boxes[:, 3]]
    motion, look = np.eye(8) + DT * np.eye(8, k=4), np.eye(4, 8)
    for _ in range(6):
        for n, (mean, covariance) in enumerate(zip(means, covariances, strict=True)):
            noise = np.repeat([SETTINGS.wander, SETTINGS.acceleration], 4) * mean[3]
            means[n], covariances[n] = motion @ mean, motion @ covariance @ motion.T + np.diag(noise**2 * DT)
        beliefs = predict(beliefs, DT, SETTINGS)
        np.testing.assert_allclose(beliefs.boxes, means[:, :4])
        seen = boxes + rng.normal(0.0, 3.0, boxes.shape)
        for n, (mean, covariance) in enumerate(zip(means, covariances, strict=True)):
            total = look @ covariance @ look.T + np.eye(4) * (SETTINGS.measurement * mean[3]) ** 2
            gain = covariance @ look.T @ np.linalg.inv(total)
            means[n], covariances[n] = mean + gain @ (seen[n] - look @ mean), covariance - gain @ look @ covariance
        beliefs = correct(beliefs, seen, SETTINGS, None)
        np.testing.assert_allclose(np.concatenate([beliefs.mean[..., 0], beliefs.mean[..., 1]], axis=1), means)
        for spread, covariance in zip(beliefs.spread, covariances, strict=True):
            np.testing.assert_allclose(spread[:, 1], np.diag(covariance, k=4))
            np.testing.assert_allclose(np.concatenate([spread[:, 0], spread[:, 2]]), np.diag(covariance))


def test_pairs_are_those_worth_most_together() -> None:
    tracks, seen = detections(0.0, 12.0).boxes, detections(10.0, 20.0).boxes
    rows, columns = associate(tracks, seen, 0.1)
    assert dict(zip(rows, columns, strict=True)) == {0: 0, 1: 1}  # not greedily 1-0
    assert not len(associate(tracks, seen, 0.99)[0])
    assert not len(associate(tracks, np.empty((0, 4)), 0.1)[0])


def test_two_people_who_pass_each_other_keep_their_ids() -> None:
    found = follow([detections(100.0 + 10.0 * t, 500.0 - 10.0 * t) for t in range(40)])
    assert ids(found) == [[0, 1]] * 40
    for t in (0, 5, 35, 39):
        where = dict(zip(found[t].ids, found[t].boxes[:, 0], strict=True))
        assert where[0] == pytest.approx(100.0 + 10.0 * t, abs=12.0)


def test_a_gap_is_bridged_blindly_until_it_lasts_too_long() -> None:
    found = follow([detections() if 12 <= t < 19 else detections(100.0 + 8.0 * t) for t in range(30)])
    assert ids(found) == [[0]] * 12 + [[]] * 7 + [[0]] * 11
    assert found[20].boxes[0, 0] == pytest.approx(260.0, abs=5.0)
    lost = int(SETTINGS.lost_time / DT)
    for gap, tracks in ((lost, 1), (lost + 1, 2)):
        frames = [detections(100.0)] * 5 + [detections()] * gap + [detections(100.0)] * 5
        assert len({number for one in ids(follow(frames)) for number in one}) == tracks


def test_an_id_switches_when_a_person_steps_into_a_track() -> None:
    """One leaves where another appears: boxes do not distinguish them."""
    assert ids(follow([detections(100.0)] * 6 + [detections(106.0)] * 6)) == [[0]] * 12


def test_low_scores_keep_tracks_and_begin_none() -> None:
    scores = [0.9, 0.9, 0.9, 0.3, 0.2, 0.15, 0.3, 0.9]
    fading = [detections(100.0 + 3.0 * t, score=score) for t, score in enumerate(scores)]
    found = follow(fading)
    assert ids(found) == [[0]] * 8
    assert [one.scores.tolist() for one in found] == [[score] for score in scores]
    assert not any(ids(follow([detections(100.0, score=0.3)] * 5)))
    one_stage = follow(fading, settings=replace(SETTINGS, low=SETTINGS.high))
    assert [len(one) for one in ids(one_stage)] == [1, 1, 1, 0, 0, 0, 0, 1]


def test_a_track_begins_with_its_second_detection() -> None:
    here, nothing = detections(100.0), detections()
    assert ids(follow([nothing, here, detections(102.0), nothing])) == [[], [], [0], []]
    assert not any(ids(follow([nothing, here, nothing, here, nothing])))


def test_a_track_crosses_the_seam_of_the_panorama() -> None:
    assert ids(follow([detections((1400.0 + 6.0 * t) % 1440.0) for t in range(20)], period=1440.0)) == [[0]] * 20


def test_what_is_behind_a_camera_with_borders_waits_unharmed() -> None:
    tracker = Tracker(SETTINGS, 0.04)
    for _ in range(3):
        tracker.step(detections(600.0))
    assert not len(tracker.step(detections(), lambda boxes: boxes * np.nan).ids)
    assert [len(tracker.step(detections(600.0)).ids) for _ in range(2)] == [0, 1]


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
    text = (Path(vbbench_generators.__file__).parent / "detectors" / "model.toml").read_text("utf-8")
    assert old in text
    path = write(text.replace(old, new), "bad.toml")
    with pytest.raises(FileError, match=message) as caught:
        read_toml(path, TrackingSettings, "top level")
    assert str(path) in str(caught.value)
