"""Submissions: written, read, refused with every fault named, and held together where rows are missing."""

import csv
import io
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from tests.cli.test_cli import run
from tests.lib.answers import submit, submit_csv, true_answers
from tests.lib.make_dataset import Crowd, write_dataset
from vbbench.cli import main
from vbbench.errors import FileError, SubmissionError, VbbenchError
from vbbench.estimate import Estimate
from vbbench.exchange.box_tables import read_box_text
from vbbench.exchange.tum import import_tum
from vbbench.files.dataset import Dataset
from vbbench.files.sequence_tables import RowBound, SequenceTable
from vbbench.files.submission import Faults, SubmissionInfo, SubmissionWriter, read_info
from vbbench.files.submission_tables import read_csv_rows
from vbbench.parsing.numbers import parse_number
from vbbench.protocol import get_protocol
from vbbench.scoring import score
from vbbench.scoring.answers import check_submission
from vbbench.scoring.scored_rows import scored_rows
from vbbench.solver import Problem
from vbbench.solving.runner import run_sequence


@pytest.fixture(scope="module")
def dataset(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("crowd")
    write_dataset(folder, Crowd(frames=24, people=9, seed=3))
    return folder


@pytest.fixture
def scored(dataset) -> pd.DataFrame:
    rows = list(scored_rows(Dataset(dataset), get_protocol("sequential")))
    columns = {name: np.concatenate([getattr(r, name) for r in rows]) for name in ("sequence", "frame", "track")}
    return pd.DataFrame(columns)


def faults_of(folder: Path, dataset: Path) -> tuple[str, ...]:
    with pytest.raises(SubmissionError) as caught:
        score(folder, dataset)
    assert all(fault in str(caught.value) for fault in caught.value.faults)
    assert all("\n" not in fault for fault in caught.value.faults)
    with pytest.raises(SubmissionError):
        check_submission(folder, Dataset(dataset))
    return caught.value.faults


def without(table: pd.DataFrame, **ids: int) -> pd.DataFrame:
    keep = np.zeros(len(table), dtype=bool)
    for name, value in ids.items():
        keep |= (table[name] != value).to_numpy()
    assert not keep.all()
    return table[keep]


def test_facts_round_trip(tmp_path):
    info = SubmissionInfo(solver="é", dataset="d", protocol="rollout", seconds_per_frame=0.5, failure_policy="hold")
    (tmp_path / "submission.json").write_text(info.to_json())
    assert SubmissionInfo.read(tmp_path) == info


def test_parquet_and_csv_score_the_same(dataset, tmp_path):
    tables = true_answers(dataset, 0.1)
    parquet = score(submit(tmp_path / "parquet", dataset, tables), dataset)
    by_hand = score(submit_csv(tmp_path / "csv", dataset, tables), dataset)
    assert by_hand.values()["metrics"] == parquet.values()["metrics"]
    assert by_hand.info.solver == "by hand"


def test_strangers_habits_are_fine(dataset, tmp_path):
    """Rows and columns in any order, more columns, spaces, blank lines, a byte order mark, whole numbers as 3.0."""
    poses, positions = true_answers(dataset, 0.1)
    poses = poses.sample(frac=1, random_state=0)[["yaw", "y", "x", "frame", "sequence"]].assign(note="a")
    folder = submit_csv(tmp_path / "csv", dataset, (poses, positions.astype({"frame": float})))
    path = folder / "poses.csv"
    path.write_text("\ufeff" + path.read_text().replace(",", ", ") + "\n\n", encoding="utf-8")
    want = score(submit(tmp_path / "parquet", dataset, true_answers(dataset, 0.1)), dataset)
    assert score(folder, dataset).values()["metrics"] == want.values()["metrics"]


def test_parquet_of_a_stranger_in_one_piece_and_unsorted(dataset, tmp_path):
    tables = true_answers(dataset, 0.1)
    want = score(submit(tmp_path, dataset, tables), dataset).to_json()
    for name, table in zip(("poses", "positions"), tables, strict=True):
        shuffled = table.sample(frac=1, random_state=1)[list(table)[::-1]].astype({"sequence": "int64"})
        shuffled.to_parquet(tmp_path / f"{name}.parquet", index=False)
    assert score(tmp_path, dataset).to_json() == want


def test_twenty_faults_are_all_listed(dataset, tmp_path):
    poses, positions = true_answers(dataset)
    folder = submit_csv(tmp_path / "csv", dataset, (poses, positions))
    (folder / "submission.json").write_text(
        json.dumps(
            {
                "dataset": "0000000000000000",  # 1 another dataset
                "protocol": "two-step",  # 2 unknown
                "seconds_per_frame": -1,  # 3 negative
                "failure_policy": "drop",  # 4 unknown
                "hardware": 7,  # 5 no text
                "speed": 3,  # 6 unknown key; 7 no solver
            }
        )
    )
    lines = (folder / "poses.csv").read_text().splitlines()
    lines[3:] = [line for line in lines[3:] if not line.startswith("17,4,")]  # 8 missing
    longest = [line for line in lines if line.startswith("0,")]
    lines += [
        longest[2],  # 9 given twice
        "99,0,0,0,0",  # 10 no such sequence
        "0,999,0,0,0",  # 11 no such frame
        "0,1,zero,0,0",  # 12 text
        "0,x,0,0,0",  # 13 text for an id
        "0,1,0,0",  # 14 a cell too few
        "0,1.5,0,0,0",  # 15 not whole
    ]
    (folder / "poses.csv").write_text("\n".join(lines) + "\n")
    held = positions[(positions.sequence != 17) | (positions.frame != 5)]  # 16 missing
    held = pd.concat([held, held[held.frame == 2].head(1)])  # 17 given twice
    held.loc[held.frame == held.frame.max(), "x"] = np.inf  # 18 not finite
    extra = pd.DataFrame({"sequence": [-4, 0], "frame": [0, 2], "track": [0, 777], "x": 0.0, "y": 0.0})
    held = pd.concat([held, extra])  # 19 no such sequence, 20 no such track
    held.to_csv(folder / "positions.csv", index=False)
    faults = faults_of(folder, dataset)
    wanted = [
        "made for dataset '0000000000000000'",
        "'protocol' is 'two-step'",
        "'seconds_per_frame' is -1",
        "'failure_policy' is 'drop'",
        "'hardware' is 7",
        "key 'speed' is unknown",
        "key 'solver' is missing",
        "poses.csv, sequence 17, frame 4: the row is missing",
        "poses.csv, line 4, sequence 0, frame 2: is given again",
        "poses.csv, line {}, sequence 99, frame 0: the dataset has sequences 0 to 17",
        "poses.csv, line {}, sequence 0, frame 999: its sequence has no such frame",
        "poses.csv, line {}: x is 'zero'",
        "poses.csv, line {}: frame is 'x'",
        "poses.csv, line {}: 4 cells, the header has 5",
        "poses.csv, line {}: frame is '1.5'",
        "positions.csv, sequence 17, frame 5, track",
        "frame 2, track",
        "x, y must be finite numbers",
        "sequence -4, frame 0, track 0: the dataset has sequences 0 to 17",
        "sequence 0, frame 2, track 777: its sequence never sees such a track",
    ]
    number = iter(range(len(lines) - 5, len(lines) + 1))
    wanted = [text.format(next(number)) if "{}" in text else text for text in wanted]
    assert [text for text in wanted if not any(text in fault for fault in faults)] == []
    assert [fault for fault in faults if fault.startswith("positions.csv") and "is given again" in fault]
    assert len(faults) >= 20


def test_an_empty_folder_lacks_three_files(dataset, tmp_path):
    assert len(faults_of(tmp_path, dataset)) == 3


def test_files_that_are_no_tables(dataset, tmp_path):
    folder = submit(tmp_path, dataset, true_answers(dataset))
    (folder / "poses.parquet").write_bytes(b"nothing")
    (folder / "positions.parquet").unlink()
    (folder / "positions.csv").write_text("sequence;frame\n1;2\n")
    faults = faults_of(folder, dataset)
    assert faults[0].startswith("poses.parquet: is damaged or no Parquet file")
    assert [fault.split(";")[0] for fault in faults[1:]] == [
        f"positions.csv, line 1: column '{name}' is missing" for name in ("sequence", "frame", "track", "x", "y")
    ]


def test_parquet_beside_csv_is_ambiguous(dataset, tmp_path):
    folder = submit(tmp_path, dataset, true_answers(dataset))
    (folder / "poses.csv").write_text("sequence,frame,x,y,yaw\n")
    assert faults_of(folder, dataset) == ("poses.csv: stands next to poses.parquet; remove one of them",)


def test_many_faults_of_one_kind_are_counted(dataset, tmp_path, scored):
    poses, positions = true_answers(dataset)
    faults = faults_of(submit(tmp_path, dataset, (poses, positions.head(0))), dataset)
    assert len(faults) == 21
    assert faults[-1].endswith(f"({len(scored) - 20} more)")


def test_missing_rows_are_refused_and_named(dataset, tmp_path, scored):
    poses, positions = true_answers(dataset)
    row = scored.iloc[5].to_dict()
    faults = faults_of(submit(tmp_path, dataset, (poses, without(positions, **row))), dataset)
    place = "positions.parquet, sequence {sequence}, frame {frame}, track {track}: the row is missing".format(**row)
    assert len(faults) == 1
    assert faults[0].startswith(place)


def test_a_check_counts_what_is_there_and_says_what_is_held(dataset, scored, tmp_path, capsys):
    poses, positions = true_answers(dataset)
    wanted = sum(len(rows.pose_sequence) for rows in scored_rows(Dataset(dataset), get_protocol("sequential")))
    whole = submit(tmp_path / "whole", dataset, (poses, positions))
    status, out, _ = run(capsys, "check", whole, "--dataset", dataset)
    assert status == 0
    assert f"{wanted} of {wanted} poses and {len(scored)} of {len(scored)} positions that must be answered" in out
    held = submit(tmp_path / "held", dataset, (poses.tail(3), positions), failure_policy="hold")
    status, out, _ = run(capsys, "check", held, "--dataset", dataset)
    assert status == 0
    assert f"3 of {wanted} poses" in out
    assert "missing rows: hold" in out
    assert "counts as the last one known" in out


def test_validation_does_not_need_truth(dataset, tmp_path):
    public = tmp_path / "public"
    shutil.copytree(dataset, public)
    shutil.rmtree(public / "truth")
    poses, positions = true_answers(dataset)
    good = submit(tmp_path / "good", dataset, (poses, positions))
    bad = submit(tmp_path / "bad", dataset, (poses.head(3), positions))
    assert check_submission(good, Dataset(public)).info.solver == "test"
    with pytest.raises(SubmissionError):
        check_submission(bad, Dataset(public))
    with pytest.raises(VbbenchError, match=r"the truth of .* is not available"):
        score(good, public)
    with pytest.raises(SubmissionError):
        score(bad, public)


def test_held_position_is_the_last_known(dataset, tmp_path, scored):
    poses, positions = true_answers(dataset)
    row = scored.iloc[5].to_dict()
    result = score(submit(tmp_path, dataset, (poses, without(positions, **row)), failure_policy="hold"), dataset)
    own = positions[(positions.sequence == row["sequence"]) & (positions.track == row["track"])].set_index("frame")
    last = own.loc[: row["frame"] - 1].iloc[-1]
    error = np.hypot(*(own.loc[row["frame"], ["x", "y"]] - last[["x", "y"]]))
    in_sequence = (scored.sequence == row["sequence"]).sum()
    place = list(result.per_sequence.sequence).index(row["sequence"])
    assert result.per_sequence.figures["dx"][place] == pytest.approx(error / in_sequence)
    assert result.per_sequence.coverage[place] == pytest.approx(1 - 1 / in_sequence)
    assert result.coverage == pytest.approx(1 - 1 / len(scored))
    assert result.values()["failure_policy"] == "hold"


def test_an_empty_submission_that_holds_stays_where_it_was_given(dataset, tmp_path):
    """Rollout, nothing submitted: the observer stands still, late arrivals stand where the observer does."""
    poses, positions = true_answers(dataset)
    folder = submit(tmp_path, dataset, (poses, positions), protocol="rollout", failure_policy="hold")
    for name in ("poses", "positions"):
        pd.read_parquet(folder / f"{name}.parquet").head(0).to_csv(folder / f"{name}.csv", index=False)
        (folder / f"{name}.parquet").unlink()
    result = score(folder, dataset)
    assert result.coverage == 0.0
    for place, index in enumerate(result.per_sequence.sequence):
        want = _standing_still(Dataset(dataset), int(index))
        assert result.per_sequence.figures["dx"][place] == pytest.approx(want, nan_ok=True)


def _standing_still(dataset: Dataset, index: int) -> float:
    sequence = dataset.sequence(index)
    truth = dataset.truth(sequence)
    held = truth.poses[1, :2]
    errors = []
    for k in range(len(sequence.tracks)):
        seen = np.flatnonzero(sequence.observed[:, k])
        early = seen[seen < 2]
        place = truth.positions[early[-1], k] if len(early) else held
        errors += [float(np.hypot(*(truth.positions[t, k] - place))) for t in seen if t >= 2]
    return float(np.mean(errors)) if errors else float("nan")


def test_held_pose_is_the_last_known(dataset, tmp_path):
    poses, positions = true_answers(dataset)
    gone = (poses.sequence == 0) & (poses.frame >= 3)
    folder = submit(tmp_path, dataset, (poses[~gone], positions), failure_policy="hold")
    result = score(folder, dataset)
    own = poses[poses.sequence == 0].set_index("frame")[["x", "y"]]
    seen = Dataset(dataset).sequence(0).observed.any(axis=1)
    frames = [t for t in own.index if t >= 2 and seen[t]]
    errors = [float(np.hypot(*(own.loc[t] - own.loc[min(t, 2)]))) for t in frames]
    assert result.per_sequence.figures["dt"][0] == pytest.approx(np.mean(errors))


def test_a_submission_that_was_not_finished_is_none(dataset, tmp_path):
    info = SubmissionInfo(solver="a", dataset="d", protocol="rollout")
    with pytest.raises(KeyError), SubmissionWriter(tmp_path / "out", info) as writer:
        writer.add(0, {"frame": [2], "x": [0.0], "y": [0.0], "yaw": [0.0]}, {"frame": []})
    assert not (tmp_path / "out").exists()


def _changed(tables, yaw=lambda yaw: yaw, place=lambda x, y: (x, y)):
    """The answers with yaw and places changed."""
    poses, people = ({"x": new[0], "y": new[1]} for new in (place(table.x, table.y) for table in tables))
    return tables[0].assign(yaw=yaw(tables[0].yaw), **poses), tables[1].assign(**people)


MISREAD = {
    "degrees": ({"yaw": np.degrees}, "yaw seems to be in degrees: .*; write rad"),
    "degrees from 0 to 360": ({"yaw": lambda yaw: np.degrees(yaw) % 360.0}, "yaw seems to be in degrees"),
    "θ": ({"yaw": lambda yaw: np.pi / 2 - yaw}, "the paper's θ_z: .*; write yaw, which is π/2"),
    "clockwise": ({"yaw": lambda yaw: -yaw}, "yaw seems to be clockwise: .*; write it counterclockwise"),
    "from y": ({"yaw": lambda yaw: yaw - np.pi / 2}, "yaw seems to be counted from y: .*; write it from x"),
    "feet": ({"place": lambda x, y: (x / 0.3048, y / 0.3048)}, "place of poses seems to be in feet: .*; write m"),
    "mirrored": ({"place": lambda x, y: (x, -y)}, "place of people seems to be left-handed: .*; write −y in place"),
    "cm": ({"place": lambda x, y: (100 * x, 100 * y)}, "place of people seems to be in cm: .*; write m"),
    "swapped": ({"place": lambda x, y: (y, x)}, "place of poses seems to be y before x"),
}


@pytest.mark.parametrize("what", MISREAD)
def test_answers_in_other_units_are_a_fault(dataset, tmp_path, what):
    """By the truth, or by what is given in the first frames where there is none."""
    change, problem = MISREAD[what]
    folder = submit(tmp_path / "s", dataset, _changed(true_answers(dataset, noise=0.1), **change))
    with pytest.raises(SubmissionError, match=problem):
        score(folder, dataset)
    with pytest.raises(SubmissionError, match=problem):
        check_submission(folder, Dataset(dataset))


@pytest.mark.parametrize("noise", [0.0, 0.5, 30.0])
@pytest.mark.parametrize("turns", [0, 1, 5, -40])
def test_unrolled_yaw_and_poor_answers_are_legal(dataset, tmp_path, turns, noise):
    """Whole turns make no difference, however many, and answers may be anywhere."""
    tables = true_answers(dataset, noise=noise)
    folder = submit(tmp_path / "s", dataset, _changed(tables, yaw=lambda yaw: yaw + 2 * np.pi * turns))
    assert score(folder, dataset).frames > 0
    assert check_submission(folder, Dataset(dataset)).posed > 0


WANTED = ["sequence", "frame", "x"]
BOUND = RowBound(1000)
NO_NUMBERS = ["0_2", "1_000.5", "0x10", "0X1F", "infinity", "-Infinity", "１", "٣", "1e", "1 0", "--1", "1f", "nan(1)"]
NO_IDS = ["-9223372036854775808", "18446744073709551615", "2147483648", "1.5", "nan", "inf", "1e400", "9" * 400]


def read(path: Path, text: str, optional: tuple[str, ...] = ("fallback",)) -> tuple[Any, tuple[str, ...]]:
    path.write_bytes(text.encode("utf-8", "surrogateescape"))
    faults = Faults()
    rows = read_csv_rows(path, WANTED, faults, optional, BOUND)
    return rows, faults.listing()


def one(tmp_path: Path, **cells: str) -> tuple[Any, tuple[str, ...]]:
    """What is read of a file of one row with these cells."""
    row = {"sequence": "0", "frame": "2", "x": "1.0", **cells}
    return read(tmp_path / "poses.csv", ",".join(row) + "\n" + ",".join(row.values()) + "\n")


@pytest.mark.parametrize("text", NO_NUMBERS)
def test_what_is_no_number_is_none_in_csv_mot_and_tum(tmp_path: Path, text: str) -> None:
    assert parse_number(text) is None
    assert "x is " in one(tmp_path, x=text)[1][0]
    assert "sequence is " in one(tmp_path, sequence=text)[1][0]
    with pytest.raises(FileError, match=r"left is .*; write a number"):
        read_box_text(tmp_path / "a.txt", f"1,1,{text},1,1,1\n2,1,1,1,1,1,1,1\n".encode())
    with pytest.raises(FileError, match=r"left is .*; write a number"):
        read_box_text(tmp_path / "a.txt", f"1,1,{text},1,1,1\n".encode())
    if " " not in text:
        (tmp_path / "t.txt").write_text(f"0 {text} 0 0 0 0 0 1\n", encoding="utf-8")
        with pytest.raises(FileError, match=r"tx is .*; write a number"):
            import_tum(tmp_path / "t.txt", 0.4)


@pytest.mark.parametrize("text", NO_IDS)
def test_what_is_no_id_is_a_fault(tmp_path: Path, text: str) -> None:
    rows, faults = one(tmp_path, sequence=text)
    assert len(rows["sequence"]) == 0
    assert len(faults) == 1
    assert "write a whole number" in faults[0]


@pytest.mark.parametrize(
    ("text", "value"), [("True", True), ("False", False), ("1", True), ("0", False), ("true", True)]
)
def test_marks_are_true_and_false(tmp_path: Path, text: str, value: bool) -> None:
    rows, faults = one(tmp_path, fallback=text)
    assert faults == ()
    assert rows["fallback"].tolist() == [value]
    rows, faults = one(tmp_path, fallback=f" {text} ")
    assert (rows["fallback"].tolist(), faults) == ([value], ())


@pytest.mark.parametrize("text", ["nan", "-5e9", "2", "yes", "", "None", "1.0"])
def test_marks_are_nothing_else(tmp_path: Path, text: str) -> None:
    assert f"fallback is '{text}'; write True or False" in one(tmp_path, fallback=text)[1][0]


def test_a_column_that_stands_twice_is_refused(tmp_path: Path) -> None:
    rows, faults = read(tmp_path / "poses.csv", "sequence,frame,x,x\n0,2,1,5\n")
    assert rows is None
    assert faults == ("poses.csv, line 1: column 'x' is there twice; keep one",)
    rows, faults = read(tmp_path / "poses.csv", "sequence,frame,x,note,note\n0,2,1,a,b\n")
    assert (rows["x"].tolist(), faults) == ([1.0], ())


def test_a_cell_too_long_and_bytes_that_are_no_text_are_faults_with_their_line(tmp_path: Path) -> None:
    path = tmp_path / "poses.csv"
    good = "sequence,frame,x\n" + "0,2,1\n" * 3000
    with pytest.raises(FileError, match=r"poses.csv, line 3002: has more than 131072 characters"):
        read(path, good + "0,2," + "1" * 140_000 + "\n")
    with pytest.raises(FileError, match=r"line \d+: cannot be read further \(field larger"):
        read(path, good.replace("x\n", "x,note\n").replace(",1\n", ",1,a\n") + '0,2,1,"' + "a\n" * 80_000 + '"\n')
    rows, faults = read(path, good + "0,3,\udcff\n")
    assert len(rows["x"]) == 3001
    assert faults == (r"poses.csv, line 3002: x is '\udcff'; write a number",)
    with pytest.raises(FileError, match="is not UTF-8 text"):
        read(path, "\udcffsequence,frame,x\n0,2,1\n")


def test_more_rows_than_there_can_be_are_not_read(tmp_path: Path) -> None:
    for end in ("", '0,2,"1"\n'):  # with a quotation mark it is read by the other way
        with pytest.raises(FileError, match="the dataset has 1000 at most"):
            read(tmp_path / "poses.csv", "sequence,frame,x\n" + "0,2,1\n" * (BOUND.most + 1) + end)


def test_what_strangers_wrote_is_escaped_and_cut(tmp_path: Path) -> None:
    _, faults = one(tmp_path, x="\x1b[2J\x1b]0;owned\x07")
    assert r"x is '\x1b[2J\x1b]0;owned\x07'; write a number" in faults[0]
    _, faults = one(tmp_path, x="a" * 20_000)
    assert len(faults[0]) < 200
    assert faults[0].endswith("… (20001 characters); write a number")


NUMBER = re.compile(r"[ \t]*[+-]?([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]+)?[ \t]*\Z", re.ASCII)


def expected(text: str) -> tuple[list[tuple[int, int, float]], int] | None:
    """Rows and the number of bad cells by the csv module and `NUMBER`; ``None`` where the module cannot read it."""
    try:
        rows = [row for row in csv.reader(io.StringIO(text, newline=""), strict=True) if any(c.strip() for c in row)]
    except csv.Error:
        return None
    header, good, bad = [cell.strip() for cell in rows[0]], [], 0
    for row in rows[1:]:
        if len(row) != len(header):
            bad += 1
            continue
        cells = dict(zip(header, row, strict=True))
        values = [_value(cells[name], whole=name != "x") for name in WANTED]
        bad += sum(value is None for value in values)
        if values[0] is not None and values[1] is not None:
            good.append((int(values[0]), int(values[1]), values[2] or 0.0))
    return good, bad


def _value(cell: str, *, whole: bool) -> float | None:
    if not whole and re.fullmatch(r"[ \t]*[+-]?(nan|inf)[ \t]*", cell, re.IGNORECASE | re.ASCII):
        return float(cell)
    if not NUMBER.match(cell):
        return None
    value = float(cell)
    if whole and not (value.is_integer() and abs(value) < 2**31):
        return None
    return value


cells = st.one_of(
    st.integers(-3, 2**31 + 1).map(str),
    st.floats(allow_nan=True, allow_infinity=True).map(repr),
    st.sampled_from(
        [*NO_NUMBERS, *NO_IDS, "", " 7 ", "3.0", "+1", ".5", "5.", '"2"', '" 2"', '"1,5"', '"a\nb"', '"', 'a"b']
    ),
    st.text(st.characters(codec="utf-8"), max_size=4),
)
rows = st.lists(st.lists(cells, min_size=2, max_size=5).map(",".join), max_size=6)
good = st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9), st.floats(-9, 9)).map(lambda r: ",".join(map(str, r))))


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.one_of(rows, good), st.sampled_from(["\n", "\r\n"]), st.booleans(), st.booleans())
@example(["0,1,2", "", "1,1,3"], "\n", True, True)
@example(["0,1,0x10", "0x1,1,3"], "\n", False, True)
@example(['0,1,1,"a', '0,2,3,b"'], "\n", True, True)
def test_it_is_read_as_an_independent_reader_reads_it(
    tmp_path: Path, body: list[str], end: str, note: bool, last: bool
) -> None:
    text = end.join(["sequence,frame,x" + (",note" if note else ""), *body]) + (end if last else "")
    want = expected(text)
    if want is None:
        with pytest.raises(FileError):
            read(tmp_path / "poses.csv", text)
        return
    found, faults = read(tmp_path / "poses.csv", text)
    np.testing.assert_array_equal(np.stack([found[name] for name in WANTED], axis=-1), np.reshape(want[0], (-1, 3)))
    assert len(faults) == want[1]
    assert all("\n" not in fault for fault in faults)


@pytest.fixture
def answers(dataset: Path) -> tuple[pd.DataFrame, pd.DataFrame]:
    return true_answers(dataset, 0.1)


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


@pytest.mark.parametrize("name", ["truth/poses", "truth/scenes"])
def test_truth_that_is_no_number_is_refused(dataset: Path, tmp_path: Path, answers, name: str) -> None:
    copy = Path(shutil.copytree(dataset, tmp_path / "copy"))
    path = copy / f"{name}.parquet"
    table = pq.read_table(path)
    place = table.column_names.index("x")
    pq.write_table(table.set_column(place, "x", pa.array(np.full(len(table), np.nan))), path)
    facts = json.loads((copy / "dataset.json").read_text())
    facts.pop("digest", None)
    facts["tables"][name]["bytes"] = path.stat().st_size
    (copy / "dataset.json").write_text(json.dumps(facts))
    with pytest.raises(FileError, match="holds true values beyond"):
        score(submit(tmp_path / "a", dataset, answers), copy)


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
        (lambda t: t.drop_columns(["y"]), "column y is missing"),
        (replaced("sequence", lambda n: pa.array(["0"] * n)), "column sequence holds no numbers"),
        (replaced("frame", lambda n: pa.array(np.full(n, 2.5))), "cannot be read"),
        (replaced("x", lambda n: pa.array([None, *np.zeros(n - 1)])), "column x has empty cells"),
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


NESTED = '{"solver": ' + "[" * 100_000 + "]" * 100_000 + "}"


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("{", "fix the JSON"),
        ("[]", "holds no object"),
        ("{}", "key 'dataset' is missing"),
        ('{"solver": ""}', "key 'solver' is empty"),
        ('{"dataset": 5}', "key 'dataset' is 5; give text"),
        ('{"seconds_per_frame": NaN}', "give a number of seconds"),
        ('{"seconds_per_frame": true}', "give a number of seconds"),
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
