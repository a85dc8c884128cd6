"""A tiny recipe, and its crowds."""

from pathlib import Path

import pytest

from vbbench.protocol import PROTOCOLS
from vbbench_baselines.former.training.crowds import Crowds, make_crowds
from vbbench_baselines.former.training.recipe import Phase, Recipe, Size, Stream

TINY = Recipe(
    seed=2,
    held_out_seed=1,
    held_out=4,
    people={"open": (4, 7), "plaza": (5,)},
    protocols=dict.fromkeys(PROTOCOLS, 0.25),
    stream=(
        Stream(name="near", split="sim", scenarios=("open",), sequences=5, share=1.0, camera="panorama"),
        Stream(name="far", split="sim", scenarios=("plaza",), sequences=3, share=2.0, camera="panorama", tier="field"),
    ),
    size=(Size(least=2, most=3, windows=8, share=0.5), Size(least=4, most=6, windows=4, share=0.5)),
    windows=24,
    rate=3e-3,
    decay=0.3,
    averaged=0.5,
    phase=(Phase(frames=5, share=0.5), Phase(frames=7, share=0.5)),
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("former") / "crowds"


@pytest.fixture(scope="module")
def crowds(folder: Path) -> Crowds:
    return make_crowds(TINY, folder, TINY.seed)
