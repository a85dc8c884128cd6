"""Colours of people and solvers: far enough apart for all eyes, and different for those who come near one another."""

import numpy as np
import pytest

from tests.lib.colours import EYES, contrast, least_apart
from vbbench.pictures.colours import (
    LEAST_APART,
    PEOPLE_ON_DARK,
    PEOPLE_ON_LIGHT,
    SOLVERS_ON_DARK,
    SOLVERS_ON_LIGHT,
    colour_slots,
    numbers_apart,
    solver_colour,
    solver_looks,
    solver_number,
)

BUNDLED = ("cv", "sf", "vb-cv", "vb-sf", "vb-sf-literal", "map-causal", "map-batch")
PALETTES = {
    "people on light": (PEOPLE_ON_LIGHT, "#ffffff", 2.9),
    "people on dark": (PEOPLE_ON_DARK, "#121518", 2.9),
    "solvers on light": (SOLVERS_ON_LIGHT, "#ffffff", 3.0),
    "solvers on dark": (SOLVERS_ON_DARK, "#121518", 3.0),
}
"""The colours, the paper, and the least contrast between them."""


@pytest.mark.parametrize("name", PALETTES)
def test_colours_stand_out_from_their_paper_and_from_one_another(name: str) -> None:
    """For all eyes; of solvers those that come with vbbench."""
    palette, paper, least = PALETTES[name]
    assert min(contrast(colour, paper) for colour in palette) >= least
    shown, apart = (palette[: len(BUNDLED)], 0.05) if "solvers" in name else (palette, LEAST_APART)
    assert min(least_apart(shown, eyes) for eyes in EYES) >= apart


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


def test_colours_do_not_depend_on_who_else_is_shown_nor_on_the_process() -> None:
    assert solver_looks(["a robot", "cv"])[1].colour == solver_looks(["cv"])[0].colour
    assert solver_colour("a robot") == "#4694b4"
    assert [solver_number(name) for name in BUNDLED] == [*range(len(BUNDLED))]
    later = {solver_number("vb-former"), solver_number("ground-plane")}
    assert len(later) == 2
    strangers = {solver_number(f"solver {n}") for n in range(200)}
    assert strangers == set(range(len(BUNDLED), len(SOLVERS_ON_LIGHT))) - later


def test_answers_next_to_one_another_have_different_colours() -> None:
    twice = numbers_apart(["vb-cv", "vb-sf", "vb-cv"])
    assert twice[:2] == [solver_number("vb-cv"), solver_number("vb-sf")]
    assert len(set(twice)) == 3
    assert sorted(numbers_apart(["cv"] * 30)[: len(SOLVERS_ON_LIGHT)]) == list(range(len(SOLVERS_ON_LIGHT)))
