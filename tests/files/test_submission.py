"""Submissions: written, read, refused with every fault named, and held together where rows are missing."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.cli.test_cli import run
from tests.lib.answers import submit, submit_csv, true_answers
from tests.lib.make_dataset import Crowd, write_dataset
from vbbench.errors import SubmissionError, VbbenchError
from vbbench.files.dataset import Dataset
from vbbench.files.submission import SubmissionInfo, SubmissionWriter
from vbbench.protocol import get_protocol
from vbbench.scoring import score
from vbbench.scoring.answers import check_submission
from vbbench.scoring.scored_rows import scored_rows


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


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("{", "fix the JSON"),
        ("[]", "holds no object"),
        ("{}", "key 'dataset' is missing"),
        ('{"solver": "", "dataset": "d", "protocol": "rollout"}', "key 'solver' is empty"),
        ('{"solver": "a", "dataset": 5, "protocol": "rollout"}', "key 'dataset' is 5; give text"),
        ('{"solver": "a", "dataset": "d", "protocol": "rollout", "seconds_per_frame": NaN}', "seconds_per_frame"),
        ('{"solver": "a", "dataset": "d", "protocol": "rollout", "seconds_per_frame": true}', "seconds_per_frame"),
    ],
)
def test_unusable_facts(tmp_path, text, fault):
    (tmp_path / "submission.json").write_text(text)
    with pytest.raises(SubmissionError, match=fault):
        SubmissionInfo.read(tmp_path)


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


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        (lambda t: t.drop(columns="y"), "column y is missing"),
        (lambda t: t.astype({"sequence": str}), "column sequence holds no numbers"),
        (lambda t: t.assign(frame=t.frame + 0.5), "cannot be read"),
        (lambda t: t.assign(x=t.x.where(t.frame > 3, None)), "column x has empty cells"),
    ],
)
def test_parquet_columns_of_the_wrong_kind(dataset, tmp_path, change, fault):
    poses, positions = true_answers(dataset)
    folder = submit(tmp_path, dataset, (poses, positions))
    change(poses).to_parquet(folder / "poses.parquet", index=False)
    (found,) = faults_of(folder, dataset)
    assert found.startswith("poses.parquet: ")
    assert fault in found


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


def test_a_check_lists_faults_and_ends_with_2(dataset, tmp_path, capsys):
    poses, positions = true_answers(dataset)
    bad = submit(tmp_path / "bad", dataset, (poses.iloc[:-1], positions))
    status, out, errors = run(capsys, "check", bad, "--dataset", dataset)
    assert (status, out) == (2, "")
    assert "the row is missing; add it" in errors


def test_validation_does_not_need_truth(dataset, tmp_path):
    import shutil

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
    assert check_submission(folder, Dataset(dataset)).poses.there > 0
