"""Official training, validation and test lists: no moment, person or scene in two of them; the same ones everywhere."""

import json
import tomllib
from itertools import combinations, product
from pathlib import Path

import numpy as np
import pytest

import vbbench
from tests.lib.kitti_files import write_kitti
from vbbench import Dataset
from vbbench.cli import main
from vbbench.errors import VbbenchError
from vbbench.generation import generate
from vbbench.generation.generator import Options, Simulation
from vbbench.geometry import BoolArray
from vbbench.training.splitting import GAP, NAMES, SHARES, find_cuts, official_lists, parts, recording_names

RECIPES = Path(__file__).parents[2] / "generators" / "vbbench_generators" / "recipes"
DT = 0.4


def comings(people: int, frames: int, stay: int, seed: int = 0) -> BoolArray:
    """[T, P] people who come at random, and stay for up to ``stay`` frames."""
    rng = np.random.default_rng(seed)
    enter, time = rng.integers(0, frames - stay, people), np.arange(frames)[:, None]
    return (time >= enter) & (time < enter + rng.integers(2, stay + 1, people))


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Dataset:
    """60 people who pass within 200 frames, each along a line of one's own."""
    present, lines = comings(60, 200, 12), []
    for t, k in np.argwhere(present):
        lines.append(f"{t} {k} {1.2 * DT * t % 20 + 0.01 * k:.4f} {0.7 * k % 15:.4f}")
    folder = tmp_path_factory.mktemp("recording")
    (folder / "tracks.txt").write_text("\n".join(lines))
    return generate("custom", folder / "data", Options(source=folder / "tracks.txt", dt=DT))


def people_of(dataset: Dataset, index: int) -> set[int]:
    """Everybody who appears in a sequence, its observer too."""
    sequence = dataset.sequence(index)
    return {sequence.observer, *dataset.track_persons(sequence).ravel().tolist()} - {-1}


def test_parts_by_time_share_no_moment_and_nobody(recording: Dataset) -> None:
    found, rows = vbbench.parts(recording, by="time"), recording.rows
    lists = [getattr(found, name) for name in (*NAMES, "left_out")]
    assert np.array_equal(np.sort(np.concatenate(lists)), np.arange(len(recording)))
    assert all(len(numbers) for numbers in lists[:3])
    for a, b in combinations(lists[:3], 2):
        ends = (rows["first_frame"] + rows["frames"])[a].max()
        assert rows["first_frame"][b].min() - ends >= round(GAP / DT)
        assert not set().union(*(people_of(recording, n) for n in a)) & set().union(
            *(people_of(recording, n) for n in b)
        )


@pytest.mark.parametrize("seed", range(4))
def test_no_other_cuts_leave_the_smallest_part_more_people(seed: int) -> None:
    present = comings(14, 40, 6, seed)
    enter, leave = present.argmax(0), len(present) - present[::-1].argmax(0)
    best, gap = 0.0, 2
    for a, c in product(range(1, 41), repeat=2):
        b = max(a + gap, leave[enter < a].max(initial=0))
        d = max(c + gap, leave[enter < c].max(initial=0))
        kept = (leave <= a).sum(), ((enter >= b) & (leave <= c)).sum(), (enter >= d).sum()
        best = max(best, min(n / share for n, share in zip(kept, SHARES, strict=True)))
    cuts = find_cuts(present, GAP / gap)
    part = cuts.part_of(enter, leave)
    assert min((part == n).sum() / share for n, share in enumerate(SHARES)) == best


def test_a_crowd_in_which_somebody_always_stays_trains_whole() -> None:
    present = comings(20, 40, 6)
    present[:, 0] = True
    assert find_cuts(present, DT) is None
    assert find_cuts(np.ones((1, 1), np.bool_), DT) is None


def test_the_cuts_are_those_of_the_recording_whatever_is_made_of_it(recording: Dataset, tmp_path: Path) -> None:
    whole = parts(recording)
    source = recording.folder.parent / "tracks.txt"
    some = parts(generate("custom", tmp_path / "some", Options(source=source, dt=DT, tier="noisy", seed=5, limit=20)))
    for name in (*NAMES, "left_out"):
        numbers = getattr(whole, name)
        assert getattr(some, name).tolist() == numbers[numbers < 20].tolist()
    assert whole.rule == some.rule == "time/1"


@pytest.mark.parametrize(("seed", "part"), [(0, "test"), (1, "validation"), (2, "train"), (7, "train")])
def test_simulated_splits_go_by_their_seed(seed: int, part: str, tmp_path: Path) -> None:
    small = Options(simulation=Simulation(people=(5,)), seed=seed, limit=2)
    found = parts(generate("sim", tmp_path / "sim", small))
    assert getattr(found, part).tolist() == [0, 1]
    assert sum(len(getattr(found, name)) for name in (*NAMES, "left_out")) == 2
    assert found.rule == "seed/1"


def test_every_recipe_is_a_recording_of_the_folds(recording: Dataset) -> None:
    table = tomllib.loads((Path(vbbench.__file__).parent / "training" / "official.toml").read_text("utf-8"))
    known = {digest for place in table["recording"] for digest in place["sources"]}
    for recipe in RECIPES.glob("*.toml"):
        sources = tomllib.loads(recipe.read_text("utf-8")).get("source", [])
        assert {source["sha256"] for source in sources} <= known, recipe.name


def test_one_recording_of_a_dataset_is_left_out(tmp_path: Path) -> None:
    source = tmp_path / "training"
    for name in ("0003", "0004", "0005"):
        write_kitti(source, name=name)
    dataset = generate("kitti", tmp_path / "kitti", Options(source=source))
    assert recording_names(dataset) == ["0003", "0004", "0005"]
    scene, found = dataset.rows["scene"], parts(dataset, "recording", test="0005")
    assert [set(scene[getattr(found, name)]) for name in NAMES] == [{1}, {0}, {2}]
    assert found.rule == "recording/1 0005"


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"by": "recording"}, "which recording is to test? name one of tracks"),
        ({"by": "recording", "test": "trakcs"}, "did you mean 'tracks'?"),
        ({"by": "recording", "test": "tracks"}, "has 1 recordings, too few for three parts; use by time"),
        ({"by": "seed"}, "is a recording, in which another seed"),
        ({"by": "time", "test": "tracks"}, "remove tracks"),
        ({"by": "tiem"}, "no rule is called 'tiem'"),
    ],
)
def test_what_cannot_be_is_said_in_one_line(recording: Dataset, asked: dict[str, str], said: str) -> None:
    with pytest.raises(VbbenchError) as error:
        parts(recording, **asked)  # type: ignore[arg-type]
    assert said in str(error.value)
    assert "\n" not in str(error.value)


def test_simulated_and_withheld_datasets_say_what_to_do(tmp_path: Path) -> None:
    small = Options(simulation=Simulation(people=(5,)), limit=1)
    sim = generate("sim", tmp_path / "sim", small, withhold_truth=True)
    with pytest.raises(VbbenchError, match="is simulated and has no recordings to divide by time; use by seed"):
        parts(sim, "time")
    with pytest.raises(VbbenchError, match=r"the seed of .* is withheld"):
        parts(sim)


def test_the_command_prints_the_lists(recording: Dataset, capsys: pytest.CaptureFixture[str]) -> None:
    found = parts(recording)
    assert main(["parts", str(recording.folder), "--by", "time"]) == 0
    said = capsys.readouterr().out
    assert f"train {len(found.train):15d}" in said
    assert f"SHA-256 {found.sha256}: no lists of this are published" in said
    assert main(["parts", str(recording.folder), "--json"]) == 0
    written = capsys.readouterr().out
    assert written == found.to_json()
    assert json.loads(written)["test"] == found.test.tolist()


SPLITS = sorted({one.split for one in official_lists()})


@pytest.mark.parametrize("split", ["hotel", *[pytest.param(s, marks=pytest.mark.slow) for s in SPLITS if s != "hotel"]])
def test_the_official_lists_are_made_again(split: str, data_folder: Path, tmp_path: Path) -> None:
    dataset = generate(split, tmp_path / split, Options(source=data_folder))
    published = {one.rule: one for one in official_lists() if one.split == split}
    assert len(published) == 6
    for rule, one in published.items():
        by, _, test = rule.partition(" ")
        found = parts(dataset, "time" if by.startswith("time") else "recording", test=test or None)
        assert found.is_official, rule
        assert [len(getattr(found, name)) for name in NAMES] == [one.train, one.validation, one.test], rule
