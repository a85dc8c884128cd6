"""``dataset.json``: no key of it can be changed unseen, and whatever stands in it, one line names the key."""

import hashlib
import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.lib.make_dataset import Crowd, write_dataset
from vbbench.errors import FileError
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_checks import check_in_scene, check_scene
from vbbench.files.dataset_info import DatasetInfo
from vbbench.files.verification import verify

Change = Callable[[dict[str, Any]], object]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("json") / "tiny"
    write_dataset(folder, Crowd(sequences=4, caution="made up"))
    return folder


@pytest.fixture
def dataset(made: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(made, tmp_path / "tiny"))


def change(dataset: Path, what: Change, *, sealed: bool = False) -> None:
    """Change the facts; ``sealed``: with a digest that fits."""
    path = dataset / "dataset.json"
    values = json.loads(path.read_text("utf-8"))
    digest = values.pop("digest")
    what(values)
    path.write_text(json.dumps({**values, "digest": _digest(values) if sealed else digest}), encoding="utf-8")


def _digest(values: dict[str, Any]) -> str:
    """As docs/files.md says it."""
    text = json.dumps(values, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()


def test_the_digest_is_the_documented_one(dataset: Path) -> None:
    values = json.loads((dataset / "dataset.json").read_text("utf-8"))
    assert values.pop("digest") == _digest(values)
    assert "4 sequences are as written" in verify(dataset)
    assert "has no digest" not in verify(dataset)


@pytest.mark.parametrize(
    "what",
    [
        lambda v: v.update(title="Tinier"),
        lambda v: v.update(caution=None),
        lambda v: v["counts"].update(observations=1),
        lambda v: v["tables"]["given"].update(rows=1),
        lambda v: v["tables"]["truth/poses"].update(sha256="0" * 64),
        lambda v: v.update(package_version="9.9"),
        lambda v: v.update(calibration={"summary": "exact"}),
    ],
)
def test_what_is_changed_by_hand_is_seen(dataset: Path, what: Change) -> None:
    change(dataset, what)
    with pytest.raises(FileError, match=r"dataset\.json: was changed by hand"):
        Dataset(dataset)


@pytest.mark.parametrize("name", ["sequences", "frames", "observations", "people_min", "people_max"])
def test_counts_and_rows_are_counted_again(dataset: Path, name: str) -> None:
    change(dataset, lambda v: v["counts"].update({name: v["counts"][name] + 1}), sealed=True)
    with pytest.raises(FileError, match=rf"key 'counts' has \d+ {name}, the tables \d+"):
        verify(dataset)


def test_a_count_of_rows_that_is_wrong_is_seen(dataset: Path) -> None:
    change(dataset, lambda v: v["tables"]["given"].update(rows=1), sealed=True)
    with pytest.raises(FileError, match=r"given\.parquet: has other rows than the 1 in dataset\.json"):
        verify(dataset)


def test_a_person_who_is_seen_must_be_in_the_scene_then() -> None:
    """Frames in which nobody is seen may come after the scene's last row; a box of a person may not."""
    here, people = Path, np.array([3])
    check_in_scene(here, 0, people, np.zeros((5, 1), bool))
    with pytest.raises(FileError, match=r"truth/scenes: .*in frame 2 of sequence 0 a person is seen who is not in the"):
        check_in_scene(here, 0, people, np.arange(5)[:, None] > 1)
    with pytest.raises(FileError, match="the scene of sequence 0 is empty"):
        check_in_scene(here, 0, people[:0])
    rows = {"person": np.array([3, 3]), "frame": np.array([0, 4]), "x": np.zeros(2), "y": np.zeros(2)}
    assert [check_scene(here, 0, people, rows, least) for least in (0, 9)] == [5, 9]
    with pytest.raises(FileError, match="scene 0 has a frame far from all others"):
        check_scene(here, 0, people, rows, 10**9)
    with pytest.raises(FileError, match="in scene 0 a person is infinitely far"):
        check_scene(here, 0, people, rows | {"y": np.array([0.0, -np.inf])}, 0)


def test_a_dataset_from_before_there_was_a_digest_is_read_and_said(dataset: Path) -> None:
    path = dataset / "dataset.json"
    values = json.loads(path.read_text("utf-8"))
    del values["digest"]
    path.write_text(json.dumps(values), encoding="utf-8")
    assert Dataset(dataset).info == DatasetInfo.read(dataset)
    assert "dataset.json has no digest" in verify(dataset)


def drop(*names: str) -> Change:
    def without(values: dict[str, Any]) -> None:
        for name in names[:-1]:
            values = values[name]
        del values[names[-1]]

    return without


TABLE = {"bytes": 1, "rows": 1, "sha256": "0" * 64}


@pytest.mark.parametrize(
    ("what", "fault"),
    [
        (drop("title"), "missing required field `title`"),
        (lambda v: v.update(colour="red"), "unknown field `colour`"),
        (lambda v: v.update({"a\x1b[2J" + 999 * "b": 1}), r"unknown field `a\\x1b\[2Jb+… \(\d+ characters\)"),
        (lambda v: v.update(title="a\x1b[2J"), r"printable characters, got 'a\\x1b\[2J' - at `\$\.title`"),
        (lambda v: v.update(title="t" * 2000), r"printable characters, got 't+… \(2001 characters\) - at `\$\.title`"),
        (lambda v: v.update(caution=""), r"at `\$\.caution`"),
        (lambda v: v.update(split="../x"), r"at `\$\.split`"),
        (lambda v: v.update(tier=7), r"Expected `str`, got `int` - at `\$\.tier`"),
        (lambda v: v.update(seed=-1), r"Expected `int` >= 0, got -1 - at `\$\.seed`"),
        (lambda v: v.update(dt=0), r"Expected `float` > 0\.0 - at `\$\.dt`"),
        (lambda v: v.update(dt=10**30), r"<= 1000\.0 - at `\$\.dt`"),
        (lambda v: v.update(scenes="scene0"), r"Expected `array`, got `str` - at `\$\.scenes`"),
        (lambda v: v["camera"].update(kind="fisheye"), "key 'camera': no camera is called 'fisheye'"),
        (lambda v: v["camera"].update(focal=-1), "key 'camera': .*focal must be 0.01 to"),
        (lambda v: v["camera"].update(focal="wide"), "key 'camera': .*focal must be a number"),
        (lambda v: v["camera"].update(zoom=1), "key 'camera': .*zoom"),
        (drop("counts", "frames"), r"missing required field `frames` - at `\$\.counts`"),
        (lambda v: v["counts"].update(frames=-1), r"Expected `int` >= 0 - at `\$\.counts\.frames`"),
        (lambda v: v["tables"].update({"../x": TABLE}), r"unknown field `\.\./x` - at `\$\.tables`"),
        (lambda v: v["tables"].update({"/etc/passwd": TABLE}), r"unknown field `/etc/passwd` - at `\$\.tables`"),
        (drop("tables", "given", "bytes"), r"missing required field `bytes` - at `\$\.tables\.given`"),
        (lambda v: v["tables"]["given"].update(sha256="x"), r"at `\$\.tables\.given\.sha256`"),
        (drop("tables", "truth/poses"), r"lacks truth/poses - at `\$\.tables`"),
        (lambda v: v.update(id="0"), r"at `\$\.id`"),
        (lambda v: v.update(format_version=1.5), "format version 1.5"),
        (lambda v: v.update(format_version=3), "format version 3"),
    ],
)
def test_every_key_is_checked_and_named(dataset: Path, what: Change, fault: str, mistake: Callable[..., str]) -> None:
    change(dataset, what, sealed=True)
    with pytest.raises(FileError, match=fault):
        DatasetInfo.read(dataset)
    said = mistake("verify", dataset)
    assert len(said) < 1000
    assert said.replace("\n", "").isprintable()


@pytest.mark.parametrize(
    "text", ["[" * 100_000, "[]", "{", '{"id": NaN}', '{"a": 1, "a": 2}', '{"dt": 1e999}', "\udcff"]
)
def test_what_is_no_json_object_is_damaged(dataset: Path, text: str) -> None:
    (dataset / "dataset.json").write_bytes(text.encode("utf-8", "surrogateescape"))
    with pytest.raises(FileError, match=r"is damaged|format version"):
        Dataset(dataset)
