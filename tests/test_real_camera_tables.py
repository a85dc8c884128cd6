"""The benchmarks behind docs/real-cameras.md: what is left out is left out only while it is, and tables are found."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks import real_camera_ablation as ablation
from benchmarks.real_camera.__main__ import chosen
from benchmarks.real_camera_tables import PAGE, TABLES, Table, replaced
from vbbench.camera import PerspectiveCamera
from vbbench.registry import make_solver
from vbbench_baselines.joint_map.real_camera import tracking
from vbbench_baselines.joint_map.real_camera.cues import Noise
from vbbench_baselines.joint_map.real_camera.hands import Hands
from vbbench_baselines.joint_map.real_camera.noise import SIGMAS, TAUS, NoiseLearner
from vbbench_baselines.joint_map.real_camera.settings import Settings

ROOT = Path(__file__).parent.parent


def learner() -> NoiseLearner:
    return NoiseLearner(Noise(np.full(3, 0.05), np.full(3, 0.4), np.full(3, 6.0)), 0.7, 4.0)


@pytest.mark.parametrize("name", ablation.VARIANTS)
def test_every_variant_is_a_solver_and_differs_from_the_whole(name: str) -> None:
    variant, solver = ablation.VARIANTS[name], make_solver(f"benchmarks.real_camera_ablation:{name}")
    changed = variant.settings != Settings() or variant.without is not ablation.Variant.without
    assert changed != (name in ("all", "exact"))
    assert (solver.settings is None) == (name == "exact")


def test_parts_are_back_once_a_variant_has_answered() -> None:
    whole = (vars(tracking)["bearings_of"], Hands.changes, NoiseLearner.learn)
    for variant in ablation.VARIANTS.values():
        with variant.without():
            pass
        assert (vars(tracking)["bearings_of"], Hands.changes, NoiseLearner.learn) == whole


def test_noise_that_is_held_is_not_learned_and_the_rest_is() -> None:
    told = np.zeros((3, len(SIGMAS), len(TAUS)))
    told[:, -1, -1] = 100.0
    with ablation.held(sigma=(None, None, 7.0), tau=0.01):
        one = learner()
        one.learn(told)
    np.testing.assert_allclose(one.noise.sigma, (SIGMAS[-1], SIGMAS[-1], 7.0), rtol=1e-6)
    assert (one.noise.tau == 0.01).all()
    with ablation.nothing_learned():
        one = learner()
        one.learn(told)
    assert (one.noise.sigma == 0.05).all()


def test_without_the_border_rule_no_box_is_cut() -> None:
    camera = PerspectiveCamera(width=640, height=480, focal=500.0, cx=320.0, cy=240.0, mount_height=1.6)
    box = np.array((320.0, 400.0, 200.0))
    assert vars(tracking)["bearings_of"](camera, box).cut != 0
    with ablation.no_borders():
        assert vars(tracking)["bearings_of"](camera, box).cut == 0


def test_a_table_is_replaced_where_its_first_line_is() -> None:
    page = "a\n\n| x | y |\n|---|---|\n| old | 1 |\n\nb\n"
    new = ["| x | y |", "|---|---|", "| new | 2 |", "| more | 3 |"]
    assert replaced(page, new) == "a\n\n| x | y |\n|---|---|\n| new | 2 |\n| more | 3 |\n\nb\n"
    assert replaced(page, ["| z |"]) == page


@pytest.mark.parametrize("table", TABLES, ids=lambda table: table.title)
def test_every_table_has_its_place_and_its_cells(table: Table) -> None:
    assert table.header in (ROOT / PAGE).read_text("utf-8").split("\n")
    assert chosen(",".join(table.cells))
