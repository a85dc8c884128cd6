"""
A first result
==============

Make a small dataset of a simulated crowd, let two solvers answer it, score them, and draw what happened. This takes a
few seconds and needs no recording; the extra ``pandas`` draws the tables.
"""

# %%
# Data
# ----
# A *dataset* is a folder: for every sequence the boxes of people that a moving camera sees and, in tables of their own,
# where everybody truly was. ``demo`` is a split of simulated crowds; the tier ``noisy`` gives its boxes 1 px of noise.
import tempfile
from pathlib import Path

import vbbench
from vbbench.generation.generator import Options

room = Path(tempfile.mkdtemp())
dataset = vbbench.generate("demo", room / "demo", Options(tier="noisy", limit=12))
print(f"{len(dataset)} sequences, dt {dataset.info.dt} s, camera {dataset.info.camera.kind}")

# %%
# All that a solver sees of a frame: column and row of the middle of each box, and its height, in px.
sequence = dataset.sequence(0)
sequence.observations[5][sequence.observed[5]].round(1)

# %%
# Solve
# -----
# ``cv`` only carries on what it was given, at constant velocity; ``map-causal`` infers everybody's most probable path
# from the boxes. Under the protocol ``sequential`` the first two positions of each person are given, and nothing else.
answers = {}
for solver in ("cv", "map-causal"):
    answers[solver] = vbbench.solve(dataset, solver, "sequential", room / solver)

# %%
# Score
# -----
# Δx is the error of people on the map and Δt that of the camera, in m; Δr is the camera's heading, in rad.
scores = {solver: vbbench.score(answer, dataset.folder) for solver, answer in answers.items()}
print(scores["map-causal"].table())

# %%
# Sequence by sequence:
tables = {solver: score.to_pandas()["dx"].round(3) for solver, score in scores.items()}

import pandas

pandas.DataFrame(tables).head(6)

# %%
# Look
# ----
# The map with truth in grey and the answer in colour, above all that the solver saw.
from vbbench.pictures.plotting import plot_to_file

picture = plot_to_file(dataset, 0, room / "map.png", submissions=[answers["map-causal"]])

import matplotlib.pyplot as plt

figure, axes = plt.subplots(figsize=(10, 8.4), layout="constrained")
axes.imshow(plt.imread(picture))
axes.axis("off")
plt.show()

# %%
# ``compare`` shows whether one solver is better than the other, and not only luckier: differences of the errors,
# sequence by sequence, with intervals by a block bootstrap over time.
print(vbbench.compare(answers["map-causal"], answers["cv"], dataset.folder).table())
