"""The strict engine against pysocialforce itself, and the wall around pysocialforce."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.generators.test_social_force import crowd
from vbbench_generators.social_force import Crowd, Model, Moussaid, simulate

pytestmark = pytest.mark.extra("pysocialforce")
STRICT = Model(strict=True)
WALLS = [[-8.0, -8.0, 8.0, -8.0], [8.0, -8.0, 8.0, 8.0], [-3.0, 0.0, -2.96, 0.0]]
surroundings = pytest.mark.parametrize(
    ("grouped", "walls"),
    [(False, []), (True, []), (False, WALLS), (True, WALLS)],
    ids=["plain", "groups", "walls", "all"],
)


@surroundings
@pytest.mark.parametrize("people", [1, 2, 10, 50])
@pytest.mark.parametrize("seed", range(3))
def test_strict_is_pysocialforce(people: int, seed: int, grouped: bool, walls: list[list[float]]) -> None:
    one = crowd(people, seed, grouped)
    for frames, dt, tolerance in ((51, 0.1, 1e-9), (51, 0.05, 1e-9), (2, 0.4, 1e-12)):
        ours, theirs = (
            simulate(one, STRICT, frames=frames, dt=dt, substeps=1, walls=walls, engine=engine)
            for engine in ("vbbench", "pysocialforce")
        )
        np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=tolerance)


def test_parameters_mean_the_same_in_both_engines() -> None:
    repulsion = Moussaid(factor=4.0, velocity_weight=1.5, reach=0.4, side_sharpness=1.8, brake_sharpness=2.5)
    model = replace(STRICT, repulsion=repulsion, relaxation_time=0.7, top_speed=1.1, arrival_radius=2.0)
    model = replace(model, walls=replace(model.walls, factor=5.0, fall_off=0.3, reach=2.0, body_radius=0.2))
    model = replace(model, groups=replace(model.groups, cohesion=3.0, gaze=2.0, separation=1.5, personal_space=2.0))
    ours, theirs = (
        simulate(crowd(20, 5, True), model, frames=31, dt=0.1, substeps=2, walls=WALLS, engine=engine)
        for engine in ("vbbench", "pysocialforce")
    )
    np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=1e-9)


def test_the_library_takes_the_steps_and_the_speeds_that_it_is_told() -> None:
    still = np.zeros((1, 2))
    one = Crowd(positions=still, velocities=still, speeds=[1.2], goals=np.array([[[90.0, 0.0]]]))
    for engine in ("vbbench", "pysocialforce"):
        paths = simulate(one, Model(), frames=101, dt=0.2, substeps=4, engine=engine)  # type: ignore[arg-type]
        assert paths[-1, 0, 0] - paths[-2, 0, 0] == pytest.approx(0.24, rel=1e-9)


def test_the_engines_agree_where_no_angle_passes_half_a_turn() -> None:
    one = Crowd(
        positions=np.array([[0.3, 0.0], [-0.2, 1.5]]),
        velocities=np.array([[0.0, 1.0], [0.0, 1.1]]),
        speeds=[1.0, 1.2],
        goals=np.array([[[0.3, 50.0]], [[-0.2, 50.0]]]),
    )
    ours, theirs = (
        simulate(one, Model(), frames=21, dt=0.1, substeps=1, engine=engine) for engine in ("vbbench", "pysocialforce")
    )
    np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=1e-8)


@pytest.mark.parametrize("model", [Model(repulsion=Moussaid(factor=0.0))])
def test_what_the_library_cannot_do_is_said(model: Model) -> None:
    with pytest.raises(ValueError, match="pysocialforce"):
        simulate(crowd(2), model, frames=2, dt=0.1, substeps=1, engine="pysocialforce")


CHILD = """
import logging, sys, warnings
import numpy as np
from vbbench_generators.social_force import Crowd, Model, simulate
assert "pysocialforce" not in sys.modules, "imported before it is asked for"
root, mark = logging.getLogger(), logging.NullHandler()
root.setLevel(logging.ERROR)
root.addHandler(mark)
zeros = np.zeros((3, 2))
crowd = Crowd(positions=zeros, velocities=zeros, speeds=np.ones(3), goals=np.ones((3, 1, 2)))
warnings.simplefilter("error")
for _ in range(2):
    simulate(crowd, Model(), frames=3, dt=0.1, substeps=1, engine="pysocialforce")
assert root.level == logging.ERROR and root.handlers == [mark], (root.level, root.handlers)
assert not logging.getLogger("root").handlers or logging.getLogger("root") is root
"""


def test_nothing_of_the_library_gets_out(tmp_path: Path) -> None:
    done = subprocess.run([sys.executable, "-c", CHILD], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert list(tmp_path.iterdir()) == []
