"""A challenge on Codabench: the archive to upload, which holds the truth, and the program that scores there."""

import json
import shutil
import sys
from pathlib import Path

import numpy as np

from vbbench.files.dataset_info import describe
from vbbench.files.withholding import SEED_FILE
from vbbench.scoring import score
from vbbench_leaderboards.challenge.definition import Part
from vbbench_leaderboards.challenge.organiser import DATA, Organiser
from vbbench_leaderboards.site.pages import render

TRUTH, SEQUENCES = "truth", "sequences.json"
COLUMNS = {"dx": "Δx, m", "lost": "lost", "dt": "Δt, m", "dr": "Δr, rad"}
"""Of the results there: key and title, the one that ranks first."""


def write_codabench(organiser: Organiser, folder: Path) -> None:
    """Write a bundle of Codabench (version 2) into a new folder.

    It has ``competition.yaml``, pages, a picture, a scoring program with the file of its container, and for each part
    of the secret set a folder of reference data, with truth and without seed.
    """
    from PIL import Image

    challenge, info = organiser.challenge, organiser.dataset.info
    parts: list[Part] = list(dict.fromkeys(phase.part for phase in challenge.phases))
    for part in parts:
        place = folder / f"reference-{part}"
        shutil.copytree(organiser.data, place / DATA)
        shutil.copytree(organiser.truth, place / TRUTH, ignore=shutil.ignore_patterns(SEED_FILE))
        (place / SEQUENCES).write_text(json.dumps(organiser.parts[part].tolist()), encoding="utf-8")
    (folder / "scoring").mkdir(parents=True)
    values = {"challenge": challenge, "parts": parts, "columns": COLUMNS, "description": describe(info)}
    for name in ("competition.yaml", "overview.md", "terms.md", "scoring/metadata.yaml", "scoring/Containerfile"):
        template = {"overview.md": "bundle.md"}.get(name, f"codabench/{Path(name).name}")
        (folder / name).write_text(render(template, **values), encoding="utf-8", newline="\n")
    Image.new("RGB", (64, 64), "#0a5fb4").save(folder / "logo.png")


def score_part(reference: Path, submission: Path, out: Path) -> None:
    """Score a submission on the sequences of a part, and write ``scores.json`` into the folder ``out``."""
    sequences = np.array(json.loads((reference / SEQUENCES).read_text("utf-8")))
    found = score(submission, reference / DATA, reference / TRUTH, sequences=sequences).summaries
    figures = {name: found[name].capped for name in ("dx", "dt", "dr")} | {"lost": found["dx"].failure_rate}
    (out / "scores.json").write_text(json.dumps(figures), encoding="utf-8")


if __name__ == "__main__":
    score_part(*map(Path, sys.argv[1:]))
