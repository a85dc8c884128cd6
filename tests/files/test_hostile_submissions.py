"""Submissions made to harm or by mistake: faults on a line each, bounded memory, and no figure made of nonsense."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from tests.lib.answers import submit, submit_csv, true_answers
from tests.lib.make_dataset import Crowd, write_dataset
from vbbench.cli import main
from vbbench.errors import FileError, SubmissionError, VbbenchError
from vbbench.estimate import Estimate
from vbbench.files.dataset import Dataset
from vbbench.files.sequence_tables import RowBound, SequenceTable
from vbbench.files.submission import Faults, SubmissionInfo, read_info
from vbbench.protocol import get_protocol
from vbbench.scoring import score
from vbbench.scoring.answers import check_submission
from vbbench.solver import Problem
from vbbench.solving.runner import run_sequence


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("hostile")
    write_dataset(folder, Crowd(frames=24, people=9, seed=3))
    return folder


@pytest.fixture
def answers(dataset: Path) -> tuple[pd.DataFrame, pd.DataFrame]:
    return true_answers(dataset, 0.1)


def faults_of(folder: Path, dataset: Path) -> tuple[str, ...]:
    with pytest.raises(SubmissionError) as caught:
        score(folder, dataset)
    assert all("\n" not in fault for fault in caught.value.faults)
    with pytest.raises(SubmissionError):
        check_submission(folder, Dataset(dataset))
    return caught.value.faults


def with_poses(folder: Path, dataset: Path, answers: tuple, poses: pa.Table) -> Path:  # type: ignore[type-arg]
    submit(folder, dataset, answers)
    pq.write_table(poses, folder / "poses.parquet", row_group_size=40)
    return folder


@pytest.mark.parametrize("value", [1e308, -1.1e6, np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("column", ["x", "yaw"])
@pytest.mark.parametrize("write", [submit, submit_csv])
def test_absurd_answers_are_faults(dataset: Path, tmp_path: Path, answers, value, column, write) -> None:
    poses, positions = answers
    row = poses.index[poses.frame == 3][0]
    poses.loc[row, column] = value
    folder = write(tmp_path / "a", dataset, (poses, positions), failure_policy="hold")
    (fault,) = faults_of(folder, dataset)
    if write is submit_csv and np.isnan(value):
        assert f"{column} is ''" in fault  # as pandas writes it
    else:
        assert "must be finite numbers within ±1000000 m or rad" in fault
        assert f"sequence {poses.sequence[row]}, frame 3" in fault


def test_the_largest_answers_are_none(dataset: Path, tmp_path: Path, answers) -> None:
    poses, positions = answers
    poses[["x", "y", "yaw"]], positions[["x", "y"]] = 1e6, -1e6
    result = score(submit(tmp_path, dataset, (poses, positions)), dataset)
    assert all(np.isfinite(s.mean) for s in result.summaries.values())
    assert max(np.nanmax(figures) for figures in result.per_sequence.figures.values()) < 1e7


@pytest.mark.parametrize(
    ("value", "words"), [(1e308, "is 1e+308, beyond ±1000000 m or rad"), (np.nan, "is not finite")]
)
@pytest.mark.parametrize("what", ["pose", "position"])
def test_the_runner_refuses_them_and_names_the_place(dataset: Path, value: float, words: str, what: str) -> None:
    class Absurd:
        def solve(self, problem: Problem, observations, given) -> Estimate:
            poses, positions = np.zeros((len(observations), 3)), np.zeros((*observations.shape[:2], 2))
            (poses if what == "pose" else positions)[3:] = value
            return Estimate(poses=poses, positions=positions)

    opened = Dataset(dataset)
    sequence = opened.sequence(0)
    with pytest.raises(VbbenchError, match=f"sequence 0, frame [34]: the solver's {what}.* ") as caught:
        run_sequence(Absurd(), opened.problem(sequence), sequence, get_protocol("sequential"), None)
    assert words in str(caught.value)


def test_truth_that_is_no_number_is_refused(dataset: Path, tmp_path: Path, answers) -> None:
    copy = Path(shutil.copytree(dataset, tmp_path / "copy"))
    for name in ("truth/poses", "truth/scenes"):
        kept = (copy / f"{name}.parquet").read_bytes()
        table = pq.read_table(copy / f"{name}.parquet")
        place = table.column_names.index("x")
        pq.write_table(table.set_column(place, "x", pa.array(np.full(len(table), np.nan))), copy / f"{name}.parquet")
        facts = json.loads((copy / "dataset.json").read_text())
        facts.pop("digest", None)
        facts["tables"][name]["bytes"] = (copy / f"{name}.parquet").stat().st_size
        (copy / "dataset.json").write_text(json.dumps(facts))
        with pytest.raises(FileError, match="holds true values beyond"):
            score(submit(tmp_path / "a", dataset, answers), copy)
        (copy / f"{name}.parquet").write_bytes(kept)
        facts["tables"][name]["bytes"] = len(kept)
        (copy / "dataset.json").write_text(json.dumps(facts))


def nested_first(table: pa.Table) -> pa.Table:
    """The table with a nested column before ours, whose numbers are nobody's sequences."""
    odd = pa.StructArray.from_arrays([pa.array(np.full(len(table), n)) for n in (7, 8)], ["a", "b"])
    return table.add_column(0, "note", odd)


def test_a_nested_column_before_ours_changes_nothing(dataset: Path, tmp_path: Path, answers) -> None:
    want = score(submit(tmp_path / "plain", dataset, answers, failure_policy="hold"), dataset)
    folder = submit(tmp_path / "nested", dataset, answers, failure_policy="hold")
    for name in ("poses", "positions"):
        path = folder / f"{name}.parquet"
        pq.write_table(nested_first(pq.read_table(path)), path, row_group_size=50)
    assert score(folder, dataset).coverage == 1.0
    assert score(folder, dataset).to_json() == want.to_json()
    ours = SequenceTable(folder / "poses.parquet", "poses")  # by statistics, as tables of datasets are read
    assert len(ours.read(0, 100)["frame"]) == len(answers[0])


def test_statistics_that_lie_are_not_believed(dataset: Path, tmp_path: Path, answers) -> None:
    """The footer's least and greatest sequence of a row group are bytes that anybody can change."""
    want = score(submit(tmp_path / "plain", dataset, answers, failure_policy="hold"), dataset)
    poses = pa.Table.from_pandas(answers[0].astype({"sequence": "int32", "frame": "int32"}), preserve_index=False)
    folder = with_poses(tmp_path / "lie", dataset, answers, poses)
    facts = json.loads((folder / "submission.json").read_text())
    (folder / "submission.json").write_text(json.dumps({**facts, "failure_policy": "hold"}))
    path = folder / "poses.parquet"
    content = path.read_bytes()
    size = int.from_bytes(content[-8:-4], "little")
    footer = content[-8 - size : -8]
    group = pq.read_metadata(path).row_group(1).column(0).statistics
    told = int(group.max).to_bytes(4, "little")
    assert footer.count(told) >= 1
    lied = footer.replace(b"\x04" + told, b"\x04" + (99).to_bytes(4, "little"))
    assert lied != footer
    path.write_bytes(content[: -8 - size] + lied + content[-8:])
    stats = [pq.read_metadata(path).row_group(n).column(0).statistics for n in range(2)]
    assert 99 in {s.max for s in stats} | {s.min for s in stats}
    assert score(folder, dataset).to_json() == want.to_json()


def twice(table: pa.Table) -> pa.Table:
    return table.append_column("x", table.column("y"))


def as_struct(table: pa.Table) -> pa.Table:
    odd = pa.StructArray.from_arrays([table.column("x").combine_chunks()], ["x"])
    return table.set_column(table.column_names.index("x"), "x", odd)


def replaced(name: str, values: object) -> object:
    def change(table: pa.Table) -> pa.Table:
        column = values(len(table)) if callable(values) else values
        place = table.column_names.index(name) if name in table.column_names else len(table.column_names)
        table = table.drop_columns([name]) if name in table.column_names else table
        return table.add_column(place, name, column)

    return change


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        (replaced("sequence", lambda n: pa.array(np.full(n, 2**64 - 1, np.uint64))), "cannot be read"),
        (replaced("sequence", lambda n: pa.array(np.full(n, np.inf))), "cannot be read"),
        (replaced("sequence", lambda n: pa.array(np.full(n, -(2**63)))), "cannot be read"),
        (twice, "column x is there twice; keep one"),
        (as_struct, "column x holds no numbers"),
        (lambda t: t.append_column("x.y", t.column("y")), "column x is nested"),
        (replaced("fallback", lambda n: pa.array(np.full(n, np.nan))), "column fallback holds other numbers"),
        (replaced("fallback", lambda n: pa.array(np.full(n, -5e9))), "column fallback holds other numbers"),
        (replaced("fallback", lambda n: pa.array(["False"] * n)), "column fallback holds no numbers"),
    ],
)
def test_parquet_that_is_not_what_it_should_be(dataset: Path, tmp_path: Path, answers, change, fault: str) -> None:
    poses = pa.Table.from_pandas(answers[0], preserve_index=False)
    (found,) = faults_of(with_poses(tmp_path / "a", dataset, answers, change(poses)), dataset)
    assert found.startswith("poses.parquet: ")
    assert fault in found


def test_a_column_name_that_is_no_utf8_is_a_fault(dataset: Path, tmp_path: Path, answers) -> None:
    poses = pa.Table.from_pandas(answers[0].assign(noteone=1), preserve_index=False)
    folder = with_poses(tmp_path / "a", dataset, answers, poses.replace_schema_metadata())
    path = folder / "poses.parquet"
    path.write_bytes(path.read_bytes().replace(b"noteone", b"note\xff\xfee"))
    (fault,) = faults_of(folder, dataset)
    assert fault.startswith("poses.parquet: is damaged or no Parquet file")


def test_our_own_marks_saved_as_csv_by_pandas_are_read(dataset: Path, tmp_path: Path, answers) -> None:
    poses, positions = answers
    marked = (poses.assign(fallback=poses.frame % 2 == 0), positions)
    folder = submit(tmp_path / "ours", dataset, marked)
    want = score(folder, dataset)
    for name in ("poses", "positions"):
        pd.read_parquet(folder / f"{name}.parquet").to_csv(folder / f"{name}.csv", index=False)
        (folder / f"{name}.parquet").unlink()
    assert want.fallback_frames
    assert score(folder, dataset).to_json() == want.to_json()


NESTED = '{"solver": ' + "[" * 100_000 + "]" * 100_000 + "}"


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        (NESTED, "nested more than 64 levels deep"),
        ('{"solver": ' + "[" * 200 + "]" * 200 + "}", "nested more than 64 levels deep"),
        ('{"solver": "a", "solver": "b"}', "key 'solver' stands twice"),
        ('{"seconds_per_frame": 1' + 30 * "0" + "}", "give a number of seconds from 0 to 1000000"),
        ('{"seconds_per_frame": 1e400}', "give a number of seconds"),
        ('{"seconds_per_frame": 1' + 5000 * "0" + "}", "cannot be read"),
        ('{"solver": "a\\u001b[2Jb"}', r"is 'a\x1b[2Jb'; remove ends"),
        ('{"solver": "a\\nb"}', r"is 'a\nb'; remove ends"),
        ('{"solver": "\\ud800"}', "remove ends"),
        ('{"solver": "' + 20_000 * "a" + '"}', "has 20000 characters; write 1000 or fewer"),
        ('{"' + 20_000 * "k" + '": 1}', "… (20001 characters) is unknown"),
        ("{" + ",".join(f'"k{n}": 1' for n in range(99)) + "}", "(79 more)"),
    ],
)
def test_submission_json_that_is_not_what_it_should_be(tmp_path: Path, text: str, fault: str) -> None:
    (tmp_path / "submission.json").write_text(text)
    faults = Faults()
    read_info(tmp_path, faults)
    assert any(fault in line for line in faults.listing()), faults.listing()
    assert all(len(line) < 700 and line.isprintable() for line in faults.listing())
    with pytest.raises(SubmissionError):
        SubmissionInfo.read(tmp_path)


def test_no_control_character_reaches_the_terminal(
    dataset: Path, tmp_path: Path, answers, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = submit(tmp_path / "a\x1b[2J\nb", dataset, answers)
    (folder / "poses.parquet").unlink()
    assert main(["score", str(folder), "--dataset", str(dataset)]) == 2
    said = capsys.readouterr().err
    assert r"a\x1b[2J\nb: 1 fault" in said
    assert said.replace("\n", "").isprintable()


CHILD = """
import re, resource, sys
from pathlib import Path
resource.setrlimit(resource.RLIMIT_AS, (3 << 30, 3 << 30))
from vbbench.errors import SubmissionError
from vbbench.files.dataset import Dataset
from vbbench.scoring.answers import check_submission
try:
    check_submission(sys.argv[1], Dataset(sys.argv[2]))
except SubmissionError as error:
    print(error.faults[0])
most = re.search(r"VmHWM:[ \\t]*([0-9]+) kB", Path("/proc/self/status").read_text())  # not the parent's
print(int(most[1]) // 1024)
"""


@pytest.mark.parametrize("rows", [1_000_000, pytest.param(60_000_000, marks=pytest.mark.slow)])
def test_a_small_file_that_unpacks_to_very_much_takes_no_memory(dataset: Path, tmp_path: Path, answers, rows) -> None:
    folder = submit(tmp_path / "bomb", dataset, answers)
    zeros = pa.array(np.zeros(1 << 20, np.int8))
    table = pa.table(dict.fromkeys(("sequence", "frame", "x", "y", "yaw"), zeros))
    with pq.ParquetWriter(folder / "poses.parquet", table.schema, compression="zstd") as writer:
        for _ in range(-(-rows // len(table))):
            writer.write_table(table)
    assert (folder / "poses.parquet").stat().st_size < 2_000_000
    ran = subprocess.run([sys.executable, "-c", CHILD, folder, dataset], capture_output=True, text=True, check=True)
    fault, megabytes = ran.stdout.splitlines()
    assert "rows or more; the dataset has" in fault
    assert int(megabytes) < 600


def test_a_column_that_unpacks_to_too_much_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    names = ["sequence", "frame", "x", "y", "yaw"]
    table = pa.table({name: np.zeros(2000) for name in names})
    path = tmp_path / "poses.parquet"
    pq.write_table(table, path, use_dictionary=False, compression="zstd")
    monkeypatch.setattr("vbbench.files.sequence_tables.BYTES_A_VALUE", 1)
    monkeypatch.setattr("vbbench.files.sequence_tables.BYTES_A_COLUMN", 0)
    with pytest.raises(FileError, match="says that 2000 rows of a column"):
        SequenceTable(path, "poses", bound=RowBound(5000))
