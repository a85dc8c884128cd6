"""What the paper says of its posteriors, each said as a number that can be measured over all frames."""

from collections.abc import Callable, Mapping

from vbbench.reproduction.posterior.effects import (
    rank_correlation,
    rank_correlation_at_equal_number,
    slope_at_equal_number,
)
from vbbench.reproduction.posterior.study import Posteriors
from vbbench.reproduction.transfer.agreement import Estimate

Statistic = Callable[..., float]
CLAIMS: tuple[tuple[str, str, str, Statistic, tuple[str, str]], ...] = (
    ("few people, heavier tails", "kurtosis of the place", "ρ with people", rank_correlation, ("people", "kurtosis")),
    ("few people, heavier tails", "mass beyond 3 σ", "ρ with people", rank_correlation, ("people", "beyond")),
    ("few people, wider", "entropy of the pose", "ρ with people", rank_correlation, ("people", "pose")),
    ("diverse, sharper", "entropy of the pose", "ρ with the spread", rank_correlation, ("spread", "pose")),
    (
        "diverse, sharper",
        "entropy of the pose",
        "ρ with the spread at equal number",
        rank_correlation_at_equal_number,
        ("spread", "pose"),
    ),
    (
        "diverse, sharper",
        "entropy of the pose",
        "nats per unit of spread at equal number",
        slope_at_equal_number,
        ("spread", "pose"),
    ),
    (
        "diverse, sharper",
        "entropy of the pose",
        "ρ with the spread of lines at equal number",
        rank_correlation_at_equal_number,
        ("lines", "pose"),
    ),
    (
        "not the paper's: people all around, sharper",
        "entropy of the pose",
        "ρ with the spread of bearings at equal number",
        rank_correlation_at_equal_number,
        ("bearings", "pose"),
    ),
)
"""The paper's claims and one beside them: what each says, what is measured, and how."""


def estimate_claims(found: Posteriors) -> Mapping[str, list[Estimate]]:
    """By solver, an estimate for each of `CLAIMS`."""
    return {
        solver: [
            found.sample.estimate(statistic, found.walking[along], getattr(table, what))
            for *_, statistic, (along, what) in CLAIMS
        ]
        for solver, table in found.tables.items()
    }
