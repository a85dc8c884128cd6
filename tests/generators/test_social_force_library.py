"""The crowd engine against the library pysocialforce, where the two mean the same."""

from dataclasses import replace

import numpy as np
import pytest

from tests.lib.library_crowd import walk_by_library
from vbbench_generators.social_force import Crowd, Model, Moussaid, simulate

pytestmark = pytest.mark.extra("pysocialforce")
SIDE_BY_SIDE = Crowd(
    positions=np.array([[0.3, 0.0], [-0.2, 1.5]]),
    velocities=np.array([[0.0, 1.0], [0.0, 1.1]]),
    speeds=np.array([1.0, 1.2]),
    goals=np.array([[[0.3, 50.0]], [[-0.2, 50.0]]]),
)
"""No angle between directions passes half a turn, which the library does not wrap."""


def test_the_library_takes_the_steps_and_the_speeds_that_it_is_given() -> None:
    still = np.zeros((1, 2))
    one = Crowd(positions=still, velocities=still, speeds=np.array([1.2]), goals=np.array([[[90.0, 0.0]]]))
    for walk in (simulate, walk_by_library):
        paths = walk(one, Model(), frames=101, dt=0.2, substeps=4)
        assert paths[-1, 0, 0] - paths[-2, 0, 0] == pytest.approx(0.24, rel=1e-9)


@pytest.mark.parametrize(
    "model",
    [
        Model(),
        replace(
            Model(relaxation_time=0.7, top_speed=1.1),
            repulsion=Moussaid(factor=4.0, velocity_weight=1.5, reach=0.4, side_sharpness=1.8, brake_sharpness=2.5),
        ),
    ],
    ids=["usual", "other"],
)
def test_both_walk_alike_where_no_angle_passes_half_a_turn(model: Model) -> None:
    ours, theirs = (walk(SIDE_BY_SIDE, model, frames=21, dt=0.1, substeps=1) for walk in (simulate, walk_by_library))
    np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=1e-8)
