"""The third motion model of docs/reference-solver.md runs, and does what it says."""

import re
from pathlib import Path
from typing import Any

import numpy as np

from tests.baselines.test_social_force_birdifier import pairs
from tests.lib.solver_runs import run
from vbbench_baselines.motion_models import Walkers

PAGE = Path(__file__).parents[2] / "docs" / "reference-solver.md"


def example() -> dict[str, Any]:
    source = re.findall(r"^```python\n(.*?)^```", PAGE.read_text("utf-8"), flags=re.M | re.S)[0]
    names: dict[str, Any] = {"__name__": "damped"}
    exec(source, names)  # noqa: S102
    return names


def test_a_third_motion_model_is_one_class() -> None:
    names = example()
    walkers = Walkers(np.zeros((2, 2)), np.array(((1.0, 2.0), (np.nan, np.nan))), 0.5)
    moved = names["DampedWalk"](seconds=5.0).displace(walkers)
    np.testing.assert_allclose(moved, ((-0.05, -0.1), (0.0, 0.0)))
    estimate = run(names["DampedBirdifier"](), pairs(0), "one-step")
    assert np.all(np.abs(estimate.poses - pairs(0).poses) < 0.1)
