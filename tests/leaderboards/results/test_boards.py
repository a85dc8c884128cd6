"""Rows that were trained or tuned on recordings of their board are found by what they declare, and ranked apart."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from release.facts import outdated
from tests.lib.board_results import ABOUT, record_of, result
from vbbench.camera import PanoramaCamera, camera_to_dict
from vbbench_leaderboards.results.boards import seen_by
from vbbench_leaderboards.results.folder import published_results, read_datasets, read_results
from vbbench_leaderboards.results.ranking import rank_apart
from vbbench_leaderboards.results.result import Board, write_result
from vbbench_leaderboards.site.export import ExportedBoard

ERRORS = np.linspace(0.1, 0.9, 40)


NAMED = {
    "kitti": ("KITTI", "kitti and 12 drives of ours"),
    "hotel": ("Hotel, ETH, Students", "BIWI Walking Pedestrians", "ETH/UCY"),
    "eth": ("biwi_eth.txt", "eth-15fps"),
    "eth-15fps": ("Hotel and ETH",),
    "students": ("UCY",),
    "students-resampled": ("students003",),
    "zara01": ("Zara 1",),
    "jrdb": ("the training part of JRDB",),
    "crossing": ("Crossing",),
    "argoverse2": ("Argoverse 2", "Hotel, and argoverse2 val"),
    "nuscenes": ("nuScenes and 2 logs of Argoverse 2",),
}
"""Split → facts that name a recording of its boards."""
OTHERS = {
    "kitti": ("nothing", "Hotel, ETH, Students", "a kittiwake"),
    "hotel": ("ETH", "simulated crowds of vbbench alone; no recording"),
    "eth": ("a method of ethics",),
    "sim": ("sim, 74,000 crowds",),
    "own": ("our own recordings",),
    "argoverse2": ("2 logs of Argoverse 2, 4 scenes of nuScenes", "Argoverse 2 training logs"),
    "nuscenes": ("JRDB, 2 logs of Argoverse 2, 4 scenes of nuScenes", "nuScenes (train)"),
}
"""Split → facts that name none."""
FACTS = [(split, fact, facts is NAMED) for facts in (NAMED, OTHERS) for split in facts for fact in facts[split]]


@pytest.mark.parametrize(("split", "fact", "seen"), FACTS)
def test_a_fact_that_names_a_recording_of_the_board_is_found(split: str, fact: str, seen: bool) -> None:
    assert bool(seen_by(replace(ABOUT, tuned_on=fact), split)) == seen


def test_both_facts_count() -> None:
    about = replace(ABOUT, trained_on="Hotel", tuned_on="Hotel, ETH")
    assert seen_by(about, "hotel") == "trained and tuned"
    assert seen_by(about, "eth") == "tuned"
    assert seen_by(replace(ABOUT, trained_on="Hotel"), "hotel") == "trained"


def test_a_third_partys_row_is_ranked_apart_and_says_why(tmp_path: Path) -> None:
    board = Board(split="kitti", tier="footage", protocol="sequential")
    rows = [
        result("untuned", ERRORS + 0.2, board=board),
        result("worse", ERRORS + 0.9, board=board),
        result("theirs", ERRORS, board=board, tuned_on="KITTI 0019"),
        result("ahead", ERRORS / 9, board=board, tuned_on="KITTI", delay="offline"),
    ]
    kept = record_of(*rows, camera=camera_to_dict(PanoramaCamera()))
    for row in rows:
        write_result(row, tmp_path, kept)
    read = read_results(tmp_path)[board]
    assert {row.solver: row.seen for row in read} == {"untuned": "", "worse": "", "theirs": "tuned", "ahead": "tuned"}
    ranking = rank_apart(read)["dx"]
    assert {name: place.rank for name, place in ranking.places.items()} == {
        "untuned": 1,
        "worse": 2,
        "theirs": 1,
        "ahead": 1,
    }
    assert [(pair.a, pair.b) for pair in ranking.pairs] == [("untuned", "worse")]
    table = ExportedBoard.of(board, read_datasets(tmp_path)["kitti", "footage"], read).table()
    assert [row[1] for row in table.rows] == ["untuned", "worse", "theirs", "ahead"]
    assert table.rows[2][2] == "causal, tuned on these recordings"
    assert "**" in table.rows[0][4]
    assert "**" not in table.rows[2][4]


def test_the_joint_solvers_say_that_they_were_tuned_on_kitti() -> None:
    board = read_results(published_results())[Board(split="kitti", tier="footage", protocol="sequential")]
    seen = {row.solver: row.seen for row in board}
    assert {name for name, how in seen.items() if how} >= {"map-causal", "map-batch", "vb-former"}
    assert seen["cv"] == seen["sf"] == ""


@pytest.mark.slow
def test_committed_rows_say_what_the_solvers_declare() -> None:
    """`python -m release.facts` writes what they declare now."""
    assert [row.path for row in outdated(published_results())] == []
