"""Means, spreads and bootstrap over sequences."""

from dataclasses import dataclass

import numpy as np

from vbbench.geometry import FloatArray, IntArray

RESAMPLES = 4000
"""Bootstrap resamples behind an interval; its ends then repeat to about a hundredth of its width."""

SEED = 20211105
_DRAWS_AT_ONCE = 1 << 22


@dataclass(frozen=True, kw_only=True)
class Summary:
    """One metric over a split.

    Parameters
    ----------
    mean, std, median, p95 : over the sequences' figures.
    ci95 : bootstrap interval of ``mean`` over sequences.
    frame_mean, frame_std : over all frames of all sequences.
    """

    mean: float
    std: float
    ci95: tuple[float, float]
    frame_mean: float
    frame_std: float
    median: float
    p95: float

    def to_dict(self) -> dict[str, object]:
        """The summary, with ``None`` for NaN, as JSON needs it."""
        values = {name: finite_or_none(value) for name, value in vars(self).items() if name != "ci95"}
        return {**values, "ci95": [finite_or_none(end) for end in self.ci95]}


def summarise(sequences: dict[str, FloatArray], frames: dict[str, FloatArray]) -> dict[str, Summary]:
    """Summary of each metric.

    Parameters
    ----------
    sequences : metric → [N] one figure per sequence, NaN where it has none.
    frames : metric → [F] one figure per frame, NaN likewise.
    """
    means = bootstrap_means(np.stack(list(sequences.values()), axis=1))
    low, high = np.quantile(means, [0.025, 0.975], axis=0).tolist()
    return {
        name: _summary(known(sequences[name]), known(frames[name]), (low[m], high[m]))
        for m, name in enumerate(sequences)
    }


def bootstrap_means(values: FloatArray, resamples: int = RESAMPLES, seed: int = SEED) -> FloatArray:
    """Means of N sequences drawn with replacement, ``resamples`` times.

    How often each sequence is drawn is one row of a count matrix C [R, N]: means are C·values over C·(value is known).

    Parameters
    ----------
    values : [N, M] figures of M metrics, NaN = that sequence has none.

    Returns
    -------
    [R, M] means; the same draws for every metric.
    """
    random = np.random.default_rng(seed)
    there = ~np.isnan(values)
    columns = np.concatenate([np.where(there, values, 0.0), there.astype(float)], axis=1)
    block = max(1, _DRAWS_AT_ONCE // len(values))
    sums = [
        _draw_counts(random, min(block, resamples - done), len(values)) @ columns for done in range(0, resamples, block)
    ]
    total, count = np.split(np.concatenate(sums), 2, axis=1)
    return _ratio(total, count)


def two_sided_p(means: FloatArray) -> FloatArray:
    """p-value [M] that a mean is 0, from bootstrap means [R, M]: twice the smaller tail, and never below 2/(R + 1)."""
    count = len(means) + 1
    tails = np.minimum(np.sum(means <= 0, axis=0) + 1, np.sum(means >= 0, axis=0) + 1)
    p: FloatArray = np.minimum(1.0, 2.0 * tails / count)
    return p


def mean_of_groups(group: IntArray, values: FloatArray, groups: int) -> FloatArray:
    """Mean of values [R] over rows of the same group number [R] → [groups]; NaN for an empty group."""
    return _ratio(np.bincount(group, values, groups).astype(float), np.bincount(group, minlength=groups))


def known(values: FloatArray) -> FloatArray:
    """The values that are not NaN."""
    return values[~np.isnan(values)]


def _ratio(total: FloatArray, count: FloatArray | IntArray) -> FloatArray:
    ratio = np.full(total.shape, np.nan)
    np.divide(total, count, out=ratio, where=count > 0)
    return ratio


def _draw_counts(random: np.random.Generator, resamples: int, size: int) -> FloatArray:
    drawn = random.integers(size, size=(resamples, size)) + size * np.arange(resamples)[:, None]
    return np.bincount(drawn.ravel(), minlength=resamples * size).reshape(resamples, size).astype(float)


def _summary(sequences: FloatArray, frames: FloatArray, ci95: tuple[float, float]) -> Summary:
    if not len(sequences):
        nan = float("nan")
        return Summary(mean=nan, std=nan, ci95=(nan, nan), frame_mean=nan, frame_std=nan, median=nan, p95=nan)
    return Summary(
        mean=float(np.mean(sequences)),
        std=float(np.std(sequences)),
        ci95=ci95,
        frame_mean=float(np.mean(frames)),
        frame_std=float(np.std(frames)),
        median=float(np.median(sequences)),
        p95=float(np.quantile(sequences, 0.95)),
    )


def finite_or_none(value: float) -> float | None:
    """The value, or ``None`` if it is NaN or infinite: JSON has neither."""
    return value if np.isfinite(value) else None
