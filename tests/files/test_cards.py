"""Every dataset's cards are valid, load every table offline, say nothing that is withheld, and fit their dataset."""

import json
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import mlcroissant
import numpy as np
import pyarrow.parquet as pq
import pytest
import yaml

from tests.lib.crohd_files import write_recording
from tests.lib.made_footage import made as made_footage
from tests.lib.made_footage import recording as footage
from tests.lib.made_footage import relative
from tests.lib.make_dataset import Crowd, write_dataset
from vbbench.cli import main
from vbbench.errors import FileError, VbbenchError
from vbbench.files.cards.readme import hub_identifier, licence_address, size_category
from vbbench.files.cards.subject import RELATIVE, Publisher, table_meanings
from vbbench.files.cards.writing import CROISSANT, README, card_dataset, card_texts
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_checks import TABLES
from vbbench.files.dataset_info import DatasetInfo
from vbbench.files.tables import OPTIONAL, SCHEMAS
from vbbench.files.verification import verify
from vbbench.folders.replacing import write_text_atomically
from vbbench.generation import generate
from vbbench.generation.generator import Options, Simulation
from vbbench.registry import load, registered
from vbbench.sequence import Odometry

WALK = Path(__file__).parents[1] / "lib" / "short_walk.toml"
SECRET = 0xDECADE << 100
TINY = Crowd(scenes=1, sequences=2)
PUBLISHER = Publisher(
    creator="A Lab",
    url="https://example.org/data",
    published="2026-11-30",
    contact="a@example.org",
    citation="Us, 2026",
)


def front_matter(folder: Path) -> dict[str, Any]:
    return yaml.safe_load((folder / README).read_text("utf-8").split("---\n")[1])


def check_cards(folder: Path, *, rows: bool = True) -> None:
    """The README names each table that is there; Croissant is valid, and has the ``rows`` of each."""
    info = DatasetInfo.read(folder)
    tables = [name for name in info.tables if (folder / f"{name}.parquet").is_file()]
    head, text = front_matter(folder), (folder / README).read_text("utf-8")
    assert {config["data_files"] for config in head["configs"]} == {f"{name}.parquet" for name in tables}
    assert all(f"### `{name}.parquet`" in text for name in tables)
    assert head["vbbench"]["dataset"] == info.id
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        described = mlcroissant.Dataset(str(folder / CROISSANT))
    assert not described.metadata.ctx.issues.errors
    assert len(described.metadata.record_sets) == len(tables)
    for name in tables if rows else ():
        check_records(described, name, pq.read_table(folder / f"{name}.parquet").to_pydict())
    assert "no card" not in verify(folder)


def check_records(described: mlcroissant.Dataset, table: str, columns: dict[str, list[Any]]) -> None:
    name = table.replace("/", "_")
    records = list(described.records(name))
    for column, values in columns.items():
        found = [record[f"{name}/{column}"] for record in records]
        if column == "split":
            assert [text.decode() for text in found] == values
        else:  # NaN may come as None
            np.testing.assert_array_equal(np.array(found, np.float64), values)


@pytest.mark.parametrize("split", sorted(registered("generator")))
def test_cards_of_every_split_are_valid_and_name_licence_and_citation(split: str, tmp_path: Path) -> None:
    """The tables of a small crowd stand for each split's own."""
    card, folder = load("generator", split).card, tmp_path / "d"
    info = replace(write_dataset(folder, TINY), split=split, title=card.title, caution=card.caution)
    write_text_atomically(folder / "dataset.json", info.to_json())
    assert "no card says what it is: 'vbbench card FOLDER'" in verify(folder)
    card_dataset(folder)
    check_cards(folder, rows=False)
    text, values = (folder / README).read_text("utf-8"), json.loads((folder / CROISSANT).read_text("utf-8"))
    assert card.title in text
    if card.people == "recorded" and split not in ("custom", "own"):
        assert card.licence.rstrip(".") in text
        assert card.citation in text
        assert card.citation in values["citeAs"]
        assert "real people" in text
        assert "real people" in values["rai:personalSensitiveInformation"][0]
    assert ("no real person can be found" in text) is (card.people == "simulated")
    assert all(source.url in text for source in card.sources)
    assert "2111.05060" in values["citeAs"]


def made_custom(room: Path) -> Path:
    source = room / "tracks.txt"
    source.write_text("".join(f"{t} {k} {0.5 * t + k} {k}.0\n" for t in range(5) for k in range(4)))
    return generate("custom", room / "d", Options(source=source, dt=0.4)).folder


def made_shibuya(room: Path) -> Path:
    source = write_recording(room / "HT21-03")
    return generate("shibuya01", room / "d", Options(source=source, limit=2)).folder


def made_secret(room: Path) -> Path:
    asked = Options(seed=SECRET, simulation=Simulation(scenario=str(WALK)))
    return generate("sim", room / "d", asked, withhold_truth=True).folder


def made_sim(room: Path, split: str = "sim", **asked: Any) -> Path:
    return generate(split, room / "d", Options(limit=2, **asked)).folder


def of_several_cameras(room: Path) -> Path:
    moved = Odometry(motions=np.zeros((30, 3)), covariances=np.tile(np.eye(3), (30, 1, 1)))
    return made_footage(room / "d", footage("one", odometry=moved), footage("two", 1.2, odometry=moved)).folder


MADE: dict[str, Callable[[Path], Path]] = {
    "demo": lambda room: made_sim(room, "demo"),
    "withheld": made_secret,
    "custom": made_custom,
    "several cameras": of_several_cameras,
    "truth relative": lambda room: made_footage(room / "d", relative(footage())).folder,
    "truth poses": lambda room: made_footage(room / "d", footage(scene=None, persons=None)).folder,
    "truth none": lambda room: made_footage(room / "d", footage(scene=None, persons=None, poses=None)).folder,
}


@pytest.mark.slow
@pytest.mark.parametrize("name", MADE)
def test_cards_of_what_is_generated(name: str, tmp_path: Path) -> None:
    check_cards(MADE[name](tmp_path))


@pytest.mark.slow
def test_cards_of_heads_that_were_lifted(tmp_path: Path) -> None:
    folder = made_shibuya(tmp_path)
    check_cards(folder)
    assert "Calibration:" in (folder / README).read_text("utf-8")


@pytest.fixture(scope="module")
def crowd(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A dataset with cards that no test changes."""
    folder = tmp_path_factory.mktemp("crowd") / "d"
    write_dataset(folder, TINY)
    card_dataset(folder)
    return folder


@pytest.fixture
def copy(crowd: Path, tmp_path: Path) -> Path:
    write_dataset(tmp_path / "d", TINY)
    for name in (README, CROISSANT):
        (tmp_path / "d" / name).write_bytes((crowd / name).read_bytes())
    return tmp_path / "d"


def test_every_column_of_every_table_is_explained() -> None:
    assert set(table_meanings()) == {*TABLES, RELATIVE}
    for place, meaning in table_meanings().items():
        name = place.partition(" ")[0]
        schema = [*SCHEMAS[name].names, *(OPTIONAL[name].names if name in OPTIONAL else [])]
        assert list(meaning.columns) == schema
        assert set(meaning.key) <= set(schema)


def test_keys_name_one_row_each(crowd: Path) -> None:
    for name in Dataset(crowd).info.tables:
        columns = pq.read_table(crowd / f"{name}.parquet").to_pydict()
        rows = list(zip(*(columns[column] for column in table_meanings()[name].key), strict=True))
        assert len(set(rows)) == len(rows), name


def test_withheld_truth_stays_withheld(tmp_path: Path) -> None:
    """Cards are made of the published dataset.json alone; they are the same whoever writes them."""
    folder = made_secret(tmp_path)
    texts = {name: (folder / name).read_text("utf-8") for name in (README, CROISSANT)}
    for text in texts.values():
        assert str(SECRET) not in text
        assert f"{SECRET:x}" not in text.lower()
    assert "--seed secret --withhold-truth" in texts[README]
    info = Dataset(folder).info
    assert info.truth_sha256 in texts[README]
    assert all(facts["sha256"] in texts[README] for facts in info.truth_tables.values())
    assert "truth" not in {entry["@id"].partition("/")[0] for entry in json.loads(texts[CROISSANT])["distribution"]}
    assert not list((tmp_path / "d.truth").glob("*.md"))
    card_dataset(folder, overwrite=True)
    assert {name: (folder / name).read_text("utf-8") for name in texts} == texts


def test_nothing_but_dataset_json_is_read(crowd: Path, tmp_path: Path) -> None:
    """However large the tables are, cards take no longer."""
    (tmp_path / "dataset.json").write_bytes((crowd / "dataset.json").read_bytes())
    assert card_texts(tmp_path) == {name: (crowd / name).read_text("utf-8") for name in (README, CROISSANT)}


def test_a_publisher_completes_them_and_mlcroissant_has_nothing_left_to_say(copy: Path) -> None:
    card_dataset(copy, PUBLISHER, overwrite=True)
    metadata = mlcroissant.Dataset(str(copy / CROISSANT)).metadata
    assert not metadata.ctx.issues.warnings
    assert (metadata.creators[0].name, metadata.url, metadata.date_published.year) == ("A Lab", PUBLISHER.url, 2026)
    assert metadata.data_limitations
    text = (copy / README).read_text("utf-8")
    assert all(said in text for said in vars(PUBLISHER).values() if said not in (None, PUBLISHER.published))
    check_cards(copy)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"url": "example.org"}, "url must be a web address"),
        ({"published": "tomorrow"}, "published must be a day"),
        ({"creator": " "}, "creator must be printable text"),
        ({"contact": "a\nb"}, "contact must be printable text"),
    ],
)
def test_what_a_publisher_says_is_checked(wrong: dict[str, str], said: str) -> None:
    with pytest.raises(VbbenchError, match=said):
        Publisher(**wrong)


def test_a_licence_is_the_publishers_to_say_for_a_recording_of_their_own_only(tmp_path: Path) -> None:
    folder = made_custom(tmp_path)
    assert front_matter(folder)["license"] == "other"
    card_dataset(folder, Publisher(licence="CC BY 4.0"), overwrite=True)
    assert front_matter(folder)["license"] == "cc-by-4.0"
    assert (
        json.loads((folder / CROISSANT).read_text("utf-8"))["license"] == "https://creativecommons.org/licenses/by/4.0/"
    )
    made_up = made_sim(tmp_path / "other", "demo")
    before = (made_up / README).read_bytes()
    with pytest.raises(VbbenchError, match="that of the sources"):
        card_dataset(made_up, Publisher(licence="MIT"), overwrite=True)
    assert (made_up / README).read_bytes() == before


@pytest.mark.parametrize(
    ("licence", "identifier", "address"),
    [
        ("Apache-2.0, like vbbench", "apache-2.0", "https://www.apache.org/licenses/LICENSE-2.0"),
        ("CC BY-NC-SA 3.0: for research", "cc-by-nc-sa-3.0", "https://creativecommons.org/licenses/by-nc-sa/3.0/"),
        ("CC0", "cc0-1.0", "https://creativecommons.org/publicdomain/zero/1.0/"),
        ("none stated by the authors", "unknown", None),
        ("free for use", "other", None),
        ("MITx terms", "other", None),
    ],
)
def test_licences_in_the_words_of_hubs(licence: str, identifier: str, address: str | None) -> None:
    assert (hub_identifier(licence), licence_address(licence)) == (identifier, address)


def test_sizes_in_the_words_of_hubs() -> None:
    assert [size_category(n) for n in (999, 1000, 10**7, 10**9)] == ["n<1K", "1K<n<10K", "10M<n<100M", "1B<n<10B"]


def test_cards_of_another_dataset_are_refused(copy: Path, tmp_path: Path) -> None:
    write_dataset(tmp_path / "other", replace(TINY, seed=1))
    card_dataset(tmp_path / "other")
    for name, said in ((README, "is the card of another dataset"), (CROISSANT, "describes another dataset")):
        kept = (copy / name).read_bytes()
        (copy / name).write_bytes((tmp_path / "other" / name).read_bytes())
        with pytest.raises(FileError, match=f"{name}: {said}.*vbbench card FOLDER --overwrite"):
            verify(copy)
        (copy / name).write_bytes(kept)
    assert "as written" in verify(copy)


def test_a_card_that_lost_a_table_or_a_sum_is_refused(copy: Path) -> None:
    text = (copy / CROISSANT).read_text("utf-8")
    digest = Dataset(copy).info.tables["given"]["sha256"]
    (copy / CROISSANT).write_text(text.replace(digest, "0" * 64), encoding="utf-8")
    with pytest.raises(FileError, match=r"has not the SHA-256 of given\.parquet"):
        verify(copy)
    (copy / CROISSANT).write_text("[]", encoding="utf-8")
    with pytest.raises(FileError, match="is damaged"):
        verify(copy)
    (copy / CROISSANT).unlink()
    readme = (copy / README).read_text("utf-8")
    (copy / README).write_text(
        readme.replace("data_files: given.parquet", "data_files: taken.parquet"), encoding="utf-8"
    )
    with pytest.raises(FileError, match="its front matter lacks given"):
        verify(copy)


def test_what_a_card_says_may_be_edited(copy: Path) -> None:
    """Hubs rewrite the front matter; people add sentences."""
    head, text = front_matter(copy), (copy / README).read_text("utf-8").split("---\n", 2)[2]
    rewritten = f"---\n{yaml.safe_dump({**head, 'language': ['en']})}---\n{text}\nMore on our page.\n"
    (copy / README).write_text(rewritten, encoding="utf-8")
    assert verify(copy).endswith("are as written")
    (copy / README).write_text("# Notes of our own\n", encoding="utf-8")
    assert "its README.md is not one of vbbench's cards" in verify(copy)


def test_the_command_writes_cards_and_replaces_none_unasked(
    copy: Path, mistake: Callable[..., str], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(copy.parent)
    assert "d/README.md: exists; set --overwrite to replace it" in mistake("card", "d")
    assert main(["card", "d", "--creator", "A Lab", "--overwrite"]) == 0
    assert capsys.readouterr().out.splitlines() == ["d/README.md", "d/croissant.json"]
    assert "**By whom?** A Lab." in (copy / README).read_text("utf-8")
    mistake("card", "nowhere")
    wanted = "--published must be a day such as 2026-11-30, not '30.11.2026'"
    assert wanted in mistake("card", "d", "--published", "30.11.2026", "--overwrite")
