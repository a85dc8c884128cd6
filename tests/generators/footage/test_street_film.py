"""The split of filmed streets: its tables, whom the detector found, and how films are made."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks import street_films
from vbbench.cli import main
from vbbench.errors import UnknownNameError, VbbenchError
from vbbench.exchange.detection import Detections
from vbbench.files.generate_command import generate_command
from vbbench.generation.footage import FootageOptions
from vbbench.generation.generator import Options
from vbbench.geometry import world_to_relative
from vbbench.parsing.json_text import read_json
from vbbench_generators.footage.street_film import FOLDER, SCALE, read_films, street_film
from vbbench_generators.tiers.field.recipe import get_field

MOST_BYTES = 1_500_000


@pytest.fixture(scope="module")
def films():
    return read_films()


def test_the_tables_are_small():
    assert sum(path.stat().st_size for path in FOLDER.iterdir()) < MOST_BYTES


def test_films_differ_in_camera_carrier_and_time(films):
    facts, _ = films
    assert {one["carried_by"] for one in facts} == {"person", "robot"}
    assert {one["time"] for one in facts} == set(street_films.TIMES)
    assert len({(one["mount_height"], one["focal"]) for one in facts}) == len(facts)


def test_labels_are_where_a_camera_carried_like_that_of_tier_field_sees_people(films):
    facts, tables = films
    people, poses, tallest = tables["people"], tables["walks"], tables["heights"]
    pitches, stretched = [], []
    for number, one in enumerate(facts):
        rows = (people["film"] == number) & (people["width"] > 0)
        place = np.stack([people["x"], people["y"]], axis=-1)[rows] / SCALE["m"]
        pose = np.stack([poses["x"] / SCALE["m"], poses["y"] / SCALE["m"], poses["yaw"] / SCALE["rad"]], axis=-1)
        pose = pose[poses["film"] == number][people["frame"][rows]]
        ahead = np.stack([world_to_relative(p[None], q)[0] for p, q in zip(place, pose, strict=True)])[:, 1]
        height = (tallest["height"][tallest["film"] == number] / SCALE["m"])[people["person"][rows]]
        length = people["height"][rows] / SCALE["px"]
        stretched.append(np.median(np.abs(np.log(length * ahead / (one["focal"] * height)))))  # by the tilt
        feet = (people["top"][rows] + people["height"][rows]) / SCALE["px"] - 240.0
        pitches.append(np.median(feet / one["focal"] - one["mount_height"] / ahead))
    assert np.max(stretched) < get_field().tilt.pitch_std
    assert np.mean(stretched) < 0.01
    assert np.abs(pitches).max() < 5.0 * get_field().tilt.pitch_std
    assert np.std(pitches) > 0.3 * get_field().tilt.pitch_std


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


def test_a_source_is_refused():
    with pytest.raises(VbbenchError, match="does not read `source`"):
        street_film.plan(Options(source=Path("films")))


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
