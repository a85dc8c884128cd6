"""Recipes are strict, readable and give the paper's Table 1."""

import re
import tomllib
from collections.abc import Callable
from dataclasses import fields
from importlib.resources import files
from pathlib import Path

import numpy as np
import pytest

from vbbench.errors import FileError, SourceMissingError, UnknownNameError, VbbenchError
from vbbench.generation.generator import Options
from vbbench.scene import Scene
from vbbench_generators.recordings.loading import load_scenes, off_grid
from vbbench_generators.recordings.recipe import Rules, find_spans, get_recipe, observed_crowd, read_recipe

Write = Callable[..., Path]

NAMES = [
    *("custom", "eth", "eth-15fps", "hotel", "shibuya01", "shibuya02", "students", "students-resampled"),
    *("zara01", "zara02"),
]
PINNED = r"https://raw\.githubusercontent\.com/[^/]+/[^/]+/[0-9a-f]{40}/"
PUBLISHED = "https://motchallenge.net/data/HT21Labels.zip"
RECIPE = """
name = "mine"
title = "Mine"
licence = "mine"
citation = "me"
format = "trajnet"
dt = 0.4
frame_step = 10
[[source]]
path = "mine.txt"
url = "http://127.0.0.1/mine.txt"
sha256 = "00"
[sequences]
skip_first_frames = 0
min_others = 1
min_frames = 2
standing_displacement = 0
count_observer = false
"""
WALK = "0 1 0.0 0.0\n10 1 50 0.0\n20 1 100 0.0\n"


def load(source, name="custom", **asked):
    return load_scenes(get_recipe(name), Options(source=source, **asked))


def table1(recipe, source):
    """Sequences, mean frames, and people (least, mean, most), counted after the recipe's rules."""
    rules, people, spans = recipe.sequences, [], 0
    for number, scene in enumerate(load_scenes(recipe, Options(source=source)).scenes):
        crowd = observed_crowd(scene, rules)
        for span in find_spans(scene, number, rules):
            frames = span.first + np.flatnonzero(span.counted)
            people.append(crowd[frames].sum(axis=1) - crowd[frames, span.column] + rules.count_observer)
            spans += 1
    seen = np.concatenate(people)
    return spans, len(seen) / spans, int(seen.min()), float(seen.mean()), int(seen.max())


@pytest.mark.parametrize("name", NAMES)
def test_bundled_recipe(name):
    recipe = get_recipe(name)
    assert recipe.name == name
    assert recipe.title
    assert recipe.licence
    assert recipe.citation
    for source in recipe.sources:
        assert re.fullmatch("[0-9a-f]{64}", source.sha256)
        assert re.match(PINNED, source.url) or source.url == PUBLISHED
    table = tomllib.loads((files("vbbench_generators") / "recipes" / f"{name}.toml").read_text("utf-8"))
    assert set(table["sequences"]) == {field.name for field in fields(Rules)}


def test_cautions_hold_by_tier():
    assert "interpolated truth" in (get_recipe("students").caution_for("ideal") or "")
    assert get_recipe("students").caution_for("noisy") is None
    assert "1.67" in (get_recipe("eth").caution_for("noisy") or "")
    assert get_recipe("hotel").caution_for("ideal") is None


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("dt = 0.4", "dt = 0.4\nspeed = 1", "recipe: unknown key 'speed'"),
        ("min_others", "min_other", r"\[sequences\]: unknown key 'min_other'; did you mean 'min_others'"),
        ('sha256 = "00"', "", r"\[\[source\]\]: key 'sha256' is missing"),
        ("dt = 0.4", 'dt = "fast"', "dt = 'fast' has the wrong type"),
        ('format = "trajnet"', 'format = "csv"', "format = 'csv'"),
        ("[sequences]", "[caution]\ntext = 'x'\ntiers = ['clean']\n[sequences]", "tiers"),
    ],
)
def test_bad_recipe(write, old, new, problem):
    assert old in RECIPE
    path = write(RECIPE.replace(old, new, 1), "mine.toml")
    with pytest.raises(FileError, match=problem) as caught:
        read_recipe(path)
    assert caught.value.path == path


def test_missing_sources_name_the_split(no_data):
    with pytest.raises(SourceMissingError, match="vbbench fetch hotel"):
        load(None, "hotel")


def test_overrides_are_for_custom_only(no_data):
    with pytest.raises(VbbenchError, match="custom"):
        load(None, "hotel", dt=0.1)


def test_custom(write):
    path, homography = write(WALK), write("0.01 0 0\n0 0.01 0\n0 0 1\n", "H.txt")
    loaded = load(path, dt=0.5, homography=homography)
    np.testing.assert_allclose(loaded.scenes[0].positions[:, 0, 0], [0, 0.5, 1])
    assert loaded.scenes[0].dt == 0.5
    assert [name for name, _ in loaded.files] == ["tracks.txt", "H.txt"]


def test_custom_vsp_is_sampled_every_dt(write):
    text = "1 - the number of splines\n2 - Num of control points\n0 0 0 0 - (2D)\n100 0 25 0 - (2D)\n"
    path, homography = write(text, "a.vsp"), write("0.01 0 0\n0 0.01 0\n0 0 1\n", "H.txt")
    loaded = load(path, dt=0.2, homography=homography)
    np.testing.assert_allclose(loaded.scenes[0].positions[:, 0, 0], [0, 0.2, 0.4, 0.6, 0.8, 1])
    with pytest.raises(FileError, match=r"multiple of 0\.04"):
        load(path, dt=0.25, homography=homography)
    with pytest.raises(FileError, match="`homography`"):
        load(path, dt=0.2)


def test_custom_obsmat_needs_no_homography(write):
    path = write("0 1 0 0 0 0 0 0\n6 1 .5 0 0 0 0 0\n", "obsmat.txt")
    assert load(path, dt=0.4).scenes[0].frames == 2
    with pytest.raises(FileError, match="metres already"):
        load(path, dt=0.4, homography=write("1 0 0\n0 1 0\n0 0 1\n", "H.txt"))


@pytest.mark.parametrize("dt", [None, 0.0, -1.0, float("nan")])
def test_custom_needs_dt(write, dt):
    with pytest.raises(VbbenchError, match=r"`dt`|dt, the time of a frame"):
        load(write(WALK), dt=dt)


def test_custom_needs_a_file(tmp_path):
    for source in (None, tmp_path, tmp_path / "nowhere.txt"):
        with pytest.raises(VbbenchError, match="--source FILE"):
            load(source, dt=0.4)


@pytest.mark.parametrize(
    ("name", "sequences", "frames", "people"),
    [
        ("hotel", 340, 14.791, (3, 6.303, 16)),
        ("eth", 347, 14.372, (3, 9.270, 26)),
        ("eth-15fps", 348, 23.098, (3, 9.155, 26)),
        ("students", 849, 45.839, (13, 44.286, 75)),
        ("students-resampled", 849, 45.007, (4, 43.617, 75)),
    ],
)
def test_table1(data_folder, name, sequences, frames, people):
    found = table1(get_recipe(name), data_folder)
    assert found == pytest.approx((sequences, frames, *people), abs=6e-4)


@pytest.mark.slow
def test_resampled_students_follow_from_the_seed(data_folder):
    first, again, other = (load(data_folder, "students-resampled", seed=seed).scenes for seed in (0, 0, 1))
    for a, b, c in zip(first, again, other, strict=True):
        np.testing.assert_array_equal(a.positions, b.positions)
        moved = (a.positions - c.positions)[a.present]
        assert moved.std() == pytest.approx(0.01 * np.sqrt(2), rel=0.02)
    noise = [scene.positions[scene.present][:100] for scene in first]
    assert not np.allclose(*noise)


def test_resampled_students_stay_near_the_published_ones(data_folder):
    """But accelerate: in the text file about half of all second differences are zero to its last digits."""
    published = load(data_folder, "students").scenes
    smooth = load(data_folder, "students-resampled").scenes
    for text, curve in zip(published, smooth, strict=True):
        apart = np.linalg.norm(text.positions - curve.positions, axis=-1)[curve.present]
        assert np.median(apart) < 0.03
        assert np.quantile(apart, 0.99) < 0.15
        bends = [np.abs(np.diff(scene.positions, 2, axis=0)) for scene in (text, curve)]
        assert np.nanmedian(bends[0]) < 0.004
        assert np.nanmedian(bends[1]) > 0.01


def test_places_that_were_rounded_to_a_grid_are_drawn_within_its_cells():
    positions = np.zeros((200, 5, 2))
    scene = Scene(name="a", dt=0.4, people=np.arange(5), positions=positions, heights=np.full(5, np.nan))
    drawn, again, other = (off_grid(scene, 0.5, seed, 0).positions for seed in (0, 0, 1))
    np.testing.assert_array_equal(drawn, again)
    assert not np.allclose(drawn, other)
    assert np.abs(drawn).max() <= 0.25
    assert drawn.std() == pytest.approx(0.5 / np.sqrt(12.0), rel=0.05)


def test_unknown_recipe_suggests():
    with pytest.raises(UnknownNameError, match="'hotel'"):
        get_recipe("hotels")
