"""A dataset's facts for people and for programs."""

import json
from dataclasses import asdict
from typing import Any

from vbbench.dataset_info import DatasetInfo
from vbbench.reproduction.paper import Counts, the_paper


def summary(info: DatasetInfo) -> dict[str, Any]:
    """The row of the paper's Table 1, and what identifies the dataset.

    Frames count where anybody is observed. Recipes say whether the people of Table 1 include the observer.
    """
    counts, extra = info.counts, int(info.definition.get("count_observer", False))
    return {
        "split": info.split,
        "camera": info.camera.kind,
        "tier": info.tier,
        "sequences": counts["sequences"],
        "mean_frames": counts["frames"] / counts["sequences"],
        "people_min": counts["people_min"] + extra,
        "people_mean": counts["observations"] / max(counts["frames"], 1) + extra,
        "people_max": counts["people_max"] + extra,
        "observations": counts["observations"],
        "id": info.id,
    }


def summary_json(info: DatasetInfo) -> str:
    """The summary as JSON, with the caution, the calibration and the paper's row where there is one, and the hash of
    truth where that is withheld.
    """
    paper = _paper_row(info)
    extras = {
        "caution": info.caution,
        "calibration": info.calibration,
        "paper": None if paper is None else asdict(paper),
        "truth_sha256": info.truth_sha256 if info.seed is None else None,
    }
    told = {name: value for name, value in extras.items() if value is not None}
    return json.dumps({**summary(info), **told}, indent=2, ensure_ascii=False)


def describe(info: DatasetInfo) -> str:
    """The summary and parameters as text."""
    s = summary(info)
    included = "observer included" if info.definition.get("count_observer") else "besides the observer"
    lines = [
        f"{info.split}: {info.title}",
        f"  {s['sequences']} sequences, mean {s['mean_frames']:.2f} frames, people ({included}) "
        f"{s['people_min']} / {s['people_mean']:.2f} / {s['people_max']} (min / mean / max)",
        f"  {s['observations']} observations; camera {s['camera']}, tier {s['tier']} ({info.pixel_std:g} px), "
        f"dt {info.dt:g} s",
        f"  heights N({info.height_mean:.2f}, {info.height_std:g}²) m, seed {info.spoken_seed}, id {s['id']}",
    ]
    paper = _paper_row(info)
    if paper is not None:
        row = f"{paper.sequences} sequences, mean {paper.frames} frames, people {paper.people}"
        lines.insert(2, f"  the paper: {row}")
    if info.calibration is not None:
        lines.append(f"  calibration: {info.calibration['summary']}")
    if info.seed is None:
        lines.append(f"  truth withheld, SHA-256 {info.truth_sha256}")
    if info.caution is not None:
        lines.append(f"  caution: {info.caution}")
    return "\n".join(lines)


def _paper_row(info: DatasetInfo) -> Counts | None:
    """The split's row of Table 1, where the paper has the split."""
    return the_paper().table1.get(info.split)
