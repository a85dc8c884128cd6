"""A solver fitted on public splits is run, on these, as the variant that was not."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

from vbbench.errors import UnknownNameError, VbbenchError
from vbbench.files.submission import SubmissionInfo
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.registry import held_out, load
from vbbench.solver import Estimate, Problem
from vbbench.solving import solve
from vbbench_baselines.joint_map.priors.left_out import BatchWithoutEth, CausalWithoutHotel

NAME, VARIANT = f"{__name__}:Fitted", f"{__name__}:Variant"


@dataclass(kw_only=True)
class Fitted:
    """Puts everybody at (1, 1)."""

    held_out: ClassVar[Mapping[str, str]] = {"demo": VARIANT}
    place: float = 1.0

    def solve(self, problem: Problem, observations: np.ndarray, given: object) -> Estimate:
        frames, people = observations.shape[:2]
        return Estimate(poses=np.zeros((frames, 3)), positions=np.full((frames, people, 2), self.place))


@dataclass(kw_only=True)
class Variant(Fitted):
    """Puts everybody at (2, 2)."""

    place: float = 2.0


@pytest.mark.parametrize(("solver", "place", "reference"), [(NAME, 2.0, f"run as {VARIANT}, "), (VARIANT, 2.0, "")])
def test_the_variant_is_run_and_said(solver: str, place: float, reference: str, tmp_path: Path) -> None:
    import pandas as pd

    dataset = generate("demo", tmp_path / "demo", Options(limit=2))
    out = solve(dataset, solver, "sequential", tmp_path / "out")
    assert (pd.read_parquet(out / "positions.parquet")["x"] == place).all()
    info = SubmissionInfo.read(out)
    assert info.solver == solver
    assert info.reference == (reference and f"{reference}which was not fitted on demo")


def test_other_splits_and_other_solvers_are_what_they_are() -> None:
    assert held_out(NAME, "hotel") == NAME
    assert held_out("vb-cv", "hotel") == "vb-cv"
    with pytest.raises(UnknownNameError):
        held_out("vbcv", "hotel")
    with pytest.raises(VbbenchError, match="no_such_module"):
        held_out("no_such_module:Solver", "hotel")


@pytest.mark.parametrize(
    ("solver", "split", "variant"),
    [("causal:MapCausal", "hotel", CausalWithoutHotel), ("batch:MapBatch", "eth-15fps", BatchWithoutEth)],
)
def test_joint_solvers_never_saw_what_they_are_tested_on(solver: str, split: str, variant: Any) -> None:
    assert load("solver", held_out(f"vbbench_baselines.joint_map.{solver}", split)) is variant
