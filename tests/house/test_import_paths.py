"""Import paths that users have: they stay, wherever modules move."""

from importlib import import_module

import pytest

import vbbench
from vbbench import generation, scoring, solving

OLDER = {
    "vbbench.camera": "PerspectiveCamera",
    "vbbench.generation": "generate",
    "vbbench.geometry": "wrap_angle",
    "vbbench.scene": "Scene",
    "vbbench.scoring": "score",
    "vbbench.solving": "solve",
    "vbbench_baselines.joint_map": "MapCausal",
    "vbbench_baselines.motion_models": "SocialForceWalk",
    "vbbench_baselines.social_force_birdifier": "PriorHeights",
    "vbbench_baselines.view_birdification": "ConstantVelocityBirdifier",
    "vbbench_generators.social_force": "Moussaid",
    "vbbench_renderers.people": "__name__",
    "vbbench_renderers.surroundings": "__name__",
}


@pytest.mark.parametrize("path", OLDER)
def test_a_published_import_path_stays(path: str) -> None:
    assert hasattr(import_module(path), OLDER[path])


@pytest.mark.parametrize("package", [vbbench, generation, scoring, solving], ids=lambda package: package.__name__)
def test_every_public_name_can_be_imported(package) -> None:
    assert all(hasattr(package, name) for name in package.__all__)
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = package.nothing
