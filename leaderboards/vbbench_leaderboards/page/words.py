"""What the metrics, protocols and tiers are, in the words of the page."""

from dataclasses import dataclass
from functools import cache

from vbbench.generation.footage import FOOTAGE
from vbbench.generation.tier import all_tiers
from vbbench.scoring.metrics import Metric, section


@dataclass(frozen=True, kw_only=True)
class Term:
    """A word of the page: its short name, its name in full, its unit, and what it means."""

    name: str
    full: str
    unit: str = ""
    meaning: str


def error_terms() -> dict[str, Term]:
    """The metrics that boards show first, with their intervals, in the order of the paper's tables."""
    return {name: _term(metric) for name, metric in section("metrics").items()}


def drift_terms() -> dict[str, Term]:
    """The metrics of motion over a second."""
    return {name: _term(metric) for name, metric in section("drift").items()}


def _term(metric: Metric) -> Term:
    return Term(name=metric.symbol, full=metric.name, unit=metric.unit, meaning=metric.meaning)


COLUMNS = {
    "rank": Term(
        name="Rank",
        full="rank",
        meaning="One more than the number of solvers that are significantly better by the capped mean of the metric "
        "that the table is sorted by, but never above a solver with a smaller mean; beside it the best and the worst "
        "rank that the figures leave open. Solvers that "
        "see the future, and those trained or tuned on recordings of the board, are ranked apart.",
    ),
    "failures": Term(
        name="Failures",
        full="failures",
        meaning="The share of sequences that go astray: their mean Δx is over 1 m.",
    ),
    "coverage": Term(
        name="Coverage", full="coverage", meaning="The share of scored rows that the solver answered. Read it first."
    ),
    "time": Term(
        name="Time",
        full="time per frame",
        unit="µs",
        meaning="Time inside the solver, in millionths of a second per frame, on the hardware named in the row.",
    ),
    "timing": Term(
        name="Causal or offline",
        full="causal or offline",
        meaning="Causal: an answer depends on its own frame and earlier ones alone. Late: it comes so many frames "
        "after its own. Offline: it depends on the whole sequence.",
    ),
}

SUMMARIES = {
    "median": Term(name="median", full="median", meaning="Half of the sequences have a smaller mean error than this."),
    "mean": Term(
        name="plain mean",
        full="plain mean",
        meaning="The mean over sequences without a cap: a single runaway can decide it, so it ranks nobody.",
    ),
    "p95": Term(
        name="p95", full="95th percentile", meaning="One sequence in twenty has a larger mean error than this."
    ),
}

PROTOCOLS = {
    "one-step": Term(
        name="one-step",
        full="One step",
        meaning="The truth of the two frames before is given for every frame; the solver answers the next. A "
        "diagnostic: nobody has the truth of the frame before.",
    ),
    "sequential": Term(
        name="sequential",
        full="Sequential",
        meaning="Everybody's first two frames are given; from there on the solver stands on its own estimates.",
    ),
    "rollout": Term(
        name="rollout",
        full="Rollout",
        meaning="Only the sequence's first two frames are given; who comes later comes with nothing but a box.",
    ),
    "cold-start": Term(
        name="cold-start",
        full="Cold start",
        meaning="Only where the observer is in the first frame is given, and where nobody is: what a robot has.",
    ),
}

_FOOTAGE = Term(
    name=FOOTAGE,
    full="Footage",
    meaning="What a real camera saw, with boxes and places by hand.",
)


@cache
def tiers() -> dict[str, Term]:
    """Every tier that is installed here, in the registry's order, by name, and footage."""
    found = ((tier.name, tier.summary) for tier in all_tiers())
    return {name: Term(name=name, full=name.capitalize(), meaning=summary) for name, summary in found} | {
        FOOTAGE: _FOOTAGE
    }


def term_of(words: dict[str, Term], key: str) -> Term:
    """The term of a key; a stranger's protocol or tier goes by its own name."""
    return words.get(key, Term(name=key, full=key, meaning=""))
