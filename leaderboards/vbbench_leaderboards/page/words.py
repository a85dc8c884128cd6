"""What the metrics, protocols and tiers are, in the words of the page."""

from dataclasses import dataclass
from functools import cache

from vbbench.generation.tier import all_tiers


@dataclass(frozen=True, kw_only=True)
class Term:
    """A word of the page: its short name, its name in full, its unit, and what it means."""

    name: str
    full: str
    unit: str = ""
    meaning: str


METRICS = {
    "dx_rel": Term(
        name="Δx̃",
        full="relative position",
        unit="m",
        meaning="How far people are from their true places as seen from the camera: the estimated camera is laid upon "
        "the true one, without turning it. Mean over people and frames of each sequence, then over sequences.",
    ),
    "dx": Term(
        name="Δx",
        full="position",
        unit="m",
        meaning="How far people are from their true places in the world. Mean over people and frames of each sequence, "
        "then over sequences.",
    ),
    "dr": Term(
        name="Δr",
        full="heading",
        unit="rad",
        meaning="How far the camera's heading is turned from the true one. A hundredth of a radian is 0.6 degrees.",
    ),
    "dt": Term(name="Δt", full="camera", unit="m", meaning="How far the camera is from its true place in the world."),
}
"""The metrics that boards are ranked by, in the order of the paper's tables."""

DRIFTS = {
    "drift_m": Term(
        name="drift",
        full="drift",
        unit="m/s",
        meaning="How far the camera's estimated motion over one second departs from the true motion.",
    ),
    "drift_rad": Term(
        name="turn",
        full="drift of heading",
        unit="rad/s",
        meaning="How far the estimated turn over one second departs from the true turn.",
    ),
}

COLUMNS = {
    "rank": Term(
        name="Rank",
        full="rank",
        meaning="One more than the number of solvers that are significantly better by the metric that the table is "
        "sorted by; beside it the best and the worst rank that the figures leave open.",
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
}

SUMMARIES = {
    "median": Term(name="median", full="median", meaning="Half of the sequences have a smaller mean error than this."),
    "p95": Term(
        name="p95", full="95th percentile", meaning="One sequence in twenty has a larger mean error than this."
    ),
}

PROTOCOLS = {
    "one-step": Term(
        name="one-step",
        full="One step",
        meaning="The truth of the two frames before is given for every frame; the solver answers the next. This is "
        "what the paper's tables measure.",
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
}


@cache
def tiers() -> dict[str, Term]:
    """Every tier that is installed here, in the registry's order, by name."""
    found = ((tier.name, tier.summary) for tier in all_tiers())
    return {name: Term(name=name, full=name.capitalize(), meaning=summary) for name, summary in found}


HEADLINE_TIER = "noisy"
HEADLINE_METRIC = "dx"


def term_of(words: dict[str, Term], key: str) -> Term:
    """The term of a key; a stranger's protocol or tier goes by its own name."""
    return words.get(key, Term(name=key, full=key, meaning=""))
