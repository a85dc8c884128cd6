"""Fixed bins on one axis: counts of any number of samples in constant memory."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from vbbench.geometry import FloatArray, IntArray

BINS = 1000
"""Bins per axis: a quantile is off by at most one of them, 0.1 % of the axis."""


@dataclass(frozen=True)
class Axis:
    """What is counted: its name, its unit ("" for none), and the upper end of its bins, which start at 0."""

    name: str
    unit: str
    upper: float

    @property
    def edges(self) -> FloatArray:
        """[BINS + 1] edges of the bins."""
        return np.linspace(0.0, self.upper, BINS + 1)

    @property
    def title(self) -> str:
        """The name with its unit."""
        return f"{self.name} ({self.unit})" if self.unit else self.name


@dataclass(frozen=True, kw_only=True)
class Histogram:
    """Counts of samples ≥ 0.

    Parameters
    ----------
    axis : what the samples are.
    counts : [BINS + 1] samples in each bin, the last one for all beyond the axis.
    total : sum of the samples.
    least, most : the extreme samples; ∞ and −∞ without any.
    """

    axis: Axis
    counts: IntArray
    total: float = 0.0
    least: float = np.inf
    most: float = -np.inf

    @staticmethod
    def of(axis: Axis, samples: ArrayLike = ()) -> "Histogram":
        """Count samples ≥ 0 of any shape."""
        values = np.asarray(samples, dtype=np.float64).ravel()
        inside = np.histogram(values, bins=BINS, range=(0.0, axis.upper))[0]
        return Histogram(
            axis=axis,
            counts=np.append(inside, len(values) - inside.sum()),
            total=float(values.sum()),
            least=float(values.min(initial=np.inf)),
            most=float(values.max(initial=-np.inf)),
        )

    def __add__(self, other: "Histogram") -> "Histogram":
        return Histogram(
            axis=self.axis,
            counts=self.counts + other.counts,
            total=self.total + other.total,
            least=min(self.least, other.least),
            most=max(self.most, other.most),
        )

    @property
    def count(self) -> int:
        """Number of samples."""
        return int(self.counts.sum())

    @property
    def mean(self) -> float:
        """Exact mean of the samples; NaN without any."""
        return self.total / self.count if self.count else np.nan

    def quantile(self, share: float) -> float:
        """The value below which lies that share of the samples, to one bin; NaN without any.

        Ranks between two samples are interpolated, as `numpy.quantile` does. Samples are spread evenly over their bin.
        """
        if not self.count:
            return np.nan
        rank = share * (self.count - 1)
        below, above = self._at_rank(int(rank)), self._at_rank(int(np.ceil(rank)))
        return below + (rank - int(rank)) * (above - below)

    def density(self, edges: FloatArray) -> FloatArray:
        """[M − 1] share of all samples per unit of the axis, between ascending edges [M]."""
        below = np.interp(edges, self.axis.edges, np.append(0, np.cumsum(self.counts[:-1])))
        return np.asarray(np.diff(below) / np.diff(edges) / max(self.count, 1))

    def to_json(self) -> dict[str, Any]:
        """Figures and bins; without samples figures are null."""
        quantiles = {name: self.quantile(share) for name, share in (("median", 0.5), ("p5", 0.05), ("p95", 0.95))}
        return {
            "unit": self.axis.unit,
            "count": self.count,
            **{name: value if self.count else None for name, value in {"mean": self.mean, **quantiles}.items()},
            "bin_width": self.axis.upper / BINS,
            "bins": self.counts[:-1].tolist(),
            "beyond": int(self.counts[-1]),
        }

    def _at_rank(self, rank: int) -> float:
        """The sample of that rank from 0, if the samples of a bin are spread evenly over it."""
        upto = np.cumsum(self.counts)
        place = int(np.searchsorted(upto, rank, side="right"))
        edges = np.append(self.axis.edges, max(self.most, self.axis.upper))
        share = (rank - (upto[place] - self.counts[place]) + 0.5) / self.counts[place]
        return float(np.clip(edges[place] + share * (edges[place + 1] - edges[place]), self.least, self.most))
