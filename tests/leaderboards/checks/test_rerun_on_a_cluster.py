"""Boards regenerated on a cluster: the same figures as here."""

from pathlib import Path

import pytest

from vbbench.protocol import PROTOCOLS
from vbbench_leaderboards.checks.rerunning import Rerun

pytest.importorskip("distributed", reason="needs the extra dask")
pytestmark = pytest.mark.extra


@pytest.mark.slow
def test_a_cluster_gives_the_same_figures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from distributed import LocalCluster

    monkeypatch.setattr("vbbench_leaderboards.results.boards._LIMITS", {"sim": 6})

    def states(**how: str) -> list[str]:
        folders = {"results": tmp_path / "results", "work": tmp_path / "work"}
        run = Rerun(**folders, update=True, seed=3, fresh=True, together=True, **how)
        return [outcome.state for outcome in run.boards(["sim"], ["cv"], ["noisy"])]

    files = 1 + len(PROTOCOLS)
    assert states() == ["written again"] * files
    with LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as cluster:
        assert states(scheduler=cluster.scheduler_address) == ["as committed"] * files
