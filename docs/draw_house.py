"""Draws the house, ``docs/images/house.svg``: the rooms of every package, each above those that it imports.

``python docs/draw_house.py`` writes the picture; with ``--check`` it only says whether the one there is current.
"""

import argparse
import ast
import sys
from collections.abc import Iterable
from html import escape
from pathlib import Path
from textwrap import wrap
from typing import NamedTuple

import grimp

ROOT = Path(__file__).parents[1]
HOMES = ("", "generators", "renderers", "baselines", "leaderboards")
PICTURE = ROOT / "docs" / "images" / "house.svg"
CORE = "vbbench"
PLUGINS = ("vbbench_generators", "vbbench_renderers", "vbbench_baselines", "vbbench_leaderboards")
WIDTH, BOX, GAP, LINE, RISE, SMALL = 1480, 176, 14, 14, 40, 10
INK, FAINT, PAPER, ROOM, WALL = "#1f2933", "#7b8794", "#ffffff", "#f0f4f8", "#d9e2ec"
Edges = set[tuple[str, str]]


class Room(NamedTuple):
    """A box of the picture: a subpackage, or a module of a package's root."""

    name: str
    says: list[str]

    @property
    def height(self) -> int:
        """In px, with the name on the first line."""
        return 26 + LINE * len(self.says)


def first_sentence(module: str) -> str:
    """The first sentence of the docstring of a module or package."""
    path = Path(*module.split("."))
    places = [ROOT / home / file for home in HOMES for file in (path / "__init__.py", path.with_suffix(".py"))]
    source = next(place for place in places if place.is_file()).read_text(encoding="utf-8")
    summary = (ast.get_docstring(ast.parse(source)) or "").partition("\n\n")[0]
    return " ".join(summary.replace("`", "").split()).partition(". ")[0].rstrip(".")


def rooms_of(package: str, graph: grimp.ImportGraph) -> dict[str, str]:
    """The room of every module below ``package``: the subpackage it lies in, or the module itself."""
    depth = package.count(".") + 2
    inside = graph.find_descendants(package)
    return {module: ".".join(module.split(".")[:depth]) for module in inside}


def imports_between(rooms: dict[str, str], graph: grimp.ImportGraph) -> Edges:
    """Which room imports which."""
    pairs = {
        (room, rooms[other])
        for module, room in rooms.items()
        for other in graph.find_modules_directly_imported_by(module)
        if other in rooms
    }
    return {(above, below) for above, below in pairs if above != below}


def levels(names: Iterable[str], edges: Edges) -> dict[str, int]:
    """How many floors up each room lies: one above the highest that it imports; rooms of a cycle fail."""
    below = {name: {low for high, low in edges if high == name} for name in names}
    found: dict[str, int] = {}
    while len(found) < len(below):
        ready = {name for name in below if name not in found and below[name] <= found.keys()}
        if not ready:
            raise ValueError(f"these import one another in a circle: {', '.join(sorted(below.keys() - found.keys()))}")
        found |= {name: 1 + max((found[low] for low in below[name]), default=-1) for name in ready}
    return found


def shortest(edges: Edges) -> Edges:
    """The edges that do not follow from others (transitive reduction)."""
    reach: dict[str, set[str]] = {}

    def below(name: str) -> set[str]:
        if name not in reach:
            direct = {low for high, low in edges if high == name}
            reach[name] = direct.union(*(below(low) for low in direct))
        return reach[name]

    return {
        (high, low)
        for high, low in edges
        if not any(low in below(other) for first, other in edges if first == high and other != low)
    }


def rect(x: float, y: float, width: float, height: float, fill: str) -> str:
    """A box as SVG."""
    place = f'x="{x:.0f}" y="{y:.0f}" width="{width:.0f}" height="{height:.0f}"'
    return f'<rect {place} rx="6" fill="{fill}" stroke="{WALL}"/>'


def words(x: float, y: float, text: str, size: int, colour: str = FAINT) -> str:
    """A line of text as SVG; large ones are bold."""
    weight = ' font-weight="600"' if size > SMALL else ""
    return f'<text x="{x:.0f}" y="{y:.0f}" font-size="{size}"{weight} fill="{colour}">{escape(text)}</text>'


def draw_package(
    package: str, graph: grimp.ImportGraph, left: float, top: float, width: float
) -> tuple[list[str], float]:
    """One building as SVG, and its height in px."""
    rooms = rooms_of(package, graph)
    names = sorted(set(rooms.values()))
    edges = imports_between(rooms, graph)
    floor = levels(names, edges)
    boxes = {name: Room(name.rpartition(".")[2], wrap(first_sentence(name), 30)[:5]) for name in names}
    across = max(1, int((width - GAP) // (BOX + GAP)))
    rows: list[list[str]] = []
    for level in range(max(floor.values()), -1, -1):
        here = [name for name in names if floor[name] == level]
        rows += [here[first : first + across] for first in range(0, len(here), across)]
    place: dict[str, tuple[float, float]] = {}
    y = top + 34.0
    for row in rows:
        step = (width - GAP) / len(row)
        for number, name in enumerate(row):
            place[name] = left + GAP / 2 + step * (number + 0.5) - BOX / 2, y
        y += max(boxes[name].height for name in row) + RISE
    height = y - top - RISE + GAP
    drawn = [rect(left, top, width, height, PAPER), words(left + GAP, top + 22, package, 15, INK)]
    for high, low in sorted(shortest(edges)):
        (x1, y1), (x2, y2) = place[high], place[low]
        x1, y1, x2 = x1 + BOX / 2, y1 + boxes[high].height, x2 + BOX / 2
        bend = 0.5 * (y2 - y1)
        drawn.append(
            f'<path d="M{x1:.0f} {y1:.0f} C{x1:.0f} {y1 + bend:.0f} {x2:.0f} {y2 - bend:.0f} {x2:.0f} {y2:.0f}" '
            f'fill="none" stroke="{FAINT}" stroke-opacity="0.55"/>'
        )
    for name, (x, at) in place.items():
        room = boxes[name]
        drawn += [rect(x, at, BOX, room.height, ROOM), words(x + 8, at + 17, room.name, 13, INK)]
        drawn += [words(x + 8, at + 32 + LINE * number, line, SMALL) for number, line in enumerate(room.says)]
    return drawn, height


def draw() -> str:
    """The whole picture as SVG."""
    graph = grimp.build_graph(CORE, *PLUGINS, exclude_type_checking_imports=True)
    parts: list[str] = []
    wide = (WIDTH - 3 * GAP) / 2
    y = float(GAP)
    for pair in (PLUGINS[:2], PLUGINS[2:]):
        tallest = 0.0
        for number, package in enumerate(pair):
            drawn, height = draw_package(package, graph, GAP + number * (wide + GAP), y, wide)
            parts += drawn
            tallest = max(tallest, height)
        y += tallest + GAP
    drawn, height = draw_package(CORE, graph, GAP, y, WIDTH - 2 * GAP)
    parts += drawn
    body = "\n".join(parts)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {y + height + GAP:.0f}" '
        f'font-family="system-ui, sans-serif">\n<title>The rooms of vbbench, each above those that it imports</title>\n'
        f"{body}\n</svg>\n"
    )


def main() -> None:
    """Write the picture, or with ``--check`` compare it."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--check", action="store_true", help="write nothing; fail if the picture is out of date")
    check = parser.parse_args().check
    text = draw()
    if not check:
        PICTURE.write_text(text, encoding="utf-8")
    elif not PICTURE.is_file() or PICTURE.read_text(encoding="utf-8") != text:
        sys.exit(f"{PICTURE} is out of date: run 'python docs/draw_house.py'")


if __name__ == "__main__":
    main()
