"""An organiser and two teams, one of which cheats: played through the command line, from the first file to the end."""

import json
import re
import shutil
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.folders.test_locks import held
from tests.lib.challenges import FACTS, declared, memorised, on, run_lines, vbbench
from vbbench.scoring import score
from vbbench_leaderboards.challenge.organiser import Organiser, read_log
from vbbench_leaderboards.results.folder import read_results
from vbbench_leaderboards.results.ranking import headline

Refused = Callable[..., str]


def accept(room: Path, answer: str | Path, team: str = "honest", date: str = "2026-12-02") -> list[object]:
    return ["challenge", "accept", room / answer, "--challenge", room / "tiny", "--team", team, "--date", date]


def dx(room: Path, part: str) -> dict[str, float]:
    boards = read_results(room / "tiny" / "results" / part)
    found = {row.solver: headline(row, "dx").value for rows in boards.values() for row in rows}
    return {team: value for team, value in found.items() if value is not None}


@pytest.mark.slow
def test_the_whole_story(
    room: Path, tmp_path: Path, refused: Refused, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    tiny, organiser = room / "tiny", Organiser(room / "tiny")

    # The honest team gets the bundle, and runs what its README says, line by line.
    assert vbbench("challenge", "bundle", tiny, "--out", tmp_path / "away" / "tiny", "--archive") == 0
    monkeypatch.chdir(tmp_path / "away")
    shutil.rmtree(tmp_path / "away" / "tiny")
    run_lines([*organiser.challenge.unpacking_lines, *organiser.challenge.solving_lines])
    assert "ready for tiny" in capsys.readouterr().out
    honest = tmp_path / "away" / "tiny" / "mine" / "answer"
    assert json.loads((honest / "submission.json").read_text("utf-8"))["authors"] == "your name"
    declared(honest, authors="H. Onest")
    assert vbbench(*accept(room, honest)) == 0
    assert "6 of 12 sequences" in capsys.readouterr().out

    # The cheat has got hold of the truth of the public part, leads, and is shown to lead.
    cheat = memorised(tiny, room / "sf", room / "memorised")
    assert vbbench(*accept(room, cheat, "cheat", "2026-12-03")) == 0
    public = dx(room, "public")
    assert public["cheat"] < 1e-6 < public["honest"]

    # Whatever else it tries is refused, and written down.
    assert "handed in on 2026-12-02" in refused(*accept(room, honest, "cheat", "2026-12-03"))
    assert "takes no submissions" in refused(*accept(room, "sf", "cheat", "2027-01-15"))
    assert [entry.decision for entry in read_log(tiny)] == ["accepted", "accepted", "refused", "refused"]

    # No hidden figure exists before the end.
    assert vbbench(*accept(room, honest, "honest", "2027-02-01")) == 0
    assert vbbench(*accept(room, cheat, "cheat", "2027-02-07T23:59")) == 0
    assert "after its end" in capsys.readouterr().out
    with on("2027-02-07T23:59"):
        assert "when phase final has closed" in refused("challenge", "close", tiny)
    assert not (tiny / "results" / "hidden").exists()

    # At the end the hidden part decides: what was memorised is worth nothing there.
    with on("2027-02-08"):
        assert vbbench("challenge", "close", tiny) == 0
    assert capsys.readouterr().out.startswith("hidden part, 6 of 12 sequences")
    hidden = dx(room, "hidden")
    plain = score(room / "sf", tiny / "data", tiny / "data.truth", sequences=organiser.parts["hidden"])
    assert hidden["cheat"] == pytest.approx(plain.summaries["dx"].capped, rel=1e-5)
    assert hidden["honest"] < hidden["cheat"]


def test_a_part_is_scored_on_its_own_sequences_alone(room: Path) -> None:
    tiny, organiser = room / "tiny", Organiser(room / "tiny")
    parts, truth = organiser.parts, tiny / "data.truth"
    whole = score(room / "cv", tiny / "data", truth).per_sequence
    for part in ("public", "hidden"):
        own = score(room / "cv", tiny / "data", truth, sequences=parts[part])
        np.testing.assert_array_equal(own.per_sequence.sequence, parts[part])
        keep = np.isin(whole.sequence, parts[part])
        np.testing.assert_array_equal(own.per_sequence.figures["dx"], whole.figures["dx"][keep])
        assert own.summaries["dx"].mean == pytest.approx(whole.figures["dx"][keep].mean())
        assert own.frames == whole.frames[keep].sum()
    assert vbbench(*accept(room, "cv")) == 0
    results = tiny / "results" / "public"
    found = next(row for rows in read_results(results).values() for row in rows)
    np.testing.assert_array_equal(found.per_sequence.sequence, parts["public"])
    assert vbbench("leaderboard", "check", "--results", results) == 0


def spoilt(room: Path, table: str, row: int, column: str, value: float) -> Path:
    """The answer of cv with another value in a table."""
    path = room / "cv" / f"{table}.parquet"
    rows = pd.read_parquet(path)
    rows.iloc[row, rows.columns.get_loc(column)] = value
    path.unlink()
    rows.to_csv(path.with_suffix(".csv"), index=False)
    return room / "cv"


def linked(room: Path) -> Path:
    path = room / "cv" / "poses.parquet"
    path.unlink()
    path.symlink_to(room / "tiny" / "data.truth" / "poses.parquet")
    return room / "cv"


SUBMISSIONS: dict[str, tuple[Callable[[Path], Path], str]] = {
    "another dataset": (lambda room: declared(room / "cv", dataset="0" * 16), "answers dataset 0000000000000000; tiny"),
    "another protocol": (lambda room: declared(room / "cv", protocol="rollout"), "held under sequential"),
    "gaps allowed": (lambda room: declared(room / "cv", failure_policy="hold"), "wants every answer"),
    "nobody": (lambda room: declared(room / "cv", authors=""), "who made the solver"),
    "the template's": (lambda room: declared(room / "cv", authors="your name"), "name who made the solver"),
    "an unknown key": (lambda room: declared(room / "cv", score=0.0), "key 'score' is unknown"),
    "NaN": (lambda room: spoilt(room, "poses", 5, "x", np.nan), "1 fault"),
    "absurd": (lambda room: spoilt(room, "positions", 5, "y", 1e9), "must be finite numbers within"),
    "a row is missing": (lambda room: spoilt(room, "poses", -1, "frame", 0), "the row is missing; add it\n"),
    "a link to the truth": (linked, "is a link or cannot be read"),
    "no folder": (lambda room: room / "cv" / "poses.parquet", "is not a folder"),
}


@pytest.mark.parametrize("name", SUBMISSIONS)
def test_submissions_that_are_refused(room: Path, refused: Refused, name: str) -> None:
    make, words = SUBMISSIONS[name]
    answer = make(room)
    said = refused(*accept(room, answer))
    assert words in said
    assert "submissions/" not in said  # it is named as it was handed in
    assert not (room / "tiny" / "results").exists()
    assert not list((room / "tiny").glob("submissions/*"))
    [entry] = read_log(room / "tiny")
    assert (entry.decision, entry.phase) == ("refused", "development")
    assert entry.reason


def test_moments_and_teams_that_are_refused(room: Path, refused: Refused) -> None:
    assert "development opens on 2026-12-01" in refused(*accept(room, "cv", date="2026-11-30T23:59"))
    assert "final opens on 2027-02-01" in refused(*accept(room, "cv", date="2027-01-01"))
    assert "closed after 2027-02-07" in refused(*accept(room, "cv", date="2027-02-08"))
    assert "no team of tiny is called 'other'; known: honest, cheat" in refused(*accept(room, "cv", "other"))
    assert "write it as YYYY-MM-DD" in refused(*accept(room, "cv", date="yesterday"))


def test_limits_count_what_was_taken_in_a_phase(room: Path, refused: Refused) -> None:
    assert vbbench(*accept(room, "cv", date="2027-02-01")) == 0
    for number in range(3):
        answer = room / f"other-{number}"
        shutil.copytree(room / "sf", answer)
        rows = pd.read_parquet(answer / "poses.parquet")
        rows.loc[0, "x"] += number + 1
        rows.to_parquet(answer / "poses.parquet")
        asked = accept(room, answer, date="2027-02-02")
        if number == 0:
            assert vbbench(*asked) == 0
        else:
            assert "honest has used its 2 submissions of phase final" in refused(*asked)
    assert "is before the last submission of honest" in refused(*accept(room, "sf", date="2027-02-01"))
    assert [entry.decision for entry in read_log(room / "tiny")][-1] == "refused"
    assert vbbench(*accept(room, "sf", "cheat", "2027-02-01")) == 0  # a date of one team's does not count for others


def test_parts_stay_as_they_were_when_submissions_were_scored(
    room: Path, refused: Refused, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As when somebody writes another public_share, by which other sequences are public."""
    assert vbbench(*accept(room, "cv")) == 0
    others = {"public": Organiser(room / "tiny").parts["hidden"], "hidden": Organiser(room / "tiny").parts["public"]}
    with monkeypatch.context() as patch:
        patch.setattr("vbbench_leaderboards.challenge.organiser.parts_of", lambda *_: others)
        assert "public_share is another than when submissions were" in refused(*accept(room, "sf", "cheat"))
    assert vbbench(*accept(room, "sf", "cheat")) == 0


def test_what_is_handed_in_twice_counts_once(room: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for answer in ("cv", "cv", "sf", "cv"):
        assert vbbench(*accept(room, answer)) == 0
    said = capsys.readouterr().out.splitlines()
    assert sum("they count already, and nothing was added" in line for line in said) == 1
    assert "submission 3 of 3" in said[-3]  # the first again, after the second: it is to count
    assert len(read_log(room / "tiny")) == 3
    assert dx(room, "public")["honest"] == pytest.approx(float(re.findall(r"Δx ([0-9.]+)", said[-1])[0]), abs=1e-4)


def test_copies_are_found_in_whatever_form(room: Path, refused: Refused) -> None:
    assert vbbench(*accept(room, "cv")) == 0
    disguise = room / "disguise"
    disguise.mkdir()
    for name in ("poses", "positions"):
        rows = pd.read_parquet(room / "cv" / f"{name}.parquet").iloc[::-1]
        if name == "poses":  # and a row that nobody asks for
            rows = pd.concat([rows, rows[rows.sequence == 0].tail(1).assign(frame=0)])
        rows.to_csv(disguise / f"{name}.csv", index=False)
    shutil.copy(room / "cv" / "submission.json", disguise)
    declared(disguise, solver="mine")
    assert "are the answers that honest handed in" in refused(*accept(room, disguise, "cheat"))
    assert vbbench(*accept(room, "cv", date="2027-02-01")) == 0  # one's own counts in the next phase, too


def test_the_door_of_the_leaderboard_is_the_same(
    room: Path, refused: Refused, capsys: pytest.CaptureFixture[str]
) -> None:
    tiny = room / "tiny"
    add = ["leaderboard", "add", room / "cv", "--dataset", tiny / "data", "--truth", tiny / "data.truth"]
    add += ["--results", tiny / "results", "--name", "honest", *FACTS]
    assert "takes no submissions on 2027-01-10" in refused(*add, "--date", "2027-01-10")
    assert "is called 'mine'" in refused(*add[: -len(FACTS) - 1], "mine", *FACTS, "--date", "2026-12-02")
    assert vbbench(*add, "--date", "2026-12-02") == 0
    assert "taken from honest in phase development" in capsys.readouterr().out


def test_results_that_came_in_another_way_are_not_shown(
    room: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    tiny = room / "tiny"
    assert vbbench(*accept(room, "cv")) == 0
    assert vbbench(*accept(room, "sf", "cheat")) == 0
    board = tiny / "results" / "public" / "sim" / "sequential-noisy"
    lines = (tiny / "log.jsonl").read_text("utf-8").splitlines(keepends=True)
    (tiny / "log.jsonl").write_text(lines[0], encoding="utf-8")
    capsys.readouterr()
    build = ["leaderboard", "build", "--results", tiny / "results", "--out", tmp_path / "site"]
    with warnings.catch_warnings():
        warnings.simplefilter("always")
        assert vbbench(*build) == 0
        assert "cheat.json: no submission in the log accounts for it" in capsys.readouterr().err
        assert (tmp_path / "site" / "index.html").read_text("utf-8").count("2026-12-02, number") == 1
        shutil.copy(board / "honest.json", board / "cheat.json")
        assert vbbench(*build) == 0
        assert "belongs in sim/sequential-noisy/honest.json" in capsys.readouterr().err


def test_one_submission_at_a_time(room: Path, refused: Refused) -> None:
    with held(room / "tiny"):
        assert "is being written by" in refused(*accept(room, "cv"))
        assert "is being written by" in refused("challenge", "new", room / "tiny")
    assert not (room / "tiny" / "log.jsonl").exists()
    assert vbbench(*accept(room, "cv")) == 0


def test_a_changed_log_is_refused(room: Path, refused: Refused) -> None:
    for answer, team in (("cv", "honest"), ("sf", "cheat")):
        assert vbbench(*accept(room, answer, team)) == 0
    log = room / "tiny" / "log.jsonl"
    log.write_text(log.read_text("utf-8").replace('"honest"', '"cheat"', 1), encoding="utf-8")
    assert "log.jsonl, line 2: a line before this one was changed" in refused(*accept(room, "cv"))
    log.write_text("{\n", encoding="utf-8")
    assert "log.jsonl, line 1: is damaged" in refused(*accept(room, "cv"))


def test_what_is_kept_must_be_what_was_handed_in(room: Path, refused: Refused) -> None:
    assert vbbench(*accept(room, "cv", date="2027-02-01")) == 0
    [kept] = (room / "tiny" / "submissions").iterdir()
    shutil.copy(room / "sf" / "positions.parquet", kept)
    with on("2027-02-08"):
        assert "is not what was handed in" in refused("challenge", "close", room / "tiny")


def test_the_page_shows_what_may_be_known(room: Path, tmp_path: Path) -> None:
    tiny, site = room / "tiny", tmp_path / "site"
    for date in ("2026-12-02", "2027-02-01"):
        for answer, team in (("cv", "honest"), ("sf", "cheat")):
            assert vbbench(*accept(room, answer, team, date)) == 0
    with on("2027-02-08"):
        assert vbbench("challenge", "close", tiny) == 0
    build = ["leaderboard", "build", "--results", tiny / "results", "--out", site]
    with on("2027-02-03"):
        assert vbbench(*build) == 0
    page = (site / "index.html").read_text("utf-8")
    assert "Phase final is open, to the end of 2027-02-07" in page
    assert all(words in page for words in ("A tiny challenge", "honest", "M. Allory", "3 a team", "Be kind."))
    assert "vbbench generate sim --tier noisy --sequences 12 --options people=4:6 --seed 1 --out practice" in page
    assert "Hidden part" not in page
    assert sorted(path.name for path in site.iterdir()) == [".vbbench-site", "assets", "index.html"]
    with on("2027-02-08"):
        assert vbbench(*build) == 0
    assert "Hidden part" in (site / "index.html").read_text("utf-8")
    for part in ("public", "hidden"):
        assert (site / part / "index.html").is_file()
        assert "--dataset ../data --truth ../data.truth" in (site / part / "index.html").read_text("utf-8")


def test_the_baseline_stands_there_first(room: Path, refused: Refused, capsys: pytest.CaptureFixture[str]) -> None:
    path = room / "tiny" / "challenge.toml"
    path.write_text(path.read_text("utf-8").replace('baseline = ""', 'baseline = "cv"'), encoding="utf-8")
    assert "are the answers that baseline handed in on 2026-12-01" in refused(*accept(room, "cv"))
    assert vbbench(*accept(room, "sf")) == 0
    assert [(entry.team, entry.decision) for entry in read_log(room / "tiny")] == [
        ("baseline", "accepted"),
        ("honest", "refused"),
        ("honest", "accepted"),
    ]
    assert set(dx(room, "public")) == {"baseline", "honest"}
    path.write_text(path.read_text("utf-8").replace('"cheat"', '"Baseline"'), encoding="utf-8")
    assert "is that of vbbench's own row" in refused(*accept(room, "sf"))
