"""The study of transfer as a report: tables, every number, and a picture of error against error."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

from vbbench.pictures.plotting import style
from vbbench.pictures.plotting.style import lay_out
from vbbench.reproduction.report import Report
from vbbench.reproduction.transfer.agreement import Agreement, Estimate
from vbbench.reproduction.transfer.study import Case, Comparison, TransferStudy
from vbbench.scoring.metrics import METRICS
from vbbench.table import Table

NAME = "transfer"
TARGETS = {
    "spearman": ("Spearman", "≥ .80"),
    "spearman_without_feet": ("without feet", "≥ .70"),
    "alike": ("pairs alike", "≥ .90"),
    "alike_without_feet": ("without feet", ""),
    "ratio": ("error ratio", ".67 to 1.50"),
    "regret": ("regret", "≤ 1.15"),
}
"""Titles of the figures of `Agreement`, and what is fair to ask of each."""


def spoken(case: Case) -> str:
    """A case as text."""
    frames = "every frame" if case.every == 1 else f"every {case.every}th frame"
    return f"{frames}, {case.protocol}, {METRICS[case.metric].label}"


def transfer_report(study: TransferStudy, found: Sequence[Comparison]) -> Report:
    """How alike they rank, a row a case, and below every variant's errors."""
    heads = [title for title, _ in TARGETS.values()]
    asked = [target for _, target in TARGETS.values()]
    ranks = Table(
        title="How alike they rank",
        facts=[
            "In brackets: 95 % intervals by blocks of time of both datasets. "
            "KITTI's halves: Spearman of its odd runs with its even ones."
        ],
        head=["", *heads, "KITTI's halves", "pairs that KITTI separates", "blocks, field and KITTI"],
        rows=[["asked", *asked, "", "", ""], *map(_agreement_row, found)],
    )
    errors = Table(
        title="Errors",
        head=["field / KITTI, capped means", *(spoken(one.case) for one in found)],
        rows=[_errors_row(n, name, found) for n, name in enumerate(study.variants)],
    )
    return Report(
        name=NAME,
        title=_title(study),
        tables=[ranks, errors],
        values=transfer_values(study, found),
        pictures={"": plot_transfer(study, found)},
    )


def _title(study: TransferStudy) -> str:
    asked = f"{len(study.variants)} solvers and variants, seed {study.seed}"
    walks = f", walks smoothed by up to {study.smooth:g} m" if study.smooth else ""
    return f"Does tier field rank as KITTI does? {asked}{walks}"


def _agreement_row(one: Comparison) -> list[str]:
    values: Agreement = one.agreement
    cells = [_cell(getattr(values, name)) for name in TARGETS]
    count = len(one.real.values)
    pairs = f"{values.separated} of {count * (count - 1) // 2}"
    return [spoken(one.case), *cells, f"{values.halves:.2f}", pairs, f"{values.blocks[0]}, {values.blocks[1]}"]


def _errors_row(row: int, name: str, found: Sequence[Comparison]) -> list[str]:
    return [f"`{name}`", *(f"{one.made.means[row]:.3f} / {one.real.means[row]:.3f}" for one in found)]


def _cell(figure: Estimate) -> str:
    return "–" if np.isnan(figure.value) else f"{figure.value:.2f} [{figure.low:.2f}, {figure.high:.2f}]"


def transfer_values(study: TransferStudy, found: Sequence[Comparison]) -> dict[str, Any]:
    """Every number."""
    return {
        "variants": {name: asdict(variant) for name, variant in study.variants.items()},
        "seed": study.seed,
        "smooth": study.smooth,
        "cases": [_case_values(study, one) for one in found],
    }


def _case_values(study: TransferStudy, one: Comparison) -> dict[str, Any]:
    values = one.agreement
    figures = {name: vars(getattr(values, name)) for name in TARGETS}
    means = zip(study.variants, one.made.means.tolist(), one.real.means.tolist(), strict=True)
    return {
        **one.case._asdict(),
        **figures,
        "halves": values.halves,
        "pairs_separated": values.separated,
        "blocks": list(values.blocks),
        "sequences": [one.made.values.shape[1], one.real.values.shape[1]],
        "errors": {name: {"field": made, "kitti": real} for name, made, real in means},
    }


_PANEL, _LEFT, _FOOT, _HEAD, _KEY = 3.1, 0.65, 0.55, 0.65, 2.4
_STEP = (3.7, 4.05)
"""Inches from a panel to the next one across and downwards."""
_COLOURS = ("#56b4e9", "#009e73", "#0072b2", "#d55e00", "#cc79a7", "#444444", "#e69f00")


def plot_transfer(study: TransferStudy, found: Sequence[Comparison]) -> Figure:
    """A panel for each case: a numbered point a variant, its error on field across and on KITTI upwards."""
    columns = max(1, -(-len(found) // 2))
    size = (_LEFT + columns * _STEP[0] + _KEY, _HEAD + 2 * _STEP[1])
    places = {
        spoken(one.case): (_LEFT + n // 2 * _STEP[0], _FOOT + (1 - n % 2) * _STEP[1], _PANEL, _PANEL)
        for n, one in enumerate(found)
    }
    figure = lay_out(size, places)
    for axes, one in zip(figure.axes, found, strict=True):
        _draw_panel(axes, one, study)
    look: dict[str, Any] = {"color": style.INK, "va": "top"}
    x, height = _LEFT / size[0], size[1]
    figure.text(x, 1 - 0.18 / height, "Does tier field rank as KITTI does?", fontsize=12.5, weight="bold", **look)
    facts = "mean of each sequence's error, at most 2 m; lines: 95 % intervals by blocks; hollow: relies on feet"
    figure.text(x, 1 - 0.46 / height, facts, fontsize=style.TEXT_SIZE, **look)
    _draw_key(figure, size, study)
    return figure


def _draw_panel(axes: Axes, one: Comparison, study: TransferStudy) -> None:
    made, real = one.made.means, one.real.means
    spreads = [np.quantile(errors.resampled(500, 0), (0.025, 0.975), axis=0) for errors in (one.made, one.real)]
    axes.set_xscale("log")
    axes.set_yscale("log")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_locator(NullLocator())
    low, high = 0.8 * min(made.min(), real.min()), 1.25 * max(made.max(), real.max())
    axes.plot([low, high], [low, high], color=style.TRUTH_FAINT, linewidth=1.0, zorder=0)
    for n, (name, variant) in enumerate(study.variants.items()):
        colour = _colour(name, study)
        axes.plot(spreads[0][:, n], [real[n]] * 2, color=colour, alpha=0.2, linewidth=0.8, zorder=1)
        axes.plot([made[n]] * 2, spreads[1][:, n], color=colour, alpha=0.2, linewidth=0.8, zorder=1)
        face = "white" if variant.feet else colour
        axes.plot(made[n], real[n], "o", color=colour, markerfacecolor=face, markersize=4.5, zorder=2)
        shift: dict[str, Any] = {"xytext": (3.0, 2.0), "textcoords": "offset points"}
        axes.annotate(str(n + 1), (made[n], real[n]), fontsize=style.LABEL_SIZE, color=style.INK, **shift)
    axes.set_xlim(low, high)
    axes.set_ylim(low, high)
    rank = one.agreement.spearman
    title = f"{spoken(one.case)}\nSpearman {rank.value:.2f} [{rank.low:.2f}, {rank.high:.2f}]"
    axes.set_title(title, fontsize=style.TEXT_SIZE, color=style.INK)
    axes.set_xlabel("on field", fontsize=style.TEXT_SIZE)
    axes.set_ylabel("on KITTI", fontsize=style.TEXT_SIZE)
    axes.grid(color=style.FAINT, linewidth=0.6)


def _draw_key(figure: Figure, size: tuple[float, float], study: TransferStudy) -> None:
    gap, top = min(0.22, (size[1] - _HEAD) / len(study.variants)), _HEAD + 0.45
    for n, name in enumerate(study.variants):
        place = 1 - (_KEY - 0.1) / size[0], 1 - (top + n * gap) / size[1]
        figure.text(*place, f"{n + 1}  {name}", fontsize=style.TEXT_SIZE, color=_colour(name, study), va="center")


def _family(name: str) -> str:
    """``vb-cv`` of ``vb-cv-noise-4``."""
    parts = name.split("-")
    return "-".join(parts[: 2 if parts[0] in ("vb", "map") else 1])


def _colour(name: str, study: TransferStudy) -> str:
    families = list(dict.fromkeys(map(_family, study.variants)))
    return _COLOURS[families.index(_family(name)) % len(_COLOURS)]
