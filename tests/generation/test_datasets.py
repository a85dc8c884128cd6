"""Dataset folders: the same bytes for any number of jobs, whole or not there, refused when damaged."""

import hashlib
import json
import shutil
import subprocess
import sys
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

from vbbench.camera import PanoramaCamera, PerspectiveCamera
from vbbench.errors import FileError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.sequence_tables import PART_SIZE, ROWS_A_PART, part_ranges
from vbbench.files.verification import verify
from vbbench.generation import generate
from vbbench.generation.datasets import stream
from vbbench.generation.generator import Options, Simulation
from vbbench.geometry import world_to_relative
from vbbench.registry import load
from vbbench.solving import solve
from vbbench.training.sources import GeneratedSamples

LIMIT = 40


def options(**changes: object) -> Options:
    return Options(**{"camera": PanoramaCamera(), "limit": LIMIT, **changes})  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    return generate("demo", tmp_path_factory.mktemp("made") / "demo", options())


@pytest.fixture
def copy(made: Dataset, tmp_path: Path) -> Path:
    return Path(shutil.copytree(made.folder, tmp_path / "copy"))


def digests(folder: Path) -> dict[str, str]:
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in folder.rglob("*.*")
    }


@pytest.mark.slow
def test_bytes_do_not_depend_on_jobs(made: Dataset, tmp_path: Path) -> None:
    again = generate("demo", tmp_path / "again", options(), jobs=2)
    assert digests(again.folder) == digests(made.folder)


def test_a_limit_takes_the_first_sequences_unchanged(made: Dataset, tmp_path: Path) -> None:
    few = generate("demo", tmp_path / "few", options(limit=5, tier="noisy"))
    more = generate("demo", tmp_path / "more", options(limit=9, tier="noisy"))
    for a, b in zip(few.sequences(), more.sequences(0, 5), strict=True):
        np.testing.assert_array_equal(a.observations, b.observations)
        np.testing.assert_array_equal(few.truth(a).poses, more.truth(b).poses)
    assert few.info.id != more.info.id


def test_seed_zero_is_a_seed(made: Dataset, tmp_path: Path) -> None:
    one = generate("demo", tmp_path / "one", options(seed=1))
    assert one.info.id != made.info.id
    assert not np.array_equal(one.scene(0)[2], made.scene(0)[2])


@pytest.mark.parametrize("camera", [PanoramaCamera(), PerspectiveCamera()])
def test_boxes_are_the_projection_of_the_truth(camera: PanoramaCamera, tmp_path: Path) -> None:
    dataset = generate("demo", tmp_path / "d", options(camera=camera, limit=6))
    for sequence in dataset.sequences():
        truth = dataset.truth(sequence)
        relative = world_to_relative(truth.positions, truth.poses)
        heights = np.broadcast_to(truth.heights, relative.shape[:2])
        seen = sequence.observed
        np.testing.assert_allclose(camera.project(relative, heights)[seen], sequence.observations[seen], atol=1e-9)
        np.testing.assert_allclose(camera.unproject(sequence.observations, heights)[seen], relative[seen], atol=1e-9)


def test_wandering_look_turns_the_head_and_nothing_else(made: Dataset, tmp_path: Path) -> None:
    wander = generate("demo", tmp_path / "wander", options(look="wander"))
    turns = []
    for a, b in zip(made.sequences(), wander.sequences(), strict=True):
        plain, turned = made.truth(a).poses, wander.truth(b).poses
        np.testing.assert_array_equal(plain[:, :2], turned[:, :2])
        turns.append(np.angle(np.exp(1j * (turned[:, 2] - plain[:, 2]))))
    assert 0.3 < np.concatenate(turns).std() < 0.7


def test_what_is_in_the_way_is_left_alone(copy: Path, tmp_path: Path) -> None:
    with pytest.raises(VbbenchError, match=r"set .overwrite"):
        generate("demo", copy, options())
    foreign = tmp_path / "mine"
    foreign.mkdir()
    (foreign / "thesis.tex").write_text("years of work")
    with pytest.raises(VbbenchError, match="is not a dataset"):
        generate("demo", foreign, options(), overwrite=True)
    assert (foreign / "thesis.tex").read_text() == "years of work"
    generate("demo", copy, options(limit=3), overwrite=True)
    assert len(Dataset(copy)) == 3


@pytest.mark.parametrize("table", ["observations", "truth/poses"])
def test_one_changed_byte_is_found(copy: Path, table: str) -> None:
    path = copy / f"{table}.parquet"
    data = bytearray(path.read_bytes())
    data[len(data) // 3] ^= 1
    path.write_bytes(data)
    with pytest.raises(FileError, match=rf"{path.name}.*SHA-256"):
        verify(copy)


def test_half_a_file_and_a_dataset_json_of_another_seed_are_refused_at_once(copy: Path) -> None:
    facts, table = copy / "dataset.json", copy / "observations.parquet"
    table.write_bytes(table.read_bytes()[:-100])
    with pytest.raises(FileError, match=r"observations\.parquet.*bytes"):
        Dataset(copy)
    facts.write_text(facts.read_text().replace('"seed": 0', '"seed": 7'))
    with pytest.raises(FileError, match="do not belong to its id"):
        Dataset(copy)
    facts.unlink()
    with pytest.raises(FileError, match="vbbench generate SPLIT"):
        Dataset(copy)


@pytest.mark.parametrize("rows", [None, np.ones(70, int), np.r_[np.full(40, 600_000), np.ones(30, int)]])
def test_parts_cover_the_work_once_and_hold_no_more_than_they_may(rows: np.ndarray | None) -> None:
    ranges = part_ranges(70, rows)
    assert [i for first, last in ranges for i in range(first, last)] == list(range(70))
    assert max(last - first for first, last in ranges) <= PART_SIZE
    if rows is not None:
        assert max(rows[first:last].sum() for first, last in ranges) <= ROWS_A_PART


@pytest.mark.slow
def test_how_the_work_is_cut_shows_in_no_file(made: Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("vbbench.files.sequence_tables.ROWS_A_PART", 500)
    monkeypatch.setattr("vbbench.parallel.parts.BYTES_IN_MEMORY", 1)
    assert len(part_ranges(LIMIT, load("generator", "demo").plan(options()).expected_rows)) > LIMIT // 2
    again = generate("demo", tmp_path / "again", options(), jobs=2)
    assert digests(again.folder) == digests(made.folder)
    solve(made, "cv", "sequential", tmp_path / "cut", jobs=2)
    monkeypatch.undo()
    solve(made, "cv", "sequential", tmp_path / "whole")
    for table in ("poses.parquet", "positions.parquet"):
        assert (tmp_path / "cut" / table).read_bytes() == (tmp_path / "whole" / table).read_bytes()


def test_dataset_json_names_what_a_reader_needs(made: Dataset) -> None:
    facts = json.loads((made.folder / "dataset.json").read_text())
    assert {"format_version", "split", "seed", "camera", "tier", "dt", "definition", "package_version"} <= set(facts)
    assert set(facts["tables"]) == {
        *("sequences", "observations", "given"),
        *("truth/scenes", "truth/people", "truth/poses", "truth/tracks", "truth/frames"),
    }
    assert all(len(table["sha256"]) == 64 for table in facts["tables"].values())


OPTIONS = Options(simulation=Simulation(people=(5, 8)), tier="noisy")


def test_the_stream_holds_what_generate_writes(tmp_path: Path) -> None:
    written = generate("sim", tmp_path / "sim", Options(simulation=OPTIONS.simulation, tier="noisy", limit=4))
    for sequence, data in zip(written.sequences(), stream("sim", OPTIONS), strict=False):
        np.testing.assert_array_equal(sequence.observations, data.sequence.observations)
        np.testing.assert_array_equal(written.truth(sequence).poses, data.truth.poses)


def test_simulated_streams_do_not_end_with_the_split_and_others_do() -> None:
    short = Options(simulation=Simulation(people=(5,), sequences=2))
    assert [data.sequence.index for data in islice(stream("sim", short), 5)] == [0, 1, 2, 3, 4]
    shared = stream("sim", short, first=1, shard=1, shards=2)
    assert [data.sequence.index for data in islice(shared, 3)] == [2, 4, 6]
    assert sum(1 for _ in stream("demo", Options(limit=3))) == 3
    assert [d.sequence.index for d in stream("demo", Options(limit=3), stop=10, shard=1, shards=2)] == [1]


@pytest.mark.parametrize("shards", [1, 2, 3, 7])
def test_shards_share_the_stream_out(shards: int) -> None:
    got = [[d.sequence.index for d in stream("sim", OPTIONS, stop=10, shard=n, shards=shards)] for n in range(shards)]
    assert sorted(index for part in got for index in part) == list(range(10))


def test_a_stream_goes_on_where_it_stopped() -> None:
    whole = [data.sequence.observations for data in stream("sim", OPTIONS, stop=6)]
    rest = [data.sequence.observations for data in stream("sim", OPTIONS, first=4, stop=6)]
    for a, b in zip(whole[4:], rest, strict=True):
        np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("split", ["demo", "sim"])
def test_a_stride_leaves_out_what_generate_leaves_out(tmp_path: Path, split: str) -> None:
    options = Options(limit=9, stride=3, tier="noisy")
    written = generate(split, tmp_path / split, options)
    assert len(written) == 3
    made = [data.sequence.observations for data in stream(split, options, stop=3 if split == "sim" else None)]
    samples = GeneratedSamples(split, options)
    assert samples.size == (None if split == "sim" else 3)
    for number, sequence in enumerate(written.sequences()):
        np.testing.assert_array_equal(made[number], sequence.observations)
        np.testing.assert_array_equal(samples[number].boxes, np.nan_to_num(sequence.observations).astype(np.float32))
    assert len(made) == 3


@pytest.mark.parametrize(
    ("asked", "problem"),
    [
        ({"shard": 2, "shards": 2}, "shards are numbered from 0"),
        ({"shard": -1, "shards": 2}, "shards are numbered from 0"),
        ({"shards": 0}, "shards are numbered from 0"),
        ({"first": -1}, "begins at sequence 0 or later"),
    ],
)
def test_a_shard_or_sequence_that_there_is_not(asked: dict[str, int], problem: str) -> None:
    with pytest.raises(VbbenchError, match=problem):
        stream("sim", OPTIONS, **asked)


def test_without_torch_one_line_says_how_to_get_it() -> None:
    code = "import sys; sys.modules['torch'] = None\nimport vbbench.generation.datasets\nimport vbbench.training.torch"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 1
    assert done.stderr.strip().endswith("vbbench.training.torch needs torch: python -m pip install 'vbbench[torch]'")


@pytest.mark.slow
def test_the_plain_stream_does_not_import_torch() -> None:
    code = (
        "import sys\nfrom vbbench.generation.datasets import stream\nnext(stream())\nsys.exit('torch' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0
