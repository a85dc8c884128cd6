"""Who has no box, and why: found from truth, camera and boxes, and read back from the player's file."""

from dataclasses import replace

import numpy as np
import pytest

from tests.lib.made_player import hidden_people
from tests.lib.made_sequence import made_sequence
from tests.lib.player_decoding import METRE, decode_unboxed
from vbbench.camera import PerspectiveCamera
from vbbench.cli import main
from vbbench.files.dataset import Dataset
from vbbench_leaderboards.site.clip import Reason, _hidden, _reasons, encode_unboxed, find_unboxed, shown_truth


def reasons_of(relative: np.ndarray, *, smallest: float, found: bool) -> list[int]:
    """Of people of 1.7 m at these places (right, forward) in m, of whom nobody has a box."""
    camera = PerspectiveCamera()
    boxes = camera.project(relative[None], np.full((1, len(relative)), 1.7))
    hidden = _hidden(boxes, camera.depth(relative[None]), camera.period)
    return _reasons(boxes, hidden, camera, smallest, found)[0].tolist()


def test_every_reason_is_told() -> None:
    people = np.array([(0.0, -5.0), (0.0, 4.0), (0.05, 9.0), (9.0, 60.0), (-3.0, 6.0), (0.9, 1.35)])
    wanted = [Reason.OUTSIDE, Reason.MISSED, Reason.HIDDEN, Reason.SMALL, Reason.MISSED, Reason.CUT]
    assert reasons_of(people, smallest=30.0, found=True) == wanted
    left_out = [Reason.OUTSIDE, Reason.LEFT_OUT, Reason.HIDDEN, Reason.LEFT_OUT, Reason.LEFT_OUT, Reason.CUT]
    assert reasons_of(people, smallest=30.0, found=False) == left_out


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    """Crowds before a camera with borders."""
    folder = tmp_path_factory.mktemp("unboxed") / "data"
    assert main(["generate", "demo", "--camera", "perspective", "--limit", "2", "--out", str(folder)]) == 0
    return Dataset(folder)


def test_everybody_who_is_there_has_a_box_or_a_reason(dataset: Dataset) -> None:
    for sequence in dataset.sequences():
        truth = shown_truth(dataset, sequence)
        unboxed = find_unboxed(dataset, sequence, truth)
        assert unboxed is not None
        people, places, _ = dataset.surroundings(sequence)
        there = np.isfinite(places[..., 0]) & (people != sequence.observer)
        persons = dataset.track_persons(sequence)
        boxes = np.array([len(set(row[seen]) - {-1}) for row, seen in zip(persons, sequence.observed, strict=True)])
        assert np.array_equal(boxes + (unboxed.reasons > 0).sum(axis=1), there.sum(axis=1))
        tracks = len(sequence.tracks)
        assert not np.any(sequence.observed & (unboxed.reasons[:, :tracks] > 0))
        assert np.array_equal(np.isfinite(unboxed.positions[..., 0]), unboxed.reasons[:, tracks:] > 0)
        assert np.array_equal(np.isnan(unboxed.boxes[..., 0]), ~(unboxed.reasons > Reason.OUTSIDE))


def test_they_come_back_from_the_file_of_the_player() -> None:
    made = made_sequence(6, 9)
    places = made.truth.poses[0, :2] + np.array([(2.0, 1.0), (-7.5, 3.25)])
    unboxed = hidden_people(made, places, [Reason.SMALL, Reason.LEFT_OUT])
    values = encode_unboxed(made.truth, unboxed)
    reasons, boxes, positions = decode_unboxed(values, made.sequence.observed.shape)
    assert np.array_equal(reasons, unboxed.reasons)
    assert np.allclose(boxes, unboxed.boxes, atol=0.06, equal_nan=True)
    moved = unboxed.positions - np.rint(made.truth.poses[0, :2])
    assert np.allclose(positions, moved, atol=0.51 * METRE, equal_nan=True)


def test_nobody_is_missed_where_places_are_not_known(dataset: Dataset, monkeypatch: pytest.MonkeyPatch) -> None:
    sequence = dataset.sequence(0)
    truth = shown_truth(dataset, sequence)
    monkeypatch.setattr(dataset, "info", replace(dataset.info, truth="poses"))
    assert find_unboxed(dataset, sequence, truth) is None
