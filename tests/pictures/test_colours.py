"""Colours of people and solvers: far enough apart for all eyes, and different for those who come near one another."""

import numpy as np
import pytest

from tests.lib.colours import EYES, contrast, least_apart
from vbbench.pictures.colours import (
    LEAST_APART,
    PEOPLE_ON_DARK,
    PEOPLE_ON_LIGHT,
    SOLVERS_ON_LIGHT,
    colour_slots,
    solver_colour,
    solver_looks,
)


@pytest.mark.parametrize("eyes", EYES)
@pytest.mark.parametrize("palette", [PEOPLE_ON_LIGHT, PEOPLE_ON_DARK], ids=["light", "dark"])
def test_no_two_colours_look_alike_to_anybody(palette: tuple[str, ...], eyes: str) -> None:
    assert least_apart(palette, eyes) >= LEAST_APART


@pytest.mark.parametrize(
    ("palette", "paper"), [(PEOPLE_ON_LIGHT, "#ffffff"), (PEOPLE_ON_DARK, "#121518")], ids=["light", "dark"]
)
def test_every_colour_shows_on_its_paper(palette: tuple[str, ...], paper: str) -> None:
    assert min(contrast(colour, paper) for colour in palette) >= 2.9


def test_neighbours_have_different_colours() -> None:
    side = np.arange(10.0)
    places = np.stack(np.meshgrid(side, side), axis=-1).reshape(1, 100, 2)
    slots = colour_slots(np.repeat(places, 3, axis=0))
    apart = np.linalg.norm(places[0, :, None] - places[0, None], axis=-1)
    near = (apart > 0.0) & (apart < 1.5)
    assert not np.any(near & (slots[:, None] == slots[None]))
    assert set(slots.tolist()) == set(range(len(PEOPLE_ON_LIGHT)))


def test_those_who_meet_late_differ_and_those_who_are_never_there_have_a_colour() -> None:
    positions = np.full((50, 12, 2), np.nan)
    positions[:, :2] = np.linspace([[0.0, 0.0], [20.0, 0.0]], [[10.0, 0.0], [10.5, 0.0]], 50)
    slots = colour_slots(positions, count=2)
    assert slots[0] != slots[1]
    assert np.all((slots >= 0) & (slots < 2))
    assert colour_slots(np.empty((5, 0, 2))).shape == (0,)
    assert np.array_equal(slots, colour_slots(positions, count=2))


def test_colours_do_not_depend_on_who_else_is_shown_nor_on_the_process():
    assert solver_looks(["a robot", "cv"])[1].colour == solver_looks(["cv"])[0].colour
    assert solver_colour("a robot") == "#4694b4"
    names = ("cv", "sf", "vb-cv", "vb-sf", "vb-sf-literal", "map-causal", "map-batch")
    bundled = {solver_colour(name) for name in names}
    assert len(bundled) == 7
    others = {solver_colour(f"solver {n}") for n in range(50)}
    assert not others & bundled
    assert others <= set(SOLVERS_ON_LIGHT)
