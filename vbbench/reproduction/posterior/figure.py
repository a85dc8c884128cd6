"""The posteriors as a report: the paper's two claims in numbers, tables, every frame as CSV, and three pictures."""

from collections.abc import Iterator, Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from vbbench.geometry import FloatArray
from vbbench.reproduction.posterior.claims import CLAIMS, estimate_claims
from vbbench.reproduction.posterior.curves_picture import PEOPLE, groups_of, plot_curves
from vbbench.reproduction.posterior.examples_picture import plot_examples
from vbbench.reproduction.posterior.failures import CAUSES, PROTOCOL, SYMBOL, Failure
from vbbench.reproduction.posterior.failures_picture import plot_failures
from vbbench.reproduction.posterior.measuring import PosteriorTable
from vbbench.reproduction.posterior.study import REPORTED, Posteriors, measured_solvers
from vbbench.reproduction.report import Report
from vbbench.reproduction.transfer.agreement import Estimate
from vbbench.table import Table, csv_text

NAME = "figure-posterior"
GAUSSIAN_BEYOND = float(np.exp(-4.5))
"""Probability of a normal density in the plane outside three standard deviations."""
_FIGURES = ("pose", "gaussian", "place", "yaw", "beyond", "kurtosis", "people", "share", "error")
_WALKING = ("people", "spread", "lines", "bearings", "standing")


def posterior_report(found: Posteriors) -> Report:
    """Claims, figures by number of people, examples and failures; a picture of each but the claims."""
    claims = estimate_claims(found)
    pictures = {"": plot_examples(found)} if found.examples else {}
    pictures |= {"curves": plot_curves(found)}
    pictures |= {"failures": plot_failures(found)} if found.failures.shown else {}
    return Report(
        name=NAME,
        title=f"Posteriors of observer and people: split {found.study.split}, one-step, seed {found.study.seed}",
        facts=list(_facts(found)),
        tables=[_claims_table(claims), *_number_tables(found), _examples_table(found), *_failure_tables(found)],
        values=posterior_values(found, claims),
        pictures=pictures,
        texts={".csv": posterior_csv(found)},
    )


def _facts(found: Posteriors) -> Iterator[str]:
    some = "all sequences" if found.study.every == 1 else f"one in {found.study.every}"
    frames = len(found.sample.people)
    yield (
        f"{frames} frames of {found.sequences} sequences ({some}). Left out are frames in which fewer than two people "
        "help, where the observer's own walk decides."
    )
    yield (
        "The paper draws posteriors over ten frames with 3 and with 5 and more people, parallel and crossing, and says "
        "that tails are heavier with few people and that posteriors are sharper where people walk in diverse "
        "directions. Both are tested here with numbers."
    )
    yield (
        "The observer's posterior is exp(−E_c) of the reference solver on a grid of (x, y, yaw) about its minimum, "
        "people's places minimised out; a person's is the belief of the message passing over samples along its ray. "
        "Entropies are in nats, of m² rad for the pose, m² for the place and m for people. The spread "
        "of directions is 1 less the length of the mean direction of everybody who moves, the observer among them; "
        "that of lines counts opposite ways as one; that of bearings is of the directions under which people are seen."
    )
    for solver, what in measured_solvers().items():
        yield f"`{solver}`: {what}."


def _claims_table(claims: Mapping[str, list[Estimate]]) -> Table:
    solvers = list(claims)
    rows = [
        [claim, what, how, *(_estimate(claims[solver][row]) for solver in solvers)]
        for row, (claim, what, how, *_) in enumerate(CLAIMS)
    ]
    return Table(
        title="The paper's claims",
        facts=(
            "ρ: Spearman's rank correlation over frames, with its 95 % interval by a bootstrap of blocks of time. At "
            "equal number: among frames in which as many people are seen. A claim holds where its interval lies on the "
            "side that the claim names: below 0 in every row.",
        ),
        head=["claim", "of", "figure", *(_short(solver) for solver in solvers)],
        rows=rows,
        names=3,
    )


def _short(solver: str) -> str:
    return f"`{solver.rpartition(':')[2]}`"


def _estimate(one: Estimate) -> str:
    return "–" if np.isnan(one.value) else f"{one.value:+.2f} [{one.low:+.2f}, {one.high:+.2f}]"


def _number_tables(found: Posteriors) -> Iterator[Table]:
    group = groups_of(found.walking["people"], PEOPLE)
    for solver, table in found.tables.items():
        columns = {name: found.sample.means(getattr(table, name), group, len(PEOPLE))[0] for name in _FIGURES}
        columns["reported"] = found.sample.means(found.reported, group, len(PEOPLE))[0]
        columns["inside"] = found.sample.means((table.share <= 0.95).astype(float), group, len(PEOPLE))[0]
        rows = [_number_row(n, int((group == n).sum()), columns) for n in range(len(PEOPLE)) if (group == n).any()]
        yield Table(
            title=f"By number of people: {_short(solver)}",
            facts=(
                "Means over sequences. Normal: of a normal density with the same covariance. Beyond 3 σ: mass of the "
                f"place's marginal; {GAUSSIAN_BEYOND:.2%} for a normal one. True place: how often it lies in the "
                "region that holds 95 % of the posterior.",
            ),
            head=[
                "people seen",
                "frames",
                "pose (nats)",
                "normal",
                f"`{REPORTED}`",
                "place",
                "σ of the yaw (°)",
                "a person",
                "beyond 3 σ",
                "kurtosis",
                "true place",
                "Δt (m)",
            ],
            rows=rows,
        )


def _number_row(n: int, frames: int, columns: dict[str, FloatArray]) -> list[str]:
    least, most = PEOPLE[n]
    plain = [f"{columns[name][n]:.2f}" for name in ("pose", "gaussian", "reported", "place")]
    plain += [f"{np.degrees(columns['yaw'][n]):.2f}", f"{columns['people'][n]:.2f}"]
    tails = [f"{columns['beyond'][n]:.2%}", f"{columns['kurtosis'][n]:.2f}"]
    cells = [*plain, *tails, f"{columns['inside'][n]:.0%}", f"{columns['error'][n]:.3f}"]
    return [f"{least}" if least == most else f"{least}–{most}", f"{frames}", *(_dash(cell) for cell in cells)]


def _dash(cell: str) -> str:
    return "–" if "nan" in cell else cell


def _examples_table(found: Posteriors) -> Table:
    rows = []
    for shown in found.examples:
        one = shown.example
        pose, place = (
            np.mean([d.entropy for d in kind])
            for kind in zip(*((instant.density, instant.place) for instant in shown.instants), strict=True)
        )
        frames = f"{one.first}–{one.frames[-1]}"
        figures = [f"{one.people:.1f}", f"{one.spread:.2f}", f"{one.lines:.2f}", f"{pose:.2f}", f"{place:.2f}"]
        error = f"{np.mean([instant.error for instant in shown.instants]):.3f}"
        rows.append([one.title, f"{one.sequence}", frames, *figures, error])
    return Table(
        title="The examples",
        facts=(
            "Picked from all stretches of ten frames. Few people: at least 3 in every frame, and at most as many as "
            "the sparsest stretch has. Parallel: the least spread of directions; crossing: the greatest product of the "
            "spreads of directions and of lines. Of equals, the first.",
        ),
        head=["example", "sequence", "frames", "people", "spread", "of lines", "pose (nats)", "place", "Δt (m)"],
        rows=rows,
    )


def _failure_tables(found: Posteriors) -> Iterator[Table]:
    failures = found.failures
    rows = [_failure_row(one) for one, _ in failures.shown]
    yield Table(
        title="Where it fails",
        facts=(
            f"`{failures.solver}`, {PROTOCOL}: the sequences of greatest {SYMBOL}, capped at {failures.cap:g} m; among "
            "those above the cap, of greatest error; none shares frames with one above it.",
        ),
        head=[
            "sequence",
            f"{SYMBOL} (m)",
            "Δt (m)",
            "people",
            "spread",
            "of bearings",
            "stand",
            "new in a frame",
            "empty frames",
            "causes",
        ],
        rows=rows,
    )
    worst, every = failures.worst, failures.failures
    yield Table(
        title="What the worst have in common",
        facts=(f"The worst tenth: {len(worst)} sequences, from {worst[-1].error:.2f} m on.",),
        head=["cause", "that is", "of the worst tenth", "of all"],
        rows=[
            [name, text, f"{failures.share(name, worst):.0%}", f"{failures.share(name, every):.0%}"]
            for name, (text, _) in CAUSES.items()
        ],
        names=2,
    )


def _failure_row(one: Failure) -> list[str]:
    facts = one.facts
    errors = [f"{one.error:.2f}", f"{one.observer_error:.2f}"]
    kind = [f"{facts.people:.1f}", f"{facts.spread:.2f}", f"{facts.bearings:.2f}", f"{facts.standing:.0%}"]
    kind += [f"{facts.arrivals:.2f}", f"{facts.empty}"]
    return [f"{one.sequence}", *errors, *kind, ", ".join(one.causes) or "–"]


def posterior_values(found: Posteriors, claims: Mapping[str, list[Estimate]]) -> dict[str, Any]:
    """Every number but those of single frames, which the CSV has."""
    group = groups_of(found.walking["people"], PEOPLE)
    return {
        "split": found.study.split,
        "every": found.study.every,
        "seed": found.study.seed,
        "sequences": found.sequences,
        "frames": len(found.sample.people),
        "claims": {
            solver: [
                {"claim": claim, "of": what, "figure": how} | vars(one)
                for (claim, what, how, *_), one in zip(CLAIMS, estimates, strict=True)
            ]
            for solver, estimates in claims.items()
        },
        "by_people": {
            solver: {name: _by_people(found, getattr(table, name), group) for name in _FIGURES}
            for solver, table in found.tables.items()
        }
        | {REPORTED: {"pose": _by_people(found, found.reported, group)}},
        "examples": [vars(shown.example) for shown in found.examples],
        "failures": [
            {"sequence": one.sequence, "dx": one.error, "dt": one.observer_error, "causes": list(one.causes)}
            | vars(one.facts)
            for one in found.failures.worst
        ],
    }


def _by_people(found: Posteriors, values: FloatArray, group: Any) -> list[dict[str, float]]:
    mean, interval = found.sample.means(values, group, len(PEOPLE))
    return [
        {"least": least, "most": most, "mean": m, "low": low, "high": high}
        for (least, most), m, (low, high) in zip(PEOPLE, mean.tolist(), interval.tolist(), strict=True)
    ]


def posterior_csv(found: Posteriors) -> str:
    """A row for each solver and frame."""
    names = [field.name for field in fields(PosteriorTable)]
    # "people" of the walking is a number, of the table an entropy.
    head = ("solver", *("entropy_of_people" if name == "people" else name for name in names), *_WALKING)
    walking = [found.walking[name].tolist() for name in _WALKING]
    rows = (
        [solver, *row]
        for solver, table in found.tables.items()
        for row in zip(*(getattr(table, name).tolist() for name in names), *walking, strict=True)
    )
    return csv_text(head, rows)
