"""Boxes of the tracker under the ids of the people."""

import numpy as np
import pytest

from vbbench.errors import VbbenchError
from vbbench.generation.generator import Options, Simulation
from vbbench.reproduction.table4 import LinkedByTruth, linked_by_truth
from vbbench.sequence import NOBODY
from vbbench_generators.splits import demo, street


def test_true_ids_keep_everybody_where_the_scene_says() -> None:
    data = street.plan(Options(tier="tracked", simulation=Simulation(sequences=1, people=(12,)))).build(0)
    linked = linked_by_truth(data)
    assert linked.persons is not None
    assert data.scene is not None
    seen = linked.sequence.observed
    frame, track = np.nonzero(seen)
    np.testing.assert_array_equal(
        linked.truth.positions[frame, track], data.scene.positions[frame, linked.persons[frame, track]]
    )
    assert [np.unique(column[column != NOBODY]).size for column in linked.persons.T] == [1] * seen.shape[1]
    assert (~np.isnan(linked.sequence.given.positions[..., 0])).sum(axis=0).max() == 2


def test_only_tracks_of_a_simulated_crowd_get_true_ids() -> None:
    plan = LinkedByTruth(demo.plan(Options(tier="tracked")))
    with pytest.raises(VbbenchError, match="only tracks of a simulated crowd can be linked by truth"):
        plan.build(0)
