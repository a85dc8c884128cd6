"""Constants of tier `field` from several families: residuals in time, the scaled recipe, and the smallest run."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.field_union import DRAWN, FOUND, NAMES, SMOKE_FAMILIES, fitted, memory, pooled
from vbbench_generators.tiers.field import get_field

ROOT = Path(__file__).parents[2]
OWN = dict.fromkeys(NAMES, 0.1) | {"nearest": 0.05, "farthest": 0.45}


@pytest.mark.parametrize("time", [0.3, 1.0])
def test_correlation_times_are_found_beside_a_person_s_own_share(time: float) -> None:
    rng, kept = np.random.default_rng(0), np.exp(-0.1 / time)
    walks = rng.standard_normal((600, 20))
    for t in range(1, len(walks)):
        walks[t] = kept * walks[t - 1] + np.sqrt(1.0 - kept**2) * walks[t]
    found = memory([0.05 * (walks + rng.standard_normal(20))], 0.1, 0.07)
    assert found == pytest.approx(time, rel=0.25)


@pytest.mark.parametrize("setting", [DRAWN, FOUND])
def test_what_the_tier_already_has_is_fitted_by_its_own_recipe(setting: str) -> None:
    recipe, today = fitted(setting, OWN, OWN), get_field()
    assert (recipe.body.nearest_edge, recipe.body.farthest_edge) == pytest.approx((0.0, 0.5))
    assert replace(recipe, body=today.body) == today


def test_constants_follow_the_ratio_within_bounds() -> None:
    wanted = pooled([OWN | {"column": 0.05, "foot": 10.0}, OWN | {"column": 0.15, "foot": 10.0}, OWN | {"foot": 10.0}])
    assert wanted["column"] == pytest.approx(0.1)
    recipe, today = fitted(FOUND, wanted | {"column": 0.05, "missed": 0.2}, OWN), get_field()
    assert recipe.detector.side_std == pytest.approx(0.5 * today.detector.side_std)
    assert recipe.detector.bottom_std == pytest.approx(4.0 * today.detector.bottom_std)
    assert recipe.detector.score_best == pytest.approx(today.detector.score_best + np.log(0.1 / 0.9) - np.log(0.25))
    assert recipe.annotator == today.annotator


@pytest.mark.slow
def test_the_smallest_size_runs_and_writes_its_page(tmp_path: Path) -> None:
    """As CI runs it, without any recording."""
    page = tmp_path / "page.md"
    page.write_text(
        "Before\n\n| measured on boxes | a |\n| old |\n\nAmid\n\n| family left out | b |\n| old |\n\nAfter\n"
    )
    command = [sys.executable, "-m", "benchmarks.field_union", "--smoke", "--out", str(tmp_path / "out")]
    done = subprocess.run([*command, "--page", str(page)], cwd=ROOT, capture_output=True, text=True, encoding="utf-8")
    assert done.returncode == 0, done.stderr
    before, measured, amid, ranks, after = page.read_text("utf-8").split("\n\n")
    assert (before, amid, after) == ("Before", "Amid", "After\n")
    assert f"{measured}\n\n{ranks}\n\n" == done.stdout
    assert [line.split(" | ")[0] for line in ranks.splitlines()[2:]] == [
        *(f"| {name}" for name in SMOKE_FAMILIES),
        "| mean",
    ]
