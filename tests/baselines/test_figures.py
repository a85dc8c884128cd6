"""vb-cv and vb-sf on the real recordings, one-step, panorama, ideal: as good as the paper's, by the committed results.

`tests.leaderboards.results.test_golden` solves a part of them again, and ``vbbench leaderboard rerun`` all of them.
"""

import json
from pathlib import Path

import pytest

from vbbench.paper import the_paper

RESULTS = Path(__file__).parents[2] / "leaderboards" / "results"
NAMES = ("dx_rel", "dx", "dr", "dt")


def means(split: str, board: str, solver: str) -> dict[str, float]:
    """Mean figures of a committed result."""
    facts = json.loads((RESULTS / split / board / f"{solver}.json").read_text("utf-8"))
    return {name: facts["score"]["metrics"][name]["mean"] for name in NAMES}


@pytest.mark.parametrize("solver", ["vb-cv", "vb-sf"])
@pytest.mark.parametrize("split", ["hotel", "eth", "students"])
def test_the_paper_is_reached(split: str, solver: str) -> None:
    measured, paper = means(split, "one-step-ideal", solver), the_paper().figures(split, solver.upper())
    for name in NAMES:
        assert round(measured[name], 3) <= paper[name], name


@pytest.mark.parametrize("split", ["eth", "students"])
def test_with_noise_people_are_placed_at_least_as_well_as_by_vb_cv(split: str) -> None:
    ours, theirs = (means(split, "one-step-noisy", solver)["dx"] for solver in ("vb-sf", "vb-cv"))
    assert ours <= theirs
