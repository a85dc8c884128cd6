"""Colours of people: far enough apart for all eyes, and different for those who come near one another."""

import numpy as np
import pytest

from vbbench.pictures.people_colours import LEAST_APART, ON_DARK, ON_LIGHT, colour_slots

# Machado, Oliveira and Fernandes 2009, table 1, severity 1, on linear RGB
EYES = {
    "all cones": np.eye(3),
    "no red": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "no green": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "no blue": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}
# Ottosson 2020: linear sRGB to cone responses, and their cube roots to Oklab
CONES = [[0.4122214708, 0.5363325363, 0.0514459929], [0.2119034982, 0.6806995451, 0.1073969566]]
CONES.append([0.0883024619, 0.2817188376, 0.6299787005])
OKLAB = [[0.2104542553, 0.7936177850, -0.0040720468], [1.9779984951, -2.4285922050, 0.4505937099]]
OKLAB.append([0.0259040371, 0.7827717662, -0.8086757660])


def linear(names: tuple[str, ...]) -> np.ndarray:
    shares = np.array([list(bytes.fromhex(name[1:])) for name in names]) / 255.0
    return np.where(shares <= 0.04045, shares / 12.92, ((shares + 0.055) / 1.055) ** 2.4)


@pytest.mark.parametrize("eyes", EYES)
@pytest.mark.parametrize("palette", [ON_LIGHT, ON_DARK], ids=["light", "dark"])
def test_no_two_colours_look_alike_to_anybody(palette: tuple[str, ...], eyes: str) -> None:
    seen = np.clip(linear(palette) @ np.transpose(EYES[eyes]), 0.0, 1.0)
    lab = np.cbrt(seen @ np.transpose(CONES)) @ np.transpose(OKLAB)
    apart = np.linalg.norm(lab[:, None] - lab[None], axis=-1) + np.eye(len(palette))
    assert apart.min() >= LEAST_APART


@pytest.mark.parametrize(("palette", "paper"), [(ON_LIGHT, "#ffffff"), (ON_DARK, "#121518")], ids=["light", "dark"])
def test_every_colour_shows_on_its_paper(palette: tuple[str, ...], paper: str) -> None:
    light, ground = linear(palette) @ [0.2126, 0.7152, 0.0722], (linear((paper,)) @ [0.2126, 0.7152, 0.0722])[0]
    assert np.all((np.maximum(light, ground) + 0.05) / (np.minimum(light, ground) + 0.05) >= 2.9)


def test_neighbours_have_different_colours() -> None:
    side = np.arange(10.0)
    places = np.stack(np.meshgrid(side, side), axis=-1).reshape(1, 100, 2)
    slots = colour_slots(np.repeat(places, 3, axis=0))
    apart = np.linalg.norm(places[0, :, None] - places[0, None], axis=-1)
    near = (apart > 0.0) & (apart < 1.5)
    assert not np.any(near & (slots[:, None] == slots[None]))
    assert set(slots.tolist()) == set(range(len(ON_LIGHT)))


def test_those_who_meet_late_differ_and_those_who_are_never_there_have_a_colour() -> None:
    positions = np.full((50, 12, 2), np.nan)
    positions[:, :2] = np.linspace([[0.0, 0.0], [20.0, 0.0]], [[10.0, 0.0], [10.5, 0.0]], 50)
    slots = colour_slots(positions, count=2)
    assert slots[0] != slots[1]
    assert np.all((slots >= 0) & (slots < 2))
    assert colour_slots(np.empty((5, 0, 2))).shape == (0,)
    assert np.array_equal(slots, colour_slots(positions, count=2))
