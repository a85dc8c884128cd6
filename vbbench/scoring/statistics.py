"""Figures of a split: means over sequences, capped and plain, with their intervals, spreads, and failures."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from vbbench.geometry import FloatArray, IntArray
from vbbench.parsing.json_text import finite_or_none
from vbbench.protocol import Protocol
from vbbench.scoring.block_bootstrap import block_means
from vbbench.scoring.timeline import Timeline

NAN = float("nan")


@dataclass(frozen=True, kw_only=True)
class Summary:
    """One metric over a split.

    Parameters
    ----------
    capped : mean over sequences of min(figure, cap of the protocol): the headline, by which boards rank.
    failure_rate : share of the sequences with a figure above the protocol's limit; NaN where it sets none.
    median, p95, mean, std : over the sequences' figures as they are.
    capped_ci95, ci95 : 95 % intervals of ``capped`` and ``mean`` by a block bootstrap over time; NaN where the
        sequences are too few or too long for one.
    frame_mean, frame_std : over all frames of all sequences.
    blocks : how many blocks the sequences' time has.
    """

    capped: float = NAN
    capped_ci95: tuple[float, float] = (NAN, NAN)
    failure_rate: float = NAN
    median: float = NAN
    mean: float = NAN
    ci95: tuple[float, float] = (NAN, NAN)
    std: float = NAN
    p95: float = NAN
    frame_mean: float = NAN
    frame_std: float = NAN
    blocks: float = NAN

    def to_dict(self) -> dict[str, object]:
        """The summary, with ``None`` for NaN, as JSON needs it."""
        return {
            name: [finite_or_none(end) for end in value] if isinstance(value, tuple) else finite_or_none(value)
            for name, value in vars(self).items()
        }


def summarise(
    timeline: Timeline, protocol: Protocol, sequences: Mapping[str, FloatArray], frames: Mapping[str, FloatArray]
) -> dict[str, Summary]:
    """Summary of each metric.

    Parameters
    ----------
    timeline : when the sequences were.
    protocol : whose caps and limits hold.
    sequences : metric → [N] one figure per sequence, NaN where it has none.
    frames : metric → [F] one figure per frame, NaN likewise.
    """
    plain, capped = np.stack(list(sequences.values()), axis=1), capped_figures(protocol.caps, sequences)
    block = timeline.block_length(capped)
    means = block_means(timeline, np.concatenate([capped, plain], axis=1), block)
    bounds = [protocol.caps.get(name, np.inf) for name in sequences]
    largest = np.concatenate([bounds, np.max(np.nan_to_num(plain), axis=0)])
    intervals = [(low, high) for low, high in means.positive_interval(largest).tolist()]
    return {
        name: Summary(
            capped=float(means.mean[m]),
            capped_ci95=intervals[m],
            ci95=intervals[m + len(sequences)],
            failure_rate=_failure_rate(figures, protocol.failures.get(name)),
            blocks=means.blocks,
            **_plain(figures, known(frames[name])),
        )
        for m, (name, figures) in enumerate((name, known(values)) for name, values in sequences.items())
    }


def capped_figures(caps: Mapping[str, float], sequences: Mapping[str, FloatArray]) -> FloatArray:
    """[N, M] the figures [N] of M metrics, none above the metric's cap."""
    return np.stack([np.minimum(values, caps.get(name, np.inf)) for name, values in sequences.items()], axis=1)


def mean_of_groups(group: IntArray, values: FloatArray, groups: int) -> FloatArray:
    """Mean of values [R] over rows of the same group number [R] → [groups]; NaN for an empty group."""
    count = np.bincount(group, minlength=groups)
    mean = np.full(groups, np.nan)
    np.divide(np.bincount(group, values, groups), count, out=mean, where=count > 0)
    return mean


def known(values: FloatArray) -> FloatArray:
    """The values that are not NaN."""
    return values[~np.isnan(values)]


def _failure_rate(figures: FloatArray, limit: float | None) -> float:
    """Share of the figures, in float32 as result files have them, that are above the limit."""
    return NAN if limit is None or not len(figures) else float(np.mean(figures.astype(np.float32) > limit))


def _plain(figures: FloatArray, frames: FloatArray) -> dict[str, float]:
    if not len(figures):
        return {}
    return {
        "median": float(np.median(figures)),
        "mean": float(np.mean(figures)),
        "std": float(np.std(figures)),
        "p95": float(np.quantile(figures, 0.95)),
        "frame_mean": float(np.mean(frames)),
        "frame_std": float(np.std(frames)),
    }
