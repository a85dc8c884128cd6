"""A solver fitted on public files is run, on data made of these, as the variant that was not."""

import hashlib
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

from vbbench.errors import UnknownNameError, VbbenchError, VbbenchWarning
from vbbench.files.submission import SubmissionInfo
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.registry import held_out, load
from vbbench.solver import Estimate, Problem
from vbbench.solving import solve
from vbbench.solving.declared import declared_facts
from vbbench_baselines.joint_map import MapCausal
from vbbench_baselines.joint_map.priors.left_out import BatchWithoutEth, CausalWithoutEth, CausalWithoutHotel

NAME, VARIANT, OTHER = f"{__name__}:Fitted", f"{__name__}:Variant", f"{__name__}:Other"
WALK = "\n".join(f"{10 * t} {k} {k + 0.4 * t:.2f} {2.0 * k:.2f}" for t in range(8) for k in range(1, 5)) + "\n"
WALK_SHA, OTHER_SHA = hashlib.sha256(WALK.encode()).hexdigest(), "0" * 64


@dataclass(kw_only=True)
class Fitted:
    """Puts everybody at (1, 1)."""

    facts: ClassVar[Mapping[str, str]] = {"authors": "we"}
    held_out: ClassVar[Mapping[str, str]] = {WALK_SHA: VARIANT, OTHER_SHA: OTHER}
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

    """The file has a name that nobody has heard of; its content decides."""
    (tmp_path / "renamed.txt").write_text(WALK)
    dataset = generate("custom", tmp_path / "data", Options(source=tmp_path / "renamed.txt", dt=0.4))
    out = solve(dataset, solver, "sequential", tmp_path / "out")
    assert (pd.read_parquet(out / "positions.parquet")["x"] == place).all()
    info = SubmissionInfo.read(out)
    assert info.solver == solver
    assert info.reference == (reference and f"{reference}which was not fitted on the data's source files")


def test_other_splits_and_other_solvers_are_what_they_are() -> None:
    assert held_out(NAME, {"1" * 64}) == NAME
    assert held_out(NAME, ()) == NAME
    assert held_out("vb-cv", {WALK_SHA}) == "vb-cv"
    with pytest.raises(UnknownNameError):
        held_out("vbcv", ())
    with pytest.raises(VbbenchError, match="no_such_module"):
        held_out("no_such_module:Solver", ())


def test_who_makes_a_subclass_of_ours_is_run_and_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its code is not the variant's, and what the class that it is made of says of itself is not of it."""
    ours = "from vbbench_baselines.joint_map import MapCausal"
    (tmp_path / "made_of_ours.py").write_text(f"{ours}\n\n\nclass Mine(MapCausal):\n    pass\n")
    (tmp_path / "made_of_theirs.py").write_text(f"from {__name__} import Fitted\n\n\nclass Mine(Fitted):\n    pass\n")
    monkeypatch.syspath_prepend(tmp_path)
    fitted = next(iter(MapCausal.held_out))
    with pytest.warns(VbbenchWarning, match="is made of one that was fitted on the recording of this dataset"):
        assert held_out("made_of_ours:Mine", {fitted}) == "made_of_ours:Mine"
    assert held_out("made_of_ours:Mine", {"1" * 64}) == "made_of_ours:Mine"
    assert declared_facts("made_of_ours:Mine") == {}
    assert declared_facts(NAME) == declared_facts(VARIANT) == declared_facts("made_of_theirs:Mine") == {"authors": "we"}
    assert held_out("made_of_theirs:Mine", {WALK_SHA}) == VARIANT


def test_data_of_which_no_variant_saw_nothing_are_refused() -> None:
    with pytest.raises(VbbenchError, match="several source files"):
        held_out(NAME, {WALK_SHA, OTHER_SHA})


@pytest.mark.parametrize(
    ("solver", "split", "variant"),
    [("causal:MapCausal", "hotel", CausalWithoutHotel), ("batch:MapBatch", "eth-15fps", BatchWithoutEth)],
)
def test_joint_solvers_never_saw_what_they_are_tested_on(solver: str, split: str, variant: Any) -> None:
    sources = {source.sha256 for source in load("generator", split).card.sources}
    assert load("solver", held_out(f"vbbench_baselines.joint_map.{solver}", sources)) is variant


@pytest.mark.parametrize(
    ("source", "variant"),
    [
        ("biwi_hotel.txt", CausalWithoutHotel),
        ("biwi_eth.txt", CausalWithoutEth),
        ("seq_eth_obsmat.txt", CausalWithoutEth),
        ("seq_hotel_obsmat.txt", CausalWithoutHotel),
    ],
)
def test_a_renamed_copy_of_a_recording_gets_the_prior_that_never_saw_it(
    source: str, variant: Any, data_folder: Path, tmp_path: Path
) -> None:
    copy = tmp_path / "somebody-elses-walks.txt"
    copy.write_bytes((data_folder / "eth" / source).read_bytes())
    info = load("generator", "custom").plan(Options(source=copy, dt=0.4)).info
    assert load("solver", held_out("map-causal", info.sources)) is variant
    assert info.split == "custom"


def test_every_file_that_the_default_prior_was_fitted_on_has_a_variant() -> None:
    text = (files("vbbench_baselines") / "joint_map" / "priors" / "default.toml").read_text("utf-8")
    fitted = {digest for split in tomllib.loads(text)["fitted_on"] for _, digest in split["files"]}
    assert fitted <= MapCausal.held_out.keys()
    for digest, name in MapCausal.held_out.items():
        prior = "without-hotel" if name.endswith("WithoutHotel") else "without-eth"
        kept = (files("vbbench_baselines") / "joint_map" / "priors" / f"{prior}.toml").read_text("utf-8")
        assert digest not in kept
