"""A solver's colour on the pages: the one that its name has in every picture, told in numbers of the style sheet.

The colours on white are those of `vbbench.pictures.plotting.solver_colours`, the rule's one home; a page that turns
dark needs its own, of the same hues.
"""

from collections.abc import Iterable

DARK = (
    *("#a8692c", "#f4cdf4", "#4b9df5", "#55e6a0", "#6460ea", "#ffa03c", "#8a6ab8"),
    *("#d83a80", "#74cc3a", "#58c4e0", "#d080f0", "#f8b0b8"),
)
"""On dark paper, in the order of ``PALETTE``: the nearest two of the bundled solvers are 0.09 of OKLab apart for
readers who see no red, no green or no blue (Machado et al., IEEE TVCG 15, 2009)."""

LEAST_CONTRAST = 3.0
"""Of a mark on paper (WCAG 2.2, 1.4.11)."""

_DARKER = 0.98


def colour_number(solver: str) -> int:
    """The number of a solver's colour, from 1 on: of ``--solver-N`` and of the class ``cN``."""
    from vbbench.pictures.plotting.solver_colours import solver_number

    return solver_number(solver) + 1


def colours_css() -> str:
    """The style sheet of all solvers' colours."""
    from vbbench.pictures.plotting.solver_colours import PALETTE

    light, dark = _declared(map(_for_paper, PALETTE)), _declared(DARK)
    classes = "".join(f".c{n} {{ --c: var(--solver-{n}); }}\n" for n in range(1, len(PALETTE) + 1))
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
