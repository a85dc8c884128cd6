"""Golden values: vb-cv, one-step, panorama, ideal, σ_h = 0.07, seed 0, on the real recordings."""

from pathlib import Path

import pytest

from vbbench.camera import PanoramaCamera
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.paper import the_paper
from vbbench.scoring import score
from vbbench.solving import solve

NAMES = ("dx_rel", "dx", "dr", "dt")
# Mean over sequences of Δx̃ m, Δx m, Δr rad, Δt m; Students are the first 60 sequences.
GOLDEN = {
    "hotel": (None, (0.03630, 0.04665, 0.01095, 0.04720)),
    "eth": (None, (0.04949, 0.07284, 0.01235, 0.07270)),
    "students": (60, (0.00527, 0.00685, 0.00074, 0.00707)),
}


@pytest.mark.slow
@pytest.mark.parametrize("split", GOLDEN)
def test_one_step_figures(split: str, data_folder: Path, tmp_path: Path) -> None:
    limit, golden = GOLDEN[split]
    dataset = generate(split, tmp_path / split, Options(camera=PanoramaCamera(), limit=limit), jobs=1)
    submission = solve(dataset, "vb-cv", "one-step", tmp_path / "answers")
    result = score(submission, dataset.folder)
    measured = [result.summaries[name].mean for name in NAMES]
    assert measured == pytest.approx(golden, rel=0.02)
    paper = the_paper().figures(split, "VB-CV")
    for name, value in zip(NAMES, measured, strict=True):
        printed = paper[name]
        assert round(value, 3) <= printed, f"{name} is {value:.4f}, the paper has {printed}"
