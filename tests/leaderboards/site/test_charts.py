"""Charts: values lie where they should, marks say their figures, and hostile names stay text."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vbbench_leaderboards.site.charts import Axis, distribution, scatter
from vbbench_leaderboards.site.pages import render
from vbbench_leaderboards.site.words import error_terms

SVG = "{http://www.w3.org/2000/svg}"
HOSTILE = '<script>alert("1")</script>&\''


Point = tuple[str, int, float, tuple[float, float] | None, float]
DX = error_terms()["dx"]


def point(solver: str, error: float, micros: float, colour: int = 1) -> Point:
    return solver, colour, error, (error * 0.9, error * 1.1), micros


def parsed(svg: str) -> ElementTree.Element:
    return ElementTree.fromstring(str(svg).replace("<svg ", '<svg xmlns="http://www.w3.org/2000/svg" ', 1))  # noqa: S314


def marks(svg: str) -> list[ElementTree.Element]:
    return [group for group in parsed(svg).iter(f"{SVG}g") if "mark" in group.get("class", "")]


@given(st.lists(st.floats(1e-5, 1e4), min_size=1, max_size=8), st.booleans())
def test_an_axis_holds_its_values_in_order(values: list[float], log: bool) -> None:
    axis = Axis.over(values, 0.0, 100.0, log=log)
    placed = [axis.place(value) for value in sorted(values)]
    assert placed == sorted(placed)
    assert all(0.0 <= place <= 100.0 for place in placed)
    ticks = axis.ticks
    assert len(ticks) <= 8
    assert all(axis.low * 0.99 <= tick <= axis.high * 1.01 for tick in ticks)


def test_every_point_is_reached_and_says_its_figures() -> None:
    svg = scatter("x", DX, [point("fast", 0.2, 10.0), point("good", 0.05, 900.0, 2)])
    found = marks(svg)
    assert [mark.get("tabindex") for mark in found] == ["0", "0"]
    assert [mark.get("data-solver") for mark in found] == ["good", "fast"]
    assert "Δx 0.0500 m, 95 % interval 0.0450 to 0.0550; 900 µs per frame" in found[0].get("aria-label", "")
    good, fast = (next(mark.iter(f"{SVG}circle")) for mark in found)
    assert float(good.get("cx", 0)) > float(fast.get("cx", 0))
    assert float(good.get("cy", 0)) > float(fast.get("cy", 0))


@pytest.mark.parametrize("apart", [(1e-4, 1.0), (2e-2, 30.0), (1e-2, -20.0)])
def test_names_of_neighbours_keep_apart(apart: tuple[float, float]) -> None:
    points = [point(f"solver {n}", 0.1 + n * apart[0], 200.0 + n * apart[1]) for n in range(5)]
    boxes = []
    for drawn in marks(scatter("x", DX, points)):
        text, circle = next(drawn.iter(f"{SVG}text")), next(drawn.iter(f"{SVG}circle"))
        x, width = float(text.get("x", 0)), 7.0 * len(text.text or "")
        start = x - width if text.get("text-anchor") == "end" else x
        boxes.append((start, start + width, float(text.get("y", 0))))
        across = float(circle.get("cx", 0))
        boxes.append((across - 5, across + 5, float(circle.get("cy", 0)) + 4))
    names = boxes[::2]
    for i, (start, end, height) in enumerate(names):
        others = [*names[:i], *names[i + 1 :], *boxes[1::2]]
        assert not any(start < stop and begin < end and abs(height - y) < 14 for begin, stop, y in others)


def test_a_chart_has_a_title_and_a_description() -> None:
    for svg in (
        scatter("x", DX, [point("a", 0.1, 1.0)]),
        distribution("y", DX, [("a", 1, np.ones(3))]),
        render("task.svg"),
    ):
        root = parsed(svg)
        ids = [next(root.iter(SVG + name)).get("id") for name in ("title", "desc")]
        assert (root.get("aria-labelledby") or "").split() == ids
        assert all((next(root.iter(SVG + name)).text or "").strip() for name in ("title", "desc"))


@pytest.mark.parametrize("count", [1, 7, 340])
def test_a_distribution_has_a_hundred_dots_a_solver(count: int) -> None:
    values = np.random.default_rng(count).lognormal(-3.0, 1.0, count)
    svg = distribution("x", DX, [("a", 1, values)])
    path = next(path for path in parsed(svg).iter(f"{SVG}path") if path.get("class") == "dots").get("d", "")
    assert path.count("M") == 100
    assert len(set(re.findall(r"M\S+ \S+?h0", path))) == 100, "no dot hides another"
    assert f"{count} sequences" in svg


def test_names_stay_text_and_colours_come_from_the_page() -> None:
    svg = scatter("x", DX, [point(HOSTILE, 0.1, 1.0)])
    assert "<script" not in svg
    assert marks(svg)[0].get("data-solver") == HOSTILE
    assert not re.search(r"#[0-9a-f]{3,6}\b|rgb\(|style=", svg)
