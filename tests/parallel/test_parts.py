"""Partitions become the same bytes as one machine writes, or are refused; no cluster is needed to see that."""

import hashlib
import json
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from tests.generation.test_datasets import digests
from vbbench.cli import main
from vbbench.errors import FileError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.tables import to_arrow
from vbbench.files.verification import verify
from vbbench.generation import generate, generate_partitioned
from vbbench.generation.generator import Options
from vbbench.parallel import cluster
from vbbench.parallel.partitions import merge
from vbbench.parallel.parts import PackedPart, Part, Work, pack, part_name, progress_bar, write_in_parts
from vbbench.solving import solve

LIMIT = 70


def last_part_first(work: Work, ranges: Sequence[tuple[int, int]], scheduler: str) -> Iterator[PackedPart]:
    """Stands for a cluster: parts come back in any order."""
    yield from reversed([pack(work(first, last), part_name(first)) for first, last in ranges])


@pytest.fixture(autouse=True, scope="module")
def _no_cluster() -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cluster, "on_cluster", last_part_first)
        patch.setattr("vbbench.files.sequence_tables.PART_SIZE", 20)
        yield


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return generate("demo", tmp_path_factory.mktemp("whole") / "demo", Options(limit=LIMIT))


@pytest.fixture(scope="module")
def partitions(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("partitions") / "spread"
    generate_partitioned("demo", folder, Options(limit=LIMIT), scheduler="tcp://nowhere")
    return folder


@pytest.fixture
def spread(partitions: Path, tmp_path: Path) -> Path:
    """Partitions that a test may merge or spoil."""
    return Path(shutil.copytree(partitions, tmp_path / "spread"))


def test_merged_in_place_or_elsewhere(whole: Dataset, spread: Path, tmp_path: Path) -> None:
    assert digests(merge(spread, tmp_path / "elsewhere")) == digests(whole.folder)
    assert digests(merge(spread)) == digests(whole.folder)
    assert sorted(path.name for path in spread.rglob("*") if path.is_dir()) == ["truth"]
    with pytest.raises(VbbenchError, match="is not partitioned"):
        merge(spread)


def test_withheld_truth_goes_beside(tmp_path: Path) -> None:
    options = Options(limit=LIMIT)
    generate("demo", tmp_path / "a", options, withhold_truth=True)
    generate_partitioned("demo", tmp_path / "b", options, scheduler="tcp://nowhere", withhold_truth=True)
    merge(tmp_path / "b", tmp_path / "c")
    merge(tmp_path / "b")
    for name in ("b", "c"):
        assert digests(tmp_path / name) == digests(tmp_path / "a")
        assert digests(tmp_path / f"{name}.truth") == digests(tmp_path / "a.truth")


@pytest.mark.parametrize("damage", ["missing", "changed"])
@pytest.mark.parametrize("name", ["observations/part-00000020.parquet", "partitioned/part-00000040.json"])
def test_damaged_partitions_are_refused_and_mended_ones_merged(
    whole: Dataset, spread: Path, name: str, damage: str
) -> None:
    path, text = spread / name, (spread / name).read_bytes()
    if damage == "missing":
        path.unlink()
    else:
        path.write_bytes(text[: len(text) // 2])
    with pytest.raises(FileError, match=f"{path.name}.*copy the partitions again"):
        merge(spread)
    with pytest.raises(VbbenchError, match="is partitioned"):
        Dataset(spread)
    path.write_bytes(text)
    assert digests(merge(spread)) == digests(whole.folder)


def stop(*_arguments: object) -> None:
    raise KeyboardInterrupt


def test_what_is_in_the_way_is_left_alone(whole: Dataset, spread: Path, tmp_path: Path) -> None:
    again = {"scheduler": "tcp://nowhere"}
    with pytest.raises(VbbenchError, match=r"set .overwrite"):
        generate_partitioned("demo", spread, Options(limit=3), **again)  # type: ignore[arg-type]
    (tmp_path / "mine").mkdir()
    with pytest.raises(VbbenchError, match="exists and is not a merged folder"):
        merge(spread, tmp_path / "mine")
    generate_partitioned("demo", spread, Options(limit=3), overwrite=True, **again)  # type: ignore[arg-type]
    assert len(Dataset(merge(spread))) == 3
    generate("demo", spread, Options(limit=LIMIT), overwrite=True)
    assert digests(spread) == digests(whole.folder)


def test_parts_kept_in_another_way_are_made_again(
    whole: Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        patch.setattr("vbbench.generation.datasets.write_layout", stop)
        with pytest.raises(KeyboardInterrupt):
            generate_partitioned("demo", tmp_path / "out", Options(limit=LIMIT), scheduler="tcp://nowhere")
    assert list((tmp_path / "out.partial").rglob("part-00000020.parquet"))
    assert digests(generate("demo", tmp_path / "out", Options(limit=LIMIT)).folder) == digests(whole.folder)


DAMAGES: list[tuple[str, dict[str, object], str]] = [
    ("layout", {"tables": ["../victim"]}, "tables are"),
    ("layout", {"tables": []}, "tables are"),
    ("layout", {"tables": "observations"}, "tables are"),
    ("layout", {"marker": "../victim/notes.txt"}, "marker is"),
    ("layout", {"marker": ["dataset.json"]}, "marker is"),
    ("layout", {"parts": ["../../victim/notes"]}, "parts are"),
    ("layout", {"parts": [[]]}, "parts are"),
    ("layout", {"withheld": "no"}, "withheld is"),
    ("layout", {"more": 1}, "more"),
    ("part-00000000", {"sha256": None}, "columns or sha256 are missing"),
    ("part-00000000", {"columns": {"observations": ["../victim"]}}, "no columns or SHA-256 of observations"),
    ("part-00000000", {"columns": {"observations": 1}}, "no columns or SHA-256 of observations"),
    ("part-00000000", {"sha256": {"observations": 1}}, "no columns or SHA-256 of observations"),
]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "damage", "problem"), DAMAGES)
def test_nothing_that_a_partition_says_reaches_outside(
    whole: Dataset, spread: Path, tmp_path: Path, name: str, damage: dict[str, object], problem: str
) -> None:
    victim = tmp_path / "victim" / "notes.txt"
    victim.parent.mkdir()
    victim.write_text("years of work")
    path = spread / "partitioned" / f"{name}.json"
    text = path.read_text("utf-8")
    path.write_text(json.dumps({**json.loads(text), **damage}), encoding="utf-8")
    before = digests(spread)
    for out in (None, tmp_path / "out"):
        with pytest.raises(FileError, match=rf"{name}\.json: is damaged .*{problem}.*copy the partitions again"):
            merge(spread, out)
    assert victim.read_text() == "years of work"
    assert digests(spread) == before
    assert sorted(place.name for place in tmp_path.iterdir()) == ["spread", "victim"]
    path.write_text(text, encoding="utf-8")
    assert digests(merge(spread)) == digests(whole.folder)


def test_a_table_of_other_columns_is_refused_although_its_hash_is_right(spread: Path) -> None:
    path = spread / "partitioned" / "part-00000020.json"
    data = (spread / "given" / "part-00000020.parquet").read_bytes()
    (spread / "observations" / "part-00000020.parquet").write_bytes(data)
    facts = json.loads(path.read_text("utf-8"))
    facts["sha256"]["observations"] = facts["sha256"]["given"]
    path.write_text(json.dumps(facts), encoding="utf-8")
    with pytest.raises(FileError, match=r"observations/part-00000020\.parquet: has the columns"):
        merge(spread)
    noise = b"PAR1 no table PAR1"
    (spread / "observations" / "part-00000020.parquet").write_bytes(noise)
    facts["sha256"]["observations"] = hashlib.sha256(noise).hexdigest()
    path.write_text(json.dumps(facts), encoding="utf-8")
    with pytest.raises(FileError, match=r"observations/part-00000020\.parquet: is damaged"):
        merge(spread)


def test_what_is_no_partition_stays_in_the_folder(whole: Dataset, spread: Path) -> None:
    (spread / "notes.txt").write_text("mine")
    (spread / "notes").mkdir()
    (spread / "notes" / "more.txt").write_text("mine, too")
    merge(spread)
    assert (spread / "notes.txt").read_text() == "mine"
    assert (spread / "notes" / "more.txt").read_text() == "mine, too"
    assert digests(spread).items() >= digests(whole.folder).items()


@pytest.mark.slow
@pytest.mark.parametrize("place", ["in place", "elsewhere"])
def test_a_truth_that_is_kept_is_never_replaced_unasked(tmp_path: Path, place: str) -> None:
    again = {"scheduler": "tcp://nowhere", "withhold_truth": True}
    generate_partitioned("demo", tmp_path / "spread", Options(limit=LIMIT), **again)  # type: ignore[arg-type]
    out = tmp_path / ("spread" if place == "in place" else "out")
    generate("demo", tmp_path / "other", Options(limit=3, seed=1), withhold_truth=True)
    shutil.copytree(tmp_path / "other.truth", f"{out}.truth")
    kept, spread = digests(tmp_path / "other.truth"), digests(tmp_path / "spread")
    with pytest.raises(VbbenchError, match=rf"{out.name}\.truth exists and may be the only copy.*overwrite"):
        merge(tmp_path / "spread", out)
    assert digests(Path(f"{out}.truth")) == kept
    assert digests(tmp_path / "spread") == spread
    assert main(["merge", str(tmp_path / "spread"), "--out", str(out), "--overwrite"]) == 0
    assert verify(out, f"{out}.truth")


@pytest.mark.slow
@pytest.mark.parametrize(
    "solver", ["vb-cv", "cv", *(f"tests.solving.test_extras:{name}" for name in ("Moody", "Reporting"))]
)
def test_submissions_merge_with_the_columns_that_any_part_has(
    whole: Dataset, tmp_path: Path, solver: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name, scheduler in (("here", None), ("there", "tcp://nowhere")):
        monkeypatch.setattr("tests.solving.test_extras.Moody.made", 0)
        solve(whole, solver, "rollout", tmp_path / name, scheduler=scheduler)
    here, there = (tables(folder) for folder in (tmp_path / "here", merge(tmp_path / "there")))
    assert here == there
    declared = json.loads((tmp_path / "there" / "submission.json").read_text())
    assert declared["hardware"]


def tables(folder: Path) -> dict[str, str]:
    return {
        path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in folder.iterdir() if "json" not in path.name
    }


def test_every_command_that_reads_refuses_partitions(
    whole: Dataset, spread: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = solve(whole, "cv", "one-step", tmp_path / "answers", scheduler="tcp://nowhere")
    for command in (
        f"info {spread}",
        f"verify {spread}",
        f"solve {spread} --solver cv --out x",
        f"plot {spread} --sequence 0 --out x.png",
        f"export tum {spread} --out x",
        f"score {out} --dataset {spread}",
        f"score {out} --dataset {whole.folder}",
        f"compare {out} {out} --dataset {whole.folder}",
    ):
        assert main(command.split()) == 2, command
        error = capsys.readouterr().err
        assert "is partitioned; run 'vbbench merge " in error, command
        assert error.count("\n") == 1
    assert main(["merge", str(out)]) == 0
    assert capsys.readouterr().out == f"{out}\n"
    shutil.rmtree(out)


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


def test_an_interrupted_merge_is_done_again(whole: Dataset, spread: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for step in ("vbbench.parallel.partitions.describe_tables", "vbbench.folders.work_folder._rename"):
        with monkeypatch.context() as patch:
            patch.setattr(step, stop)
            with pytest.raises(KeyboardInterrupt):
                merge(spread)
    assert digests(merge(spread)) == digests(whole.folder)


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
