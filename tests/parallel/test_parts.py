"""Parts of a cluster become the same bytes as one process writes; no cluster is needed to see that."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from tests.generation.test_datasets import digests
from vbbench.files.dataset import Dataset
from vbbench.files.tables import to_arrow
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench.parallel import cluster
from vbbench.parallel.parts import Part, Work, packed, progress_bar, write_in_parts
from vbbench.solving import solve

LIMIT = 70


def last_part_first(work: Work, ranges: Sequence[tuple[int, int]], scheduler: str) -> Iterator[cluster.PackedPart]:
    """Stands for a cluster: parts come back in any order."""
    yield from reversed([(first, last, packed(work(first, last))) for first, last in ranges])


@pytest.fixture(autouse=True, scope="module")
def _no_cluster() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cluster, "on_cluster", last_part_first)
        patch.setattr("vbbench.files.sequence_tables.PART_SIZE", 20)
        yield


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return generate("demo", tmp_path_factory.mktemp("whole") / "demo", Options(limit=LIMIT))


@pytest.mark.parametrize("withheld", [False, True])
def test_a_cluster_makes_the_same_bytes(tmp_path: Path, withheld: bool) -> None:
    options = Options(limit=LIMIT)
    for name, scheduler in (("here", None), ("there", "tcp://nowhere")):
        generate("demo", tmp_path / name, options, scheduler=scheduler, withhold_truth=withheld)
    assert digests(tmp_path / "there") == digests(tmp_path / "here")
    if withheld:
        assert digests(tmp_path / "there.truth") == digests(tmp_path / "here.truth")


def stop(*_arguments: object) -> None:
    raise KeyboardInterrupt


def test_parts_of_a_cluster_are_kept_for_whoever_goes_on(
    whole: Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        patch.setattr("vbbench.parallel.parts.TableWriter", stop)
        with pytest.raises(KeyboardInterrupt):
            generate("demo", tmp_path / "out", Options(limit=LIMIT), scheduler="tcp://nowhere")
    assert len(list((tmp_path / "out.partial").rglob("*.arrows"))) == 4
    monkeypatch.setattr("vbbench.generation.datasets._build_part", stop)
    assert digests(generate("demo", tmp_path / "out", Options(limit=LIMIT)).folder) == digests(whole.folder)


@pytest.mark.slow
@pytest.mark.parametrize(
    "solver", ["vb-cv", "cv", *(f"tests.solving.test_extras:{name}" for name in ("Moody", "Reporting"))]
)
def test_submissions_of_a_cluster_have_the_columns_that_any_part_has(
    whole: Dataset, tmp_path: Path, solver: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, scheduler in (("here", None), ("there", "tcp://nowhere")):
        monkeypatch.setattr("tests.solving.test_extras.Moody.made", 0)
        solve(whole, solver, "rollout", tmp_path / name, scheduler=scheduler)
    here, there = (digests(tmp_path / name) for name in ("here", "there"))
    del here["submission.json"], there["submission.json"]
    assert here == there


def test_a_table_gets_a_column_that_only_a_later_part_has_and_is_begun_before_that_part_is_made(tmp_path: Path) -> None:
    begun: list[int] = []

    def work(first: int, _last: int) -> Part:
        begun.append(len(list(tmp_path.glob(".positions*"))))
        rows = {"sequence": np.array([first]), "frame": np.array([2]), "track": np.array([0])}
        rows |= {name: np.array([1.5]) for name in ("x", "y", *(("xx", "xy", "yy") if first == 2 else ()))}
        return Part(groups={"positions": [to_arrow("positions", rows)]}, facts={"first": first})

    path = tmp_path / "positions.parquet"
    facts = write_in_parts(work, [(0, 1), (1, 2), (2, 3)], tmp_path, {"positions": path}, label="test")
    assert facts == [{"first": 0}, {"first": 1}, {"first": 2}]
    assert begun == [0, 1, 1]
    table = pq.read_table(path)
    assert table["sequence"].to_pylist() == [0, 1, 2]
    np.testing.assert_array_equal(table["xx"].to_pylist(), [np.nan, np.nan, 1.5])


def test_progress_without_a_terminal_is_whole_lines_and_short_work_has_none(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    with progress_bar(3, "frames", unit="frame") as bar:
        bar.update(3)
    assert not capsys.readouterr().err

    monkeypatch.setattr("vbbench.parallel.parts.SILENCE", 1e-9)
    with progress_bar(3, "frames", unit="frame") as bar:
        for _ in range(3):
            bar.update()
    lines = capsys.readouterr().err.splitlines()
    assert [line.split("[")[0] for line in lines] == [
        "frames:  33% 1/3 ",
        "frames:  67% 2/3 ",
        "frames: 100% 3/3 ",
    ]
