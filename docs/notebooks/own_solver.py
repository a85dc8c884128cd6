"""
Your own solver
===============

A solver is a class with two methods. Here is one in thirty lines: people keep walking as they did, and the camera is
where their boxes fit best to where they should be.
"""

# %%
# The solver
# ----------
# ``start`` gets what is known of a sequence; ``step`` gets one frame at a time. ``frame.given`` has what the protocol
# gives of this frame and the two before, with NaN for the rest. Nothing here can reach truth.
import numpy as np

from vbbench import Frame, FrameEstimate, Problem


class KeepWalking:
    """Predicts everybody at constant velocity, and lays what the camera sees onto that."""

    def start(self, problem: Problem) -> None:
        self.problem = problem
        self.heights = np.full(len(problem.tracks), problem.height_mean)
        self.places = np.full((len(problem.tracks), 2), np.nan)
        self.speeds = np.zeros_like(self.places)
        self.pose = np.zeros(3)

    def step(self, frame: Frame) -> FrameEstimate:
        expected = self.places + self.speeds
        right, forward = self.problem.camera.unproject(frame.observations, self.heights).T
        seen = np.stack([forward, -right], axis=-1)  # from the camera: ahead and to the left, in m
        given = frame.given.poses[-1]
        self.pose = laid_onto(seen, expected, self.pose) if np.isnan(given).any() else given
        x, y, yaw = self.pose
        here = seen @ np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]]) + [x, y]
        places = first_known(frame.given.positions[-1], (here + expected) / 2, here, expected)
        self.speeds = first_known(places - self.places, self.speeds)
        self.places = places
        return FrameEstimate(pose=self.pose, positions=places)


def laid_onto(seen: np.ndarray, expected: np.ndarray, otherwise: np.ndarray) -> np.ndarray:
    """The pose (x, y, yaw) that moves points seen from the camera onto those expected, by least squares."""
    both = np.isfinite(seen).all(axis=1) & np.isfinite(expected).all(axis=1)
    if both.sum() < 2:
        return otherwise
    a, b = (points[both] @ [1, 1j] for points in (seen, expected))  # points of the plane as complex numbers
    yaw = np.angle(np.vdot(a - a.mean(), b - b.mean()))
    centre = b.mean() - a.mean() * np.exp(1j * yaw)
    return np.array([centre.real, centre.imag, yaw])


def first_known(*choices: np.ndarray) -> np.ndarray:
    """Row by row the first choice that is not NaN."""
    found = choices[0]
    for other in choices[1:]:
        found = np.where(np.isnan(found), other, found)
    return found


# %%
# On the board's terms
# --------------------
# ``vbbench solve demo --solver mysolver:KeepWalking`` finds the class in a file ``mysolver.py``. A class of a notebook
# is in the module ``__main__``.
import tempfile
from pathlib import Path

import vbbench
from vbbench.generation.generator import Options

room = Path(tempfile.mkdtemp())
dataset = vbbench.generate("demo", room / "demo", Options(tier="noisy", limit=12))
mine = vbbench.solve(dataset, "__main__:KeepWalking", "sequential", room / "mine")
print(vbbench.score(mine, dataset.folder).table())

# %%
# Beside others
# -------------
# Is it better than ``cv``, which carries on what it was given and looks at no box, and how far is it from
# ``map-causal``? Negative differences are in favour of the first.
for other in ("cv", "map-causal"):
    theirs = vbbench.solve(dataset, other, "sequential", room / other)
    print(vbbench.compare(mine, theirs, dataset.folder).table())

# %%
# Where it fails
# --------------
# The error of each sequence, over how many people there are in it. Sequences with more people are longer, too, and
# whoever only carries on goes astray; who looks at the boxes does not.
import matplotlib.pyplot as plt

figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
for name in ("mine", "cv", "map-causal"):
    figures = vbbench.score(room / name, dataset.folder).per_sequence
    axes.plot(dataset.rows["people"][figures.sequence], figures.figures["dx"], "o", label=name, alpha=0.8)
axes.set(xlabel="people", ylabel="mean Δx (m)", ylim=(0, None))
axes.legend()
plt.show()
