"""
A dataset as tables
===================

Every table of a dataset is a Parquet file with names and units that do not change, so anything that reads Parquet reads
it: pandas, Polars, DuckDB, R. Here with pandas.
"""

# %%
# Tables
# ------
import tempfile
from pathlib import Path

import vbbench
from vbbench.generation.generator import Options

folder = Path(tempfile.mkdtemp()) / "demo"
dataset = vbbench.generate("demo", folder, Options(tier="occluded", limit=8))
for path in sorted(folder.rglob("*.parquet")):
    print(f"{path.relative_to(folder)!s:24} {path.stat().st_size / 1000:6.1f} kB")

# %%
# Boxes
# -----
# Column, row and height of each box in px, and which share of it can be seen.
import pandas

boxes = pandas.read_parquet(folder / "observations.parquet")
boxes.head()

# %%
# What solvers never get lies in ``truth``: the poses of the camera, and everybody's path in the scene.
# ``Dataset.to_pandas`` finds the tables also where the truth is kept somewhere else.
dataset.to_pandas("truth/poses").head()

# %%
# A question
# ----------
# How tall is a box at a given distance, and how much of it is hidden? Positions and boxes of one sequence, as arrays:
import matplotlib.pyplot as plt
import numpy as np

figure, axes = plt.subplots(figsize=(7, 4), layout="constrained")
for sequence in dataset.sequences():
    distance = np.linalg.norm(dataset.relative_truth(sequence), axis=-1)
    seen = sequence.observed
    dots = axes.scatter(
        distance[seen], sequence.observations[seen][:, 2], c=sequence.visible[seen], s=6, vmin=0, vmax=1, cmap="viridis"
    )
axes.set(xlabel="distance (m)", ylabel="height of the box (px)", xscale="log", yscale="log")
figure.colorbar(dots, label="visible")
plt.show()

# %%
# For a scene as a whole, with everybody in it, group its rows:
paths = dataset.to_pandas("truth/scenes")
paths.groupby("scene").agg(people=("person", "nunique"), frames=("frame", "nunique"), rows=("x", "size")).head()
