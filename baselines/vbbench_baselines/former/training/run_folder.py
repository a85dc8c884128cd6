"""The folder of a training: it is made, goes on where it was stopped, and ends with the weights.

OUT/training.json   what is trained: recipe, seed, versions; the mark of the folder
OUT/crowds          the simulated sequences
OUT/checkpoint.pt   from which it goes on
OUT/log.csv         how it went
OUT/weights.npz     the result; training.json then has its SHA-256
"""

import csv
import json
from dataclasses import asdict, replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from vbbench import __version__
from vbbench.errors import VbbenchError
from vbbench.folders.locks import locked
from vbbench.folders.replacing import replacing, write_text_atomically
from vbbench.parallel.parts import progress_bar
from vbbench_baselines.former.training.crowds import make_crowds
from vbbench_baselines.former.training.loop import Training, held_out_batches
from vbbench_baselines.former.training.recipe import Recipe

MARK, CHECKPOINT, LOG, WEIGHTS, CROWDS = "training.json", "checkpoint.pt", "log.csv", "weights.npz", "crowds"
HELD_OUT_PART = 0.025
"""As many sequences as the recipe says, times this, are held out."""


def train(
    out: Path,
    recipe: Recipe,
    *,
    seed: int = 0,
    pure: bool = False,
    feet: bool = True,
    sequences: int | None = None,
    part: float = 1.0,
    crowds: Path | None = None,
    device: str = "cpu",
    jobs: int = 1,
) -> Path:
    """Train in the folder ``out``, or go on there; the path of the weights.

    Parameters
    ----------
    sequences : about how many of the sequences are learned from; ``None`` for all.
    part : how many sequences and windows there are, beside what the recipe says.
    crowds : folder of the simulated sequences, which several trainings can share; ``None`` for one in ``out``.
    device : of PyTorch, see `vbbench_baselines.former.training.loop.Training`.

    Raises
    ------
    VbbenchError
        If the folder is not of this training.
    """
    recipe = replace(recipe, windows=max(1, round(part * recipe.windows)))
    facts = {"recipe": asdict(recipe), "seed": seed, "pure": pure, "feet": feet, "sequences": sequences, "part": part}
    out.mkdir(parents=True, exist_ok=True)
    with locked(out):
        known = _begin(out, facts)
        if (out / WEIGHTS).is_file() and "weights" in known:
            return out / WEIGHTS
        folder = crowds or out / CROWDS
        learned = make_crowds(recipe, folder, recipe.seed, part=part, jobs=jobs)
        kept = HELD_OUT_PART if part == 1.0 else max(part, HELD_OUT_PART)
        held_out = make_crowds(recipe, folder, recipe.held_out_seed, part=kept, jobs=jobs)
        learned = learned if sequences is None else learned.limited(sequences)
        training = Training(recipe, learned, held_out_batches(recipe, held_out), seed, pure, feet, device)
        if (out / CHECKPOINT).is_file():
            training.resume(out / CHECKPOINT)
        with progress_bar(recipe.windows, "windows", done=training.windows, unit="window") as bar:

            def tell(row: dict[str, Any]) -> None:
                bar.update(row["windows"] - bar.n)
                _write_log(out / LOG, training.log)

            weights = training.run(out / CHECKPOINT, tell)
        with replacing(out / WEIGHTS, ".npz") as draft:
            np.savez(draft, **weights)  # type: ignore[arg-type]
        digest = sha256((out / WEIGHTS).read_bytes()).hexdigest()
        result = {"weights": digest, "seconds": training.seconds, "held_out": training.look(training.mean)}
        _write_facts(out, {**facts, **result})
        return out / WEIGHTS


def _begin(out: Path, facts: dict[str, Any]) -> dict[str, Any]:
    """What the folder says of itself; a new one gets its mark."""
    if not (out / MARK).is_file():
        if any(entry.name != ".vbbench-lock" for entry in out.iterdir()):
            raise VbbenchError(f"{out} exists and is not the folder of a training; choose another folder")
        _write_facts(out, facts)
    known: dict[str, Any] = json.loads((out / MARK).read_text("utf-8"))
    asked = json.loads(json.dumps(facts))
    other = [name for name in asked if known.get(name) != asked[name]]
    if other:
        raise VbbenchError(f"{out} is of a training with another {', '.join(other)}; choose another folder")
    return known


def _write_facts(out: Path, facts: dict[str, Any]) -> None:
    write_text_atomically(
        out / MARK, json.dumps({"vbbench": __version__, **facts}, indent=1, ensure_ascii=False) + "\n"
    )


def _write_log(path: Path, rows: list[dict[str, Any]]) -> None:
    with replacing(path) as draft, draft.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(dict.fromkeys(name for row in rows for name in row)))
        writer.writeheader()
        writer.writerows(rows)
