"""How the pages write numbers and colour solvers."""

import re

import numpy as np
import pytest

from vbbench.pictures.colours import SOLVERS_ON_DARK, SOLVERS_ON_LIGHT, solver_number
from vbbench_leaderboards.site.charts import colour_number, colours_css
from vbbench_leaderboards.site.words import decimals, figure, figure_decimals, padding, percent, signed

FIGURES = {
    0: {5667.0: "5,670"},
    2: {0.786: "0.79", 0.37488: "0.37", 1.244: "1.24", 12.44: "12.4"},
    3: {0.0432: "0.043", 0.9996: "1.00", 124.4: "124", 0.0: "0.000"},
    4: {0.0076: "0.0076", 1.244: "1.24", 0.00001: "<0.0001"},
}
"""Decimals of a column → figure → how it is shown."""


def test_figures_have_two_or_three_digits() -> None:
    assert {most: {value: figure(value, most) for value in own} for most, own in FIGURES.items()} == FIGURES


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


def test_the_style_sheet_has_the_colours_of_all_solvers_by_number() -> None:
    pairs = re.findall(r"--solver-(\d+): light-dark\((#[0-9a-f]{6}), (#[0-9a-f]{6})\);", colours_css())
    assert [(light, dark) for _, light, dark in pairs] == [*zip(SOLVERS_ON_LIGHT, SOLVERS_ON_DARK, strict=True)]
    assert pairs[solver_number("cv")][0] == str(colour_number("cv"))
