"""The split of filmed streets: its tables, whom the detector found, and how films are made."""

import numpy as np
import pytest

from benchmarks import street_films
from vbbench.cli import main
from vbbench.errors import UnknownNameError
from vbbench.exchange.detection import Detections
from vbbench.files.generate_command import generate_command
from vbbench.generation.footage import FootageOptions
from vbbench.generation.generator import Options
from vbbench.parsing.json_text import read_json
from vbbench_generators.footage.street_film import FOLDER, SCALE, read_films, street_film

MOST_BYTES = 1_500_000


@pytest.fixture(scope="module")
def films():
    return read_films()


def test_the_tables_are_small():
    assert sum(path.stat().st_size for path in FOLDER.iterdir()) < MOST_BYTES


def test_people_are_found_and_followed():
    plan = street_film.plan(Options())
    every = plan.info.calibration["recordings"].values()
    assert plan.info.truth == "whole"
    assert plan.info.dt == pytest.approx(0.4)
    assert len(every) == len(read_films()[0])
    assert np.mean([one["detected"]["recall"] for one in every]) > 0.7
    assert np.mean([one["detected"]["precision"] for one in every]) > 0.6
    assert np.mean([one["tracked"]["recall"] for one in every]) > 0.4


def test_films_are_chosen_by_name():
    plan = street_film.plan(Options(footage=FootageOptions(sequences=("film-01",))))
    assert plan.info.scenes == ("film-01",)
    with pytest.raises(UnknownNameError, match="film-99"):
        street_film.plan(Options(footage=FootageOptions(sequences=("film-99",))))


def test_the_command_of_a_dataset_names_no_source(tmp_path):
    assert main(["generate", "street-film", "--sequences", "film-01", "--out", str(tmp_path / "data")]) == 0
    facts = read_json(tmp_path / "data" / "dataset.json")
    command = generate_command(facts, str(tmp_path / "again"))
    assert main(command.split()[1:]) == 0
    assert read_json(tmp_path / "again" / "dataset.json")["tables"] == facts["tables"]


class Everybody:
    """Finds one box in every picture."""

    def detect(self, rgb, period=None):
        assert rgb.shape == (480, 640, 3)
        assert rgb.std() > 5.0
        return Detections(boxes=np.array([[10.0, 20.0, 30.25, 60.0]]), scores=np.array([0.6]))


@pytest.mark.slow
def test_a_film_becomes_rows_of_the_tables(tmp_path, monkeypatch):
    monkeypatch.setattr(street_films, "FRAMES", 3)
    street_films.make_film(3, Everybody(), tmp_path)
    street_films.join([tmp_path / "03.npz"], tmp_path / "out")
    facts, tables = read_films(tmp_path / "out")
    assert facts[0]["carried_by"] == "robot"
    assert tables["boxes"]["width"].tolist() == [121, 121, 121]
    assert np.unique(tables["walks"]["frame"]).tolist() == [0, 1, 2]
    assert np.allclose(tables["walks"]["x"] / SCALE["m"], street_films.plan_film(3).poses[:, 0], atol=1e-3)
    shown = (tables["people"]["width"] > 0).sum()
    assert shown >= 3 * street_films.FEWEST
