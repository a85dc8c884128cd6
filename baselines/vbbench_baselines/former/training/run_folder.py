"""The folder of a training, from which a stopped one resumes.

OUT/training.json   recipe, seed and versions; marks the folder
OUT/crowds          the simulated sequences
OUT/checkpoint.pt   the newest checkpoint
OUT/log.csv         the log, which curve.png shows
OUT/weights.npz     the result; training.json then has its SHA-256
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import torch
from matplotlib.axes import Axes

from vbbench import __version__
from vbbench.errors import FileError, VbbenchError, quoted
from vbbench.folders.locks import locked
from vbbench.folders.replacing import replacing, write_text_atomically
from vbbench.parallel.parts import processes_of, progress_bar
from vbbench.pictures.plotting import save_picture
from vbbench.pictures.plotting.style import TEXT_SIZE, lay_out, write_heading
from vbbench.protocol import PROTOCOLS
from vbbench.table import csv_text
from vbbench_baselines.former.training.crowds import make_crowds
from vbbench_baselines.former.training.loop import Training, held_out_batches
from vbbench_baselines.former.training.recipe import Recipe
from vbbench_baselines.former.weights import read_weights

MARK, CHECKPOINT, CROWDS = "training.json", "checkpoint.pt", "crowds"
LOG, CURVE = "log.csv", "curve.png"
WEIGHTS, ABOUT = "weights.npz", "weights.toml"
HELD_OUT_PART = 0.025
"""As many sequences as the recipe says, times this, are held out."""


@dataclass(frozen=True, kw_only=True)
class Asked:
    """Everything that determines the weights.

    Parameters
    ----------
    recipe : data and phases.
    seed : seed of the initial weights and of the windows.
    pure : see `vbbench_baselines.former.network.Birdifier`.
    sequences : about how many of the sequences are used; ``None`` for all.
    part : share of the recipe's sequences and windows.
    """

    recipe: Recipe
    seed: int = 0
    pure: bool = False
    sequences: int | None = None
    part: float = 1.0


def train(out: Path, asked: Asked, *, crowds: Path | None = None, device: str = "cpu", jobs: int = 1) -> Path:
    """Train in the folder ``out``, or resume there; returns the path of the weights.

    Parameters
    ----------
    crowds : folder of the simulated sequences, which several trainings can share; ``None`` for one in ``out``.
    device : see `vbbench_baselines.former.training.loop.Training`.
    jobs : see there; as many processes make the crowds. −1 for one per core.

    Raises VbbenchError if the folder is not of this training, a file in it is damaged, the device cannot be used, or
    there cannot be so many processes.
    """
    _check_device(device)
    recipe, jobs = asked.recipe.shortened(asked.part), processes_of(jobs)
    facts = asdict(replace(asked, recipe=recipe))
    out.mkdir(parents=True, exist_ok=True)
    with locked(out):
        _begin(out, facts)
        if _is_done(out):
            return out / WEIGHTS
        folder = crowds or out / CROWDS
        learned = make_crowds(recipe, folder, recipe.seed, part=asked.part, jobs=jobs)
        held_out = make_crowds(recipe, folder, recipe.held_out_seed, part=HELD_OUT_PART, jobs=jobs)
        if asked.sequences is not None:
            learned = learned.limited(asked.sequences)
        batches = held_out_batches(recipe, held_out)
        training = Training(recipe, learned, batches, asked.seed, asked.pure, device, jobs)
        if (out / CHECKPOINT).is_file():
            training.resume(out / CHECKPOINT)
        with progress_bar(recipe.windows, "windows", done=training.windows, unit="window") as bar:

            def report(row: dict[str, Any]) -> None:
                bar.update(row["windows"] - bar.n)
                _write_log(out / LOG, training.log)
                draw_curve(training.log, len(learned), out / CURVE)

            weights = training.run(out / CHECKPOINT, report)
        with replacing(out / WEIGHTS, ".npz") as draft:
            np.savez(draft, **weights)  # type: ignore[arg-type]
        learned_from = {"windows": training.windows, "sequences": len(learned), "seconds": round(training.seconds)}
        results = {**learned_from, **training.look(training.mean)}
        write_text_atomically(out / ABOUT, _about(out / WEIGHTS, facts, results))
        return out / WEIGHTS


def _check_device(device: str) -> None:
    try:
        torch.empty(0, device=device)
    except (RuntimeError, AssertionError) as error:
        raise VbbenchError(f"PyTorch cannot use the device {quoted(device)}: {str(error).splitlines()[0]}") from error


def _is_done(out: Path) -> bool:
    """Whether the weights exist and have the checksum of their recipe."""
    try:
        read_weights(out / WEIGHTS)
    except FileError:
        return False
    return True


def _begin(out: Path, facts: dict[str, Any]) -> None:
    """Mark a new folder; raises VbbenchError if it is of something else."""
    if not (out / MARK).is_file():
        if any(entry.name != ".vbbench-lock" for entry in out.iterdir()):
            raise VbbenchError(f"{out} exists and is not the folder of a training; choose another folder")
        text = json.dumps({"vbbench": __version__, **facts}, indent=1, ensure_ascii=False)
        write_text_atomically(out / MARK, text + "\n")
    try:
        known: dict[str, Any] = json.loads((out / MARK).read_text("utf-8"))
    except ValueError as error:
        raise FileError(out / MARK, "is damaged: the facts of its training are lost; choose another folder") from error
    asked = json.loads(json.dumps(facts))
    other = [name for name in asked if known.get(name) != asked[name]]
    if other:
        raise VbbenchError(f"{out} is of a training with another {', '.join(other)}; choose another folder")


def _about(weights: Path, facts: dict[str, Any], results: dict[str, Any]) -> str:
    """The TOML text that `vbbench_baselines.former.weights` reads: SHA-256 of the weights, facts of their training."""
    told = {"vbbench": __version__, **{name: facts[name] for name in ("seed", "part")}, **results}
    lines = [f"sha256 = {json.dumps(sha256(weights.read_bytes()).hexdigest())}", f"pure = {json.dumps(facts['pure'])}"]
    lines += ["", "[training]", *(f"{json.dumps(name)} = {json.dumps(value)}" for name, value in told.items())]
    return "\n".join(lines) + "\n"


def _write_log(path: Path, rows: list[dict[str, Any]]) -> None:
    names = list(dict.fromkeys(name for row in rows for name in row))
    write_text_atomically(path, csv_text(names, ([row.get(name) for name in names] for row in rows)))


SIZE, WIDE, HIGH = (9.6, 3.9), 3.9, 2.3
"""In inches: the picture, and each of its panels."""


def draw_curve(log: Sequence[Mapping[str, Any]], sequences: int, path: Path) -> None:
    """Draw the rows of the ``log`` of a training on so many ``sequences``."""
    panels = {"loss": (0.7, 0.6, WIDE, HIGH), "held out": (0.7 + WIDE + 0.9, 0.6, WIDE, HIGH)}
    figure = lay_out(SIZE, panels)
    loss, held_out = figure.axes
    write_heading(
        figure,
        0.7,
        "Training",
        f"{log[-1]['windows']:,} windows of {sequences:,} sequences, {log[-1]['seconds']:,.0f} s",
    )
    _draw(loss, log, ["loss"], "loss of a batch")
    shown = [f"{name} people" for name in PROTOCOLS if f"{name} people" in log[-1]]
    _draw(held_out, log, shown, "Δx on held-out sequences (m)")
    names = [name.removesuffix(" people") for name in shown]
    look: dict[str, Any] = {"fontsize": TEXT_SIZE, "frameon": False, "columnspacing": 1.0, "handlelength": 1.2}
    held_out.legend(names, loc="lower left", bbox_to_anchor=(-0.03, 1.0), ncols=4, **look)
    save_picture(figure, path)


def _draw(axes: Axes, log: Sequence[Mapping[str, Any]], names: Sequence[str], label: str) -> None:
    windows = [row["windows"] for row in log]
    for name in names:
        axes.plot(windows, [row[name] for row in log], "." if len(log) == 1 else ".-" if len(log) < 20 else "-")
    axes.set(xlabel="windows learned from", ylabel=label, xlim=(0.0, 1.03 * windows[-1]), ylim=(0.0, None))
    axes.xaxis.set_major_formatter("{x:,.0f}")
    axes.xaxis.get_major_locator().set_params(nbins=4)  # type: ignore[call-arg]
    axes.grid(alpha=0.3)
