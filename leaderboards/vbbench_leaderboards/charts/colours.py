"""A solver's colour on the pages: the one that its name has in every picture, told in numbers of the style sheet.

The colours are those of `vbbench.pictures.solver_colours`, the rule's one home; on white those that stand out too
little as small marks are made darker.
"""

from collections.abc import Iterable

from vbbench.pictures.solver_colours import ON_DARK, ON_LIGHT, solver_number

LEAST_CONTRAST = 3.0
"""Of a mark on paper (WCAG 2.2, 1.4.11)."""

_DARKER = 0.98


def colour_number(solver: str) -> int:
    """The number of a solver's colour, from 1 on: of ``--solver-N`` and of the class ``cN``."""
    return solver_number(solver) + 1


def colours_css() -> str:
    """The style sheet of all solvers' colours."""
    light, dark = _declared(map(_for_paper, ON_LIGHT)), _declared(ON_DARK)
    classes = "".join(f".c{n} {{ --c: var(--solver-{n}); }}\n" for n in range(1, len(ON_LIGHT) + 1))
    return (
        "/* One colour for each solver, on white and on dark paper; written by charts/colours.py. */\n"
        f':root {{\n{light}}}\n@media screen {{\n:root[data-theme="dark"] {{\n{dark}}}\n}}\n'
        f'@media screen and (prefers-color-scheme: dark) {{\n:root:not([data-theme="light"]) {{\n{dark}}}\n}}\n'
        f"{classes}"
    )


def contrast(one: str, other: str) -> float:
    """How many times as light the lighter colour is (WCAG 2.2); colours are ``#rrggbb``."""
    low, high = sorted((_luminance(one), _luminance(other)))
    return (high + 0.05) / (low + 0.05)


def _declared(colours: Iterable[str]) -> str:
    return "".join(f"  --solver-{n}: {colour};\n" for n, colour in enumerate(colours, 1))


def _for_paper(colour: str) -> str:
    """The colour, darker by as little as makes it stand out from white."""
    while contrast(colour, "#ffffff") < LEAST_CONTRAST:
        colour = "#" + "".join(f"{int(part * _DARKER):02x}" for part in _parts(colour))
    return colour


def _luminance(colour: str) -> float:
    shares = [part / 255 for part in _parts(colour)]
    linear = [share / 12.92 if share <= 0.04045 else ((share + 0.055) / 1.055) ** 2.4 for share in shares]
    return sum(weight * part for weight, part in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def _parts(colour: str) -> tuple[int, ...]:
    return tuple(int(colour[n : n + 2], 16) for n in (1, 3, 5))
