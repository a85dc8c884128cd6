"""Tables 2 and 3 of the paper: averages against pandas, and what is missing."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from vbbench.paper import PROTOCOLS, SIGMA_H, SPLITS, the_paper
from vbbench.reproduction.grid import Making, row_at
from vbbench.reproduction.solver_tables import COUNTERPARTS, SolverTable, SolverTableStudy

DEMO = SolverTableStudy(table=2, splits=("demo",), solvers=("cv", "vb-cv"), every=16)


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("table2")


@pytest.fixture(scope="module")
def found(out: Path) -> SolverTable:
    """Figures on the demo, as if the paper had it in Table 2."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(SPLITS, 2, ("demo",))
        return DEMO.measure(out, Making())


def frame_means(dataset: Path, submission: Path) -> dict[str, pd.Series]:
    """Δt, Δx and Δx̃ of every scored frame, from the tables alone: a scene's places moved to the sequence's world."""
    keys = ["sequence", "frame"]
    poses = pd.read_parquet(submission / "poses.parquet").merge(
        pd.read_parquet(dataset / "truth/poses.parquet"), on=keys, suffixes=("", "_true")
    )
    people = pd.read_parquet(submission / "positions.parquet")
    people = people.merge(pd.read_parquet(dataset / "sequences.parquet")[["sequence", "scene", "first_frame"]])
    people = people.merge(pd.read_parquet(dataset / "truth/tracks.parquet")[["sequence", "track", "person"]])
    people["at"] = people["frame"] + people["first_frame"]
    scenes = pd.read_parquet(dataset / "truth/scenes.parquet").rename(columns={"frame": "at"})
    people = people.merge(scenes, on=["scene", "at", "person"], suffixes=("", "_scene"))
    worlds = pd.read_parquet(dataset / "truth/frames.parquet")
    people = people.merge(worlds, on="sequence", suffixes=("", "_world")).merge(poses, on=keys, suffixes=("", "_pose"))
    cos, sin = np.cos(people["yaw"]), np.sin(people["yaw"])
    right = people["x"] - people["x_world"] - cos * people["x_scene"] + sin * people["y_scene"]
    up = people["y"] - people["y_world"] - sin * people["x_scene"] - cos * people["y_scene"]
    people["dx"] = np.hypot(right, up)
    people["dx_rel"] = np.hypot(right - people["x_pose"] + people["x_true"], up - people["y_pose"] + people["y_true"])
    poses["dt"] = np.hypot(poses["x"] - poses["x_true"], poses["y"] - poses["y_true"])
    return {"dt": poses["dt"], **{name: people.groupby(keys)[name].mean() for name in ("dx", "dx_rel")}}


@pytest.mark.slow
@pytest.mark.parametrize("protocol", PROTOCOLS)
@pytest.mark.parametrize("sigma_h", [0.0, SIGMA_H])
def test_the_papers_way_is_a_plain_mean_over_frames(
    found: SolverTable, out: Path, protocol: str, sigma_h: float
) -> None:
    folder = out / f"demo-sigma-{sigma_h:g}"
    row = row_at(found.rows, protocol=protocol, sigma_h=sigma_h, solver="vb-cv")
    for metric, frames in frame_means(folder / "dataset", folder / f"{protocol}-vb-cv").items():
        own = row["figures"][metric]
        assert own.frame_mean == pytest.approx(frames.mean(), rel=1e-9)
        assert own.frame_std == pytest.approx(frames.std(ddof=0), rel=1e-9)


def test_whose_row_of_the_paper_a_solver_is_compared_with() -> None:
    assert set(COUNTERPARTS.values()) == {row.solver for row in the_paper().select("hotel")}
    assert the_paper().figures("demo", "VB-SF") == {}
