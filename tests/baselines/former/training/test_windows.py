"""Training vb-former: what is learned from, that nothing but seed and recipe decides, and that it can be stopped."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.baselines.former.training.conftest import TINY
from vbbench.errors import VbbenchError
from vbbench.protocol import PROTOCOLS
from vbbench_baselines.former.training.crowds import Crowds, Watched, make_crowds
from vbbench_baselines.former.training.recipe import Phase, Size, read_recipe

pytest.importorskip("torch", reason="needs the extra torch")
pytestmark = pytest.mark.extra

from vbbench_baselines.former.training.batches import Window, alter, cut  # noqa: E402

BUNDLED = read_recipe(None)
FEW, ALL = (Size(least=least, most=most, windows=1, share=1.0) for least, most in ((2, 4), (50, 50)))


def long(frames: int) -> Phase:
    """Windows of so many frames."""
    return Phase(frames=frames, share=1.0)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(5)


def windows_of(crowds: Crowds, rng: np.random.Generator, count: int = 40, frames: int = 9) -> list[Window]:
    drawn = [
        cut(rng, stream[rng.integers(len(stream))], long(frames), FEW)
        for stream in crowds.streams
        for _ in range(count)
    ]
    return [window for window in drawn if window is not None]


def same(a: Watched, b: Watched) -> bool:
    arrays = zip((*a[:2], *a.sights), (*b[:2], *b.sights), strict=True)
    return (a.dt, a.spread) == (b.dt, b.spread) and all(np.array_equal(x, y, equal_nan=True) for x, y in arrays)


def test_crowds_are_the_same_from_any_number_of_processes_and_from_their_files(
    crowds: Crowds, folder: Path, tmp_path: Path
) -> None:
    kept = {path: path.stat().st_mtime_ns for path in folder.iterdir()}
    again = make_crowds(TINY, folder, TINY.seed)
    assert kept == {path: path.stat().st_mtime_ns for path in folder.iterdir()}
    parallel = make_crowds(TINY, tmp_path, TINY.seed, jobs=2)
    assert len(crowds) == len(again) == len(parallel) == 8
    for stream, read, made in zip(crowds.streams, again.streams, parallel.streams, strict=True):
        assert all(same(a, b) and same(a, c) for a, b, c in zip(stream, read, made, strict=True))
    np.testing.assert_allclose(crowds.shares, [1 / 3, 2 / 3])


def test_another_seed_and_another_recipe_make_other_files(crowds: Crowds, folder: Path) -> None:
    before = set(folder.iterdir())
    other = make_crowds(TINY, folder, TINY.held_out_seed)
    assert not any(same(a, b) for a, b in zip(crowds.streams[0], other.streams[0], strict=True))
    make_crowds(replace(TINY, people={"open": (5, 7), "plaza": (5,)}), folder, TINY.seed)
    assert len(set(folder.iterdir()) - before) == 3


def test_a_window_tells_what_its_boxes_told(crowds: Crowds, rng: np.random.Generator) -> None:
    for watched in (stream[0] for stream in crowds.streams):
        window = cut(rng, watched, long(len(watched.poses)), ALL)
        told, sights = window.shown(), watched.sights
        people = np.flatnonzero(sights.seen.any(axis=0))
        seen = sights.seen[:, people] > 0.5
        np.testing.assert_array_equal(told.seen > 0.5, seen)
        for name in ("ray", "by_height"):
            np.testing.assert_allclose(
                getattr(told, name)[seen], getattr(sights, name)[:, people][seen], atol=1e-5, err_msg=name
            )
        feet = sights.has_feet[:, people] > 0.5
        np.testing.assert_allclose(told.by_feet[feet], sights.by_feet[:, people][feet], atol=1e-5)


def test_altered_windows_keep_what_boxes_are_wrong_by(crowds: Crowds, rng: np.random.Generator) -> None:
    changed = 0
    for window in windows_of(crowds, rng):
        altered = alter(rng, window)
        told, relative = altered.shown(), altered.relative
        seen = (told.seen > 0.5) & (np.abs(np.log(np.abs(relative)) + altered.height_error) < 1.5)
        off = np.log(np.abs(relative)) + altered.height_error - told.by_height
        np.testing.assert_allclose(off[seen], 0.0, atol=1e-5)
        np.testing.assert_allclose(np.abs(altered.error), np.abs(window.error), atol=1e-6)
        assert not (altered.seen & ~window.seen).any()
        assert (np.abs(relative)[altered.seen] > 0.4).all()
        changed += not np.allclose(altered.positions, window.positions)
    assert changed > 20


def test_quick_recordings_are_cut_at_slower_rates_too(crowds: Crowds, rng: np.random.Generator) -> None:
    plaza = crowds.streams[1][0]
    rates = {round(window.dt, 3) for _ in range(60) if (window := cut(rng, plaza, long(9), FEW))}
    assert rates == {round(plaza.dt, 3), round(2 * plaza.dt, 3)}
    assert cut(rng, plaza, long(len(plaza.poses) + 1), FEW) is None


def test_the_bundled_recipe_never_trains_on_seeds_of_the_boards_and_names_simulated_splits_alone() -> None:
    assert min(BUNDLED.seed, BUNDLED.held_out_seed) > 0
    assert BUNDLED.seed != BUNDLED.held_out_seed
    assert {stream.split for stream in BUNDLED.stream} == {"sim", "street"}
    assert sum(size.share for size in BUNDLED.size) == pytest.approx(1.0)


def test_recipes_with_mistakes_are_refused(tmp_path: Path) -> None:
    text = Path(__file__).parents[4].joinpath("baselines/vbbench_baselines/former/training/recipe.toml").read_text()
    path = tmp_path / "mine.toml"
    for old, new, message in (
        ("seed = 2", "seed = 0", "seed"),
        ("plaza = [", "plazza = [", "plaza"),
        ("cold-start = ", "cold_start = ", "cold-start"),
        ("frames = 6", "frames = 1", "frames"),
        ("averaged = 0.2", "averaged = 0.0", "averaged must be 0.001 to 1"),
        ("decay = 0.3", "decay = 1.0", "decay must be 0 to 0.99"),
        ("least = 5", "least = 12", r"\[\[size\]\] is of 12 to 9 people"),
        ("open = [4,", "open = [-4,", r"\[people\] open must be 1 to 10,000, not -4"),
        ("street = [15, 30, 50]", "street = 15", r"\[people\] street is a list of numbers"),
        ("rollout = 0.12", "rollout = -0.12", r"\[protocols\] rollout must be 0 to 1, not -0.12"),
    ):
        assert old in text
        path.write_text(text.replace(old, new, 1))
        with pytest.raises(VbbenchError, match=message):
            read_recipe(path)
    for part, message in (
        ({"size": ()}, r"\[\[size\]\] is missing"),
        ({"phase": ()}, r"\[\[phase\]\] is missing"),
        ({"people": {}}, r"\[people\] is missing"),
        ({"held_out_seed": TINY.seed}, "seed and held_out_seed are both"),
        (
            {"size": (replace(TINY.size[0], least=900, most=900),)},
            r"crowds of at most \d+, and every \[\[size\]\] wants",
        ),
        ({"protocols": dict.fromkeys(PROTOCOLS, 0.0)}, r"\[protocols\] is missing, or all of its shares are 0"),
    ):
        with pytest.raises(ValueError, match=message):
            replace(TINY, **part)
