"""An unlimited stream of simulated sequences as a PyTorch dataset; without PyTorch see `vbbench.generation.stream`."""

from collections.abc import Iterator, Sequence

from vbbench.errors import needs_extra
from vbbench.generation.generator import Options
from vbbench.generation.stream import stream
from vbbench.sequence import SequenceData

with needs_extra("torch", "vbbench.generation.torch"):
    import torch
    from torch.nn.functional import pad
    from torch.utils.data import IterableDataset, get_worker_info

Example = dict[str, torch.Tensor]
"""One sequence: see `to_tensors`."""


class SimStream(IterableDataset[Example]):
    """Simulates during training. Workers of a `DataLoader`, and ranks, share the stream without overlap.

    The sequences are those of ``vbbench generate sim`` with the same options, in the same order. The number of workers
    decides which worker makes which; the content of a sequence depends only on the seed and its number.

    Parameters
    ----------
    options : what to simulate: `Options`, with `Simulation` for scenario and numbers of people.
    first, stop : the sequences to make; ``stop=None`` for an unlimited stream.
    rank, world_size : this process among those of distributed training.
    dtype : of every tensor but ``index`` and ``tracks``.
    """

    def __init__(
        self,
        options: Options | None = None,
        *,
        first: int = 0,
        stop: int | None = None,
        rank: int = 0,
        world_size: int = 1,
        dtype: torch.dtype = torch.float32,
    ) -> None:
        super().__init__()
        self.options, self.first, self.stop = options, first, stop
        self.rank, self.world_size, self.dtype = rank, world_size, dtype

    def __iter__(self) -> Iterator[Example]:
        info = get_worker_info()
        worker, workers = (0, 1) if info is None else (info.id, info.num_workers)
        shard, shards = self.rank * workers + worker, self.world_size * workers
        made = stream("sim", self.options, first=self.first, stop=self.stop, shard=shard, shards=shards)
        return (to_tensors(data, self.dtype) for data in made)


def to_tensors(data: SequenceData, dtype: torch.dtype = torch.float32) -> Example:
    """A sequence and its truth as tensors; NaN = absent, unseen or not given.

    Returns
    -------
    ``index`` [], ``tracks`` [K], ``observations`` [T, K, 3] in px, ``given_poses`` [T, 3] and ``given_positions``
    [T, K, 2] as `sequential` gives them, and the truth: ``poses`` [T, 3], ``positions`` [T, K, 2], ``heights`` [K].
    """
    sequence, truth = data.sequence, data.truth
    floats = {
        "observations": sequence.observations,
        "given_poses": sequence.given.poses,
        "given_positions": sequence.given.positions,
        "poses": truth.poses,
        "positions": truth.positions,
        "heights": truth.heights,
    }
    integers = {"index": torch.tensor(sequence.index), "tracks": torch.tensor(sequence.tracks)}
    return integers | {name: torch.tensor(values, dtype=dtype) for name, values in floats.items()}


PEOPLE_AXIS = {"tracks": 0, "observations": 1, "given_positions": 1, "positions": 1, "heights": 0}
"""The axis of K in each tensor that has one."""


def collate(examples: Sequence[Example]) -> Example:
    """A batch [B, …] of sequences of equal length: K is padded to the most people, with NaN, and tracks with −1."""
    most = max(len(example["tracks"]) for example in examples)
    return {name: torch.stack([_padded(name, example[name], most) for example in examples]) for name in examples[0]}


def _padded(name: str, values: torch.Tensor, people: int) -> torch.Tensor:
    if name not in PEOPLE_AXIS:
        return values
    axis = PEOPLE_AXIS[name]
    room = [0, 0] * (values.ndim - 1 - axis) + [0, people - values.shape[axis]]
    return pad(values, room, value=-1 if name == "tracks" else float("nan"))
