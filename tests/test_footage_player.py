"""The player of footage: small copies of the camera's pictures, and whatever is known of the truth."""

import numpy as np
import pytest
from PIL import Image

from tests.player_decoding import decode_clip, decode_estimate
from tests.test_footage import FRAMES, made
from tests.test_footage_pictures import known_as, photographed
from tests.test_player import read_data
from vbbench.solving import solve
from vbbench_leaderboards.results.folder import dataset_folder, read_results, submission_folder
from vbbench_leaderboards.results.result import Board
from vbbench_leaderboards.site.building import build
from vbbench_leaderboards.site.player import Films, write_player
from vbbench_leaderboards.submitting import add

__all__ = ["photographed"]
WALKER = "tests.test_footage_pictures:Walker"


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::vbbench.errors.VbbenchWarning")
@pytest.mark.parametrize("kind", ["whole", "poses", "relative"])
def test_the_player_shows_what_is_known_over_small_copies_of_the_pictures(tmp_path, photographed, kind):
    pictures = photographed.info.pictures[0]
    folder = dataset_folder(tmp_path / "work", "walk", "footage")
    dataset = made(folder, known_as(kind, pictures=pictures))
    board = Board(split="walk", tier="footage", protocol="cold-start")
    solve(dataset, WALKER, "cold-start", submission_folder(tmp_path / "work", board, "walker"))
    words = {"name": "walker", "authors": "somebody", "trained_on": "nothing", "tuned_on": "nothing"}
    add(submission_folder(tmp_path / "work", board, "walker"), folder, tmp_path / "results", **words)
    results = read_results(tmp_path / "results")
    build(tmp_path / "page", tmp_path / "results", films=Films(work=tmp_path / "work"))
    assert (tmp_path / "page/data/player/walk.js").is_file()
    films = Films(work=tmp_path / "work", footage=True)
    assert write_player(tmp_path / "site", results, films) == {board: ("walker",)}
    index = read_data(tmp_path / "site/data/player/walk.js")[1]
    assert (index["truth"], index["sequences"], index["pictures"]) == (kind, [0], {"0": FRAMES})
    (figures,) = index["boards"]["cold-start-footage"]["solvers"].values()
    assert (figures["dx"] == [None]) == (kind == "poses")
    assert (figures["dt"] == [None]) == (kind == "relative")
    with Image.open(tmp_path / "site/data/player/pictures/walk/0/00007.jpg") as thumbnail:
        assert thumbnail.size == (640, 360)
    data = tmp_path / "site/data/player/walk"
    clip = decode_clip(read_data(data / "footage/0.js")[1])
    poses, positions = decode_estimate(read_data(data / "cold-start-footage/0/walker.js")[1], clip)
    assert np.isnan(poses).all() == (kind == "relative")
    counted = clip["observed"] & clip["known"]
    errors = np.where(counted, np.linalg.norm(positions - clip["positions"], axis=-1), np.nan)[2:]
    if kind == "poses":
        assert np.isnan(errors).all()
    else:
        assert np.nanmean(errors) == pytest.approx(figures["dx"][0], abs=0.002)
