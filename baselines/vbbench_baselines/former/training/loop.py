"""The training loop, with checkpoints from which it resumes.

On a GPU the step is captured as a CUDA graph for each shape: a frame's forward and backward pass is thousands of small
kernels, which take longer to launch from Python than to run.

The folder of a training, from which a stopped one resumes.

OUT/training.json   recipe, seed and versions; marks the folder
OUT/crowds          the simulated sequences
OUT/checkpoint.pt   the newest checkpoint
OUT/log.csv         the log, which curve.png shows
OUT/weights.npz     the result; training.json then has its SHA-256
"""

import json
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from hashlib import sha256
from pathlib import Path
from time import process_time
from typing import Any, NamedTuple

import numpy as np
import torch
from matplotlib.axes import Axes
from numpy.typing import NDArray

from vbbench import __version__
from vbbench.errors import FileError, VbbenchError, quoted
from vbbench.folders.locks import locked
from vbbench.folders.replacing import replacing, write_text_atomically
from vbbench.parallel.parts import processes_of, progress_bar
from vbbench.pictures.plotting.style import TEXT_SIZE, lay_out, save_picture, write_heading
from vbbench.protocol import PROTOCOLS
from vbbench.table import csv_text
from vbbench_baselines.former.inference import read_weights
from vbbench_baselines.former.layers import Network, first_weights
from vbbench_baselines.former.network import Birdifier
from vbbench_baselines.former.training.batches import Batch, Feed, batch_of
from vbbench_baselines.former.training.crowds import Crowds, make_crowds
from vbbench_baselines.former.training.following import Errors, TensorOperations, follow
from vbbench_baselines.former.training.recipe import Recipe

SPREAD_WEIGHT = 0.03
"""What the likelihood of the spreads counts next to the errors."""
LONGEST_GRADIENT = 1.0
"""Longer gradients are cut to this length."""
LEAST_RATE, WARM_UP = 0.03, 50
"""Of the learning rate, what is left at the end, and over how many batches it rises."""
DECAY = 1e-4
"""By how much weights shrink (AdamW)."""
CHECK_EVERY, FEWEST_CHECKS = 100, 8
"""Batches from one look at the held-out windows, and one checkpoint, to the next; fewer in a short training."""
SPREAD_LAYERS = ("doubt", "pose_spread", "place_spread")
"""The layers that say how sure an answer is: errors teach them nothing, and they do not change answers."""
FACTS = ("batches", "windows", "averaged", "seconds", "log")
"""What a checkpoint says of how far a training is."""
CAPPED, ASTRAY = 2.0, 1.0
"""In m: what a window counts at most, and from where on it has failed."""

Arrays = dict[str, NDArray[np.float32]]


BEFORE_RECORDING = 2
"""Batches on a GPU before one is recorded, in which libraries make their own arrays."""
Learn = Callable[[Batch], Errors]
"""What is learned from a batch goes to the gradients of the weights, in place; its errors."""


class _Recording(NamedTuple):
    graph: torch.cuda.CUDAGraph
    batch: Batch
    errors: Errors


class Replaying:
    """``learn`` as a CUDA graph for each shape of batches; the next batch overwrites the errors that it returns."""

    def __init__(self, learn: Learn) -> None:
        self._learn, self._recordings, self._memory = learn, dict[torch.Size, _Recording](), None
        self._stream = torch.cuda.Stream()

    def __call__(self, batch: Batch) -> Errors:
        """Learn from a batch, which is moved to the GPU if it is not there."""
        shape = batch.true.shape
        if shape not in self._recordings:
            self._recordings[shape] = self._record(batch)
        recording = self._recordings[shape]
        recording.batch.take_over(batch)
        recording.graph.replay()
        return recording.errors

    def _record(self, batch: Batch) -> _Recording:
        own, graph = batch.to("cuda"), torch.cuda.CUDAGraph()
        self._stream.wait_stream(torch.cuda.current_stream())
        with torch.cuda.stream(self._stream):
            for _ in range(BEFORE_RECORDING):
                self._learn(own)
        torch.cuda.current_stream().wait_stream(self._stream)
        with torch.cuda.graph(graph, pool=self._memory, stream=self._stream):
            errors = Errors(*(values.detach() for values in self._learn(own)))
        self._memory = graph.pool()
        return _Recording(graph, own, errors)


@dataclass
class Training:
    """A training and its progress.

    Parameters
    ----------
    recipe, crowds, held_out : the recipe, its sequences, and the validation batches.
    seed : seed of the initial weights and of the windows.
    device : PyTorch device, such as ``cuda``. Only on ``cpu`` are weights the same each time.
    jobs : number of processes; all but one draw windows ahead.
    batches, windows : number of batches and windows so far.
    averaged : number of batches whose weights are averaged.
    seconds, log : processor time in s, and the rows of the log.
    """

    recipe: Recipe
    crowds: Crowds
    held_out: tuple[Batch, ...]
    seed: int
    device: str = "cpu"
    jobs: int = 1
    batches: int = 0
    windows: int = 0
    averaged: int = 0
    seconds: float = 0.0
    log: list[dict[str, Any]] = field(default_factory=list)

    def __post_init__(self) -> None:
        torch.set_num_threads(1)
        first = first_weights(np.random.default_rng(self.seed))
        self.weights = {
            name: torch.nn.Parameter(torch.from_numpy(values.astype(np.float32)).to(self.device))
            for name, values in first.items()
        }
        self._spreads = [values for name, values in self.weights.items() if name.startswith(SPREAD_LAYERS)]
        self._others = [values for name, values in self.weights.items() if not name.startswith(SPREAD_LAYERS)]
        device = torch.device(self.device)
        on_gpu = device.type == "cuda"
        if on_gpu and device.index is not None:
            torch.cuda.set_device(device)
        self._gradients: Learn = Replaying(self._differentiate) if on_gpu else self._differentiate
        self._feed = Feed(self.recipe, self.crowds, self.seed, filled=on_gpu)
        self.mean = {name: torch.zeros_like(values) for name, values in self.weights.items()}
        self._optimiser = torch.optim.AdamW(
            [
                {"params": [values for values in self.weights.values() if values.ndim > 1], "weight_decay": DECAY},
                {"params": [values for values in self.weights.values() if values.ndim == 1], "weight_decay": 0.0},
            ],
            lr=self.recipe.rate,
            betas=(0.9, 0.98),
        )

    def run(self, checkpoint: Path, report: Callable[[dict[str, Any]], None]) -> Arrays:
        """Train to the end, with checkpoints; returns the weights, averaged over the last part."""
        every, started = min(CHECK_EVERY, max(1, len(self._feed) // FEWEST_CHECKS)), process_time()
        for batch in self._feed.drawn(self.batches, self.jobs):
            errors = self._learn(batch)
            self.seconds += process_time() - started
            if self.batches % every == 0 or self.batches == len(self._feed):
                progress = {
                    "batches": self.batches,
                    "windows": self.windows,
                    "seconds": round(self.seconds, 1),
                    "frames": self.recipe.phase_at(self._part).frames,
                    "rate": self._rate(),
                    "loss": float(errors.loss.detach()),
                }
                self.log.append({**progress, **self.look(self.weights)})
                self.save(checkpoint)
                report(self.log[-1])
            started = process_time()
        return {name: values.cpu().numpy().copy() for name, values in self.mean.items()}

    def look(self, weights: Mapping[str, torch.Tensor]) -> dict[str, Any]:
        """Validate the weights on held-out windows.

        Capped means in m by protocol of people and camera, failure rates, and squared errors over their variances.
        """
        with torch.no_grad():
            batches = [batch.to(self.device) for batch in self.held_out]
            followed = [follow(self._birdifier(weights), batch) for batch in batches]
        protocol = torch.cat([batch.protocol for batch in batches])
        people = torch.cat([_means(errors.people, errors.counted) for errors in followed])
        camera = torch.cat([_means(errors.place, errors.shown) for errors in followed])
        found: dict[str, Any] = {}
        for number, name in enumerate(PROTOCOLS):
            chosen = protocol == number
            if chosen.any():
                counted = people[chosen & ~people.isnan()]
                found[f"{name} people"] = round(float(counted.clip(max=CAPPED).mean()), 4)
                found[f"{name} camera"] = round(float(camera[chosen].nan_to_num().clip(max=CAPPED).mean()), 4)
                found[f"{name} failed"] = round(float((camera[chosen] > ASTRAY).float().mean()), 4)
        surprises = {
            "pose surprise": [errors.pose_surprise[errors.shown > 0.5].mean() for errors in followed],
            "place surprise": [errors.place_surprise[errors.counted > 0.5].mean() for errors in followed],
        }
        return found | {name: round(float(torch.stack(values).mean()), 3) for name, values in surprises.items()}

    def _learn(self, batch: Batch) -> Errors:
        for group in self._optimiser.param_groups:
            group["lr"] = self._rate()
        errors = self._gradients(batch)
        torch.nn.utils.clip_grad_norm_(self._spreads, LONGEST_GRADIENT)
        if torch.isfinite(torch.nn.utils.clip_grad_norm_(self._others, LONGEST_GRADIENT)):
            self._optimiser.step()
        self.batches += 1
        self.windows += len(batch.dt)
        if self._part > 1.0 - self.recipe.averaged:
            self.averaged += 1
            with torch.no_grad():
                for name, values in self.weights.items():
                    self.mean[name] += (values - self.mean[name]) / self.averaged
        return errors

    def _differentiate(self, batch: Batch) -> Errors:
        """The errors of a batch; sets the gradients of the loss."""
        self._optimiser.zero_grad(set_to_none=False)
        errors = follow(self._birdifier(self.weights), batch)
        (errors.loss + SPREAD_WEIGHT * errors.spread_loss.mean()).backward()
        return errors

    def _birdifier(self, weights: Mapping[str, torch.Tensor]) -> Birdifier:
        """The network in training. Its fit excludes the factor of `heads`: in training windows heads turn freely."""
        return Birdifier(Network(TensorOperations(), weights), heads=False)

    @property
    def _part(self) -> float:
        """The share of the training that is done, in [0, 1]."""
        return self.windows / self.recipe.windows

    def _rate(self) -> float:
        """The learning rate: it rises quickly, stays, and falls as a cosine."""
        recipe = self.recipe
        late = max(0.0, self._part - recipe.decay) / (1.0 - recipe.decay)
        falling = LEAST_RATE + (1.0 - LEAST_RATE) * 0.5 * (1.0 + np.cos(np.pi * late))
        return float(recipe.rate * min(1.0, (1 + self.batches) / WARM_UP) * falling)

    def save(self, checkpoint: Path) -> None:
        """Write a checkpoint, atomically: weights, optimiser, averages, progress."""
        state = {
            "facts": json.dumps({name: getattr(self, name) for name in FACTS}),
            "weights": dict(self.weights),
            "mean": self.mean,
            "optimiser": self._optimiser.state_dict(),
        }
        with replacing(checkpoint) as draft:
            torch.save(state, draft)

    def resume(self, checkpoint: Path) -> None:
        """Go on from a checkpoint.

        Raises FileError if it cannot be read.
        """
        try:
            state = torch.load(checkpoint, weights_only=True, map_location=self.device)
        except Exception as error:  # whatever PyTorch raises on damaged bytes
            raise FileError(checkpoint, "is damaged; remove it, and the training begins again") from error
        for name, value in json.loads(state["facts"]).items():
            setattr(self, name, value)
        with torch.no_grad():
            for name, values in self.weights.items():
                values.copy_(state["weights"][name])
        self.mean = state["mean"]
        self._optimiser.load_state_dict(state["optimiser"])


def held_out_batches(recipe: Recipe, crowds: Crowds) -> tuple[Batch, ...]:
    """Validation windows of held-out crowds, of each size, as long as those of the last phase."""
    rng = np.random.default_rng([recipe.held_out_seed, 0])
    sizes = [replace(size, windows=recipe.held_out) for size in recipe.size]
    return tuple(batch_of(rng, crowds, recipe, recipe.phase[-1], size) for size in sizes)


def _means(values: torch.Tensor, counted: torch.Tensor) -> torch.Tensor:
    """[B] means over frames and people that count; NaN where none does."""
    axes = tuple(range(1, values.ndim))
    return (values * counted).sum(axes) / counted.sum(axes)


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
    part : share of the recipe's sequences and windows.
    """

    recipe: Recipe
    seed: int = 0
    part: float = 1.0


def train(out: Path, asked: Asked, *, crowds: Path | None = None, device: str = "cpu", jobs: int = 1) -> Path:
    """Train in the folder ``out``, or resume there; returns the path of the weights.

    Raises VbbenchError if the folder is not of this training, a file in it is damaged, the device cannot be used, or
    there cannot be so many processes.

    Parameters
    ----------
    crowds : folder of the simulated sequences, which several trainings can share; ``None`` for one in ``out``.
    device : see `vbbench_baselines.former.training.loop.Training`.
    jobs : see there; as many processes make the crowds. −1 for one per core.
    """
    _check_device(device)
    windows, jobs = max(1, round(asked.part * asked.recipe.windows)), processes_of(jobs)
    recipe = replace(asked.recipe, windows=windows)
    facts = asdict(replace(asked, recipe=recipe))
    out.mkdir(parents=True, exist_ok=True)
    with locked(out):
        _begin(out, facts)
        with suppress(FileError):  # weights that have the checksum of their recipe
            read_weights(out / WEIGHTS)
            return out / WEIGHTS
        folder = crowds or out / CROWDS
        learned = make_crowds(recipe, folder, recipe.seed, part=asked.part, jobs=jobs)
        held_out = make_crowds(recipe, folder, recipe.held_out_seed, part=HELD_OUT_PART, jobs=jobs)
        batches = held_out_batches(recipe, held_out)
        training = Training(recipe, learned, batches, asked.seed, device, jobs)
        if (out / CHECKPOINT).is_file():
            training.resume(out / CHECKPOINT)
        with progress_bar(recipe.windows, "windows", done=training.windows, unit="window") as bar:

            def report(row: dict[str, Any]) -> None:
                bar.update(row["windows"] - bar.n)
                names = list(dict.fromkeys(name for one in training.log for name in one))
                rows = ([one.get(name) for name in names] for one in training.log)
                write_text_atomically(out / LOG, csv_text(names, rows))
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
    """The TOML text that `inference` reads: SHA-256 of the weights, facts of their training."""
    known = {"vbbench": __version__, **{name: facts[name] for name in ("seed", "part")}, **results}
    lines = [f"sha256 = {json.dumps(sha256(weights.read_bytes()).hexdigest())}"]
    lines += ["", "[training]", *(f"{json.dumps(name)} = {json.dumps(value)}" for name, value in known.items())]
    return "\n".join(lines) + "\n"


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
