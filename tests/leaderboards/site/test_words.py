"""How the pages write numbers and colour solvers: the same everywhere, and told apart by everybody."""

import itertools
import re

import numpy as np
import pytest

from vbbench.geometry import FloatArray
from vbbench.pictures.solver_colours import ON_DARK, ON_LIGHT, numbers_apart, solver_number
from vbbench_leaderboards.site.charts import LEAST_CONTRAST, colour_number, colours_css, contrast
from vbbench_leaderboards.site.words import decimals, figure, figure_decimals, padding, percent, signed

BUNDLED = ("cv", "sf", "vb-cv", "vb-sf", "vb-sf-literal", "map-causal", "map-batch")
PAPERS = {"white": "#ffffff", "dark": "#121518"}


@pytest.mark.parametrize(
    ("value", "most", "shown"),
    [
        (0.786, 2, "0.79"),
        (0.37488, 2, "0.37"),
        (1.244, 2, "1.24"),
        (1.244, 4, "1.24"),
        (0.0432, 3, "0.043"),
        (0.0076, 4, "0.0076"),
        (12.44, 2, "12.4"),
        (124.4, 3, "124"),
        (5667.0, 0, "5,670"),
        (0.9996, 3, "1.00"),
        (0.0, 3, "0.000"),
        (0.00001, 4, "<0.0001"),
    ],
)
def test_figures_have_two_or_three_digits(value: float, most: int, shown: str) -> None:
    assert figure(value, most) == shown


@pytest.mark.parametrize(
    ("values", "most"), [([0.66, 1.9], 2), ([0.036, 0.1], 3), ([0.0076, 0.04], 4), ([1e-7], 4), ([], 2), ([np.inf], 2)]
)
def test_a_column_has_the_decimals_that_its_smallest_figure_needs(values: list[float], most: int) -> None:
    assert decimals(values) == most


def test_points_of_a_column_stand_in_line() -> None:
    values = [0.0432, 0.786, 1.244, 12.44, 124.4]
    whole = [figure(value, 3) + padding(value, 3) for value in values]
    assert {len(text.partition(".")[2]) for text in whole} == {3}
    assert (padding(1.244, 3), padding(124.4, 3)) == ("0", ".000")
    assert [figure_decimals(value, 3) for value in values] == [3, 3, 2, 1, 0]


def test_differences_have_their_sign() -> None:
    assert (signed(0.43, 2), signed(-1.244, 2), signed(0.0, 2)) == ("+0.43", "−1.24", "+0.00")


def test_nothing_but_all_is_a_hundred_percent() -> None:
    shares = (1.0, 0.99995, 0.9995, 0.9933, 0.5, 0.025, 0.0)
    assert [percent(share) for share in shares] == ["100 %", "99.995 %", "99.95 %", "99.3 %", "50 %", "2.5 %", "0 %"]


def test_a_colour_is_told_by_the_name_alone() -> None:
    assert len({colour_number(name) for name in BUNDLED}) == len(BUNDLED)
    strangers = [colour_number(f"solver {n}") for n in range(200)]
    assert set(strangers) == set(range(len(BUNDLED) + 1, len(ON_LIGHT) + 1))
    assert [colour_number(name) for name in BUNDLED] == [solver_number(name) + 1 for name in BUNDLED]


def test_answers_beside_one_another_have_different_colours() -> None:
    twice = numbers_apart(["vb-cv", "vb-sf", "vb-cv"])
    assert twice[:2] == [solver_number("vb-cv"), solver_number("vb-sf")]
    assert len(set(twice)) == 3
    assert sorted(numbers_apart(["cv"] * 30)[: len(ON_LIGHT)]) == list(range(len(ON_LIGHT)))


def declared() -> list[list[str]]:
    """The colours on white and on dark paper."""
    pairs = re.findall(r"--solver-\d+: light-dark\((#[0-9a-f]{6}), (#[0-9a-f]{6})\);", colours_css())
    return [[pair[n] for pair in pairs] for n in (0, 1)]


def test_colours_stand_out_from_the_paper() -> None:
    light, dark = declared()
    assert dark == list(ON_DARK)
    for colours, paper in ((light, PAPERS["white"]), (dark, PAPERS["dark"])):
        assert len(colours) == len(ON_LIGHT)
        assert all(contrast(colour, paper) >= LEAST_CONTRAST for colour in colours)


@pytest.mark.parametrize("place", [0, 1], ids=PAPERS)
def test_bundled_solvers_stay_apart_for_readers_who_see_fewer_colours(place: int) -> None:
    colours = declared()[place][: len(BUNDLED)]
    for seen in SEEN:
        labs = [oklab(np.clip(seen @ linear(colour), 0, 1)) for colour in colours]
        assert min(float(np.linalg.norm(a - b)) for a, b in itertools.combinations(labs, 2)) > 0.05


SEEN = [
    np.eye(3),
    np.array([[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]),
    np.array([[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.01182, 0.04294, 0.968881]]),
    np.array([[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.3039]]),
]
"""What all see, and who sees no red, no green, no blue: Machado et al., IEEE TVCG 15, 2009, severity 1."""

_LMS = np.array(
    [
        [0.4122214708, 0.5363325363, 0.0514459929],
        [0.2119034982, 0.6806995451, 0.1073969566],
        [0.0883024619, 0.2817188376, 0.6299787005],
    ]
)
_LAB = np.array(
    [
        [0.2104542553, 0.7936177850, -0.0040720468],
        [1.9779984951, -2.4285922050, 0.4505937099],
        [0.0259040371, 0.7827717662, -0.8086757660],
    ]
)


def linear(colour: str) -> FloatArray:
    parts = np.array([int(colour[n : n + 2], 16) / 255 for n in (1, 3, 5)])
    return np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)


def oklab(rgb: FloatArray) -> FloatArray:
    """Ottosson, A perceptual color space for image processing, 2020."""
    found: FloatArray = _LAB @ np.cbrt(_LMS @ rgb)
    return found
