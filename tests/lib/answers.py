"""Submissions for tests: the truth of a dataset as pandas tables, with noise, and the folders that hold them."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from vbbench.files.submission import SubmissionInfo, SubmissionWriter


def read(dataset: Path, name: str) -> pd.DataFrame:
    """A table of the dataset."""
    return pd.read_parquet(dataset / f"{name}.parquet")


def true_answers(dataset: Path, noise: float = 0.0, seed: int = 0) -> tuple[pd.DataFrame, pd.DataFrame]:
    """True poses of all frames, true positions of everybody observed; with noise in m and rad."""
    random = np.random.default_rng(seed)
    rows, poses = read(dataset, "sequences"), read(dataset, "truth/poses")
    seen = read(dataset, "observations")[["sequence", "frame", "track"]]
    begun = read(dataset, "truth/tracks").sort_values("frame", kind="stable")
    seen = pd.merge_asof(seen.sort_values("frame", kind="stable"), begun, on="frame", by=["sequence", "track"])
    seen = seen.merge(rows[["sequence", "scene", "first_frame"]], on="sequence")
    scenes = read(dataset, "truth/scenes").rename(columns={"frame": "scene_frame"})
    seen = seen.assign(scene_frame=seen.frame + seen.first_frame)
    seen = seen.merge(scenes, on=["scene", "scene_frame", "person"], how="inner")
    worlds = read(dataset, "truth/frames").set_index("sequence").loc[seen.sequence]
    x, y, sin, cos = seen.x.to_numpy(), seen.y.to_numpy(), np.sin(worlds.yaw.to_numpy()), np.cos(worlds.yaw.to_numpy())
    seen = seen.assign(x=cos * x - sin * y + worlds.x.to_numpy(), y=sin * x + cos * y + worlds.y.to_numpy())
    positions = seen[["sequence", "frame", "track", "x", "y"]].sort_values(["sequence", "frame", "track"])
    return _shaken(poses, ["x", "y", "yaw"], noise, random), _shaken(positions, ["x", "y"], noise, random)


def submit(folder: Path, dataset: Path, tables: tuple[pd.DataFrame, pd.DataFrame], **facts: Any) -> Path:
    """Write a submission as the library does."""
    identity = json.loads((dataset / "dataset.json").read_text())["id"]
    info = SubmissionInfo(**{"solver": "test", "dataset": identity, "protocol": "sequential", **facts})
    with SubmissionWriter(folder, info, fallback="fallback" in tables[0]) as writer:
        for sequence in np.union1d(tables[0]["sequence"], tables[1]["sequence"]):
            own = [table[table["sequence"] == sequence] for table in tables]
            poses, positions = ({name: table[name].to_numpy() for name in table} for table in own)
            writer.add(int(sequence), poses, positions)
    return folder


def submit_csv(folder: Path, dataset: Path, tables: tuple[pd.DataFrame, pd.DataFrame], **facts: Any) -> Path:
    """Write a submission as a stranger does, by hand."""
    identity = json.loads((dataset / "dataset.json").read_text())["id"]
    folder.mkdir()
    (folder / "submission.json").write_text(
        json.dumps({"solver": "by hand", "dataset": identity, "protocol": "sequential", **facts})
    )
    for name, table in zip(("poses", "positions"), tables, strict=True):
        table.to_csv(folder / f"{name}.csv", index=False)
    return folder


def _shaken(table: pd.DataFrame, names: list[str], noise: float, random: np.random.Generator) -> pd.DataFrame:
    return table.assign(**{name: table[name] + random.normal(0, 1, len(table)) * noise for name in names})
