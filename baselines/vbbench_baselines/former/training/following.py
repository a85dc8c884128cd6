"""Unrolls the network over a batch of windows on its own estimates; the loss is of all frames' errors.

The loss of an error e is ln(1 + 4 e)/4, e in m (rad count twice): a diverged sequence with errors of metres does not
outweigh the centimetres of the others.
"""

from functools import partial
from typing import NamedTuple

import torch
from torch.nn import functional

from vbbench.protocol import START_FRAMES
from vbbench_baselines.former.certainty import NARROWEST, WIDEST
from vbbench_baselines.former.network import Answer, Birdifier
from vbbench_baselines.former.operations import Array, Operations
from vbbench_baselines.former.pose_fit import Motion
from vbbench_baselines.former.scene import LocalGiven, Sights
from vbbench_baselines.former.state import State, nothing_seen
from vbbench_baselines.former.training.batches import COLD_START, ONE_STEP, Batch

SHARPNESS = 4.0
"""In 1/m: errors below 1/4 m count in full, larger ones as their logarithm."""
RELATIVE, TURN = 0.4, 2.0
"""What errors of people from the camera count, and a rad, next to errors of places in m."""
BLIND = 0.3
"""What the camera's errors count while nobody is seen, when no score counts them."""
MOST_WRONG = 4.0
"""In m and rad: how far off an answer is at most, for what it says of its spread."""


class Errors(NamedTuple):
    """Errors of the frames from the third on, tensors [B, L − 2, ...].

    Attributes
    ----------
    people, relative : [K] errors of people in m, in the world and relative to the camera; ``counted`` 1 where scored.
    place, yaw : errors of the camera in m and rad; ``shown`` 1 where a person is seen.
    pose_surprise, place_surprise : [3] and [K, 2] squared errors over the variances that the network estimates.
    spread_loss : negative log likelihood of the errors under these variances, up to a constant.
    """

    people: torch.Tensor
    relative: torch.Tensor
    counted: torch.Tensor
    place: torch.Tensor
    yaw: torch.Tensor
    shown: torch.Tensor
    pose_surprise: torch.Tensor
    place_surprise: torch.Tensor
    spread_loss: torch.Tensor

    @property
    def loss(self) -> torch.Tensor:
        """The loss that training minimises."""
        count = self.counted.sum(-1)
        people = ((_compressed(self.people) + RELATIVE * _compressed(self.relative)) * self.counted).sum(-1)
        camera = (_compressed(self.place) + TURN * _compressed(self.yaw)) * (BLIND + (1.0 - BLIND) * self.shown)
        return (people / (count + 1e-3) + camera).mean()


def _direction(angle: torch.Tensor) -> torch.Tensor:
    return torch.complex(torch.cos(angle), torch.sin(angle))


class TensorOperations(Operations):
    """The operations on tensors."""

    where, exp, log, sqrt = (staticmethod(do) for do in (torch.where, torch.exp, torch.log, torch.sqrt))
    asinh, tanh, sigmoid = (staticmethod(do) for do in (torch.asinh, torch.tanh, torch.sigmoid))
    clip, point, transposed, detach = (staticmethod(do) for do in (torch.clip, torch.complex, torch.t, torch.detach))
    stack, join, unstack = (staticmethod(partial(do, dim=-1)) for do in (torch.stack, torch.cat, torch.unbind))
    softmax, direction = staticmethod(partial(torch.softmax, dim=-2)), staticmethod(_direction)

    def silu(self, x: Array) -> Array:
        """See `Operations`."""
        return functional.silu(x)

    def angle(self, x: Array) -> Array:
        """See `Operations`."""
        return torch.atan2(x.imag, x.real)

    def pairs(self, points: Array) -> Array:
        """See `Operations`."""
        return torch.stack([points.real, points.imag], -1)

    def points(self, pairs: Array) -> Array:
        """See `Operations`."""
        return torch.complex(pairs[..., 0], pairs[..., 1])

    def append_row(self, rows: Array, row: Array) -> Array:
        """See `Operations`."""
        return torch.cat([rows, row[..., None, :]], -2)

    def normalise(self, x: Array, gain: Array, bias: Array) -> Array:
        """See `Operations`."""
        return functional.layer_norm(x, (x.shape[-1],), gain, bias)


def follow(birdifier: Birdifier, batch: Batch) -> Errors:
    """The errors of the network on a batch, unrolled frame by frame."""
    size, frames, people = batch.true.shape
    state = nothing_seen(
        lambda *shape: batch.yaw.new_zeros((size, *shape)),
        lambda *shape: batch.place.new_zeros((size, *shape)),
        people,
    )
    place, yaw, found = batch.place[:, 0], batch.yaw[:, 0], []
    for t in range(frames):
        if t >= START_FRAMES:
            state, place, yaw = _reveal(state, batch, t, place, yaw)
        sights = Sights(*(values[:, t] for values in batch.sights))
        state, answer = birdifier.advance(state, sights, _given(batch, t, place, yaw), batch.dt, batch.spread)
        place, yaw = place + answer.motion.step * _direction(yaw), yaw + answer.motion.turn
        if t >= START_FRAMES:
            found.append(_errors(batch, t, place, yaw, answer))
    return Errors(*(torch.stack(values, 1) for values in zip(*found, strict=True)))


def _given(batch: Batch, t: int, place: torch.Tensor, yaw: torch.Tensor) -> LocalGiven:
    """What is given of frame ``t``: the pose of frames 0 and 1, and people's places by the protocol."""
    moved = torch.zeros_like(yaw) if t >= START_FRAMES else torch.ones_like(yaw)
    if t == 1:
        moved = (batch.protocol != COLD_START).float()
    motion = Motion((batch.place[:, t] - place) * _direction(-yaw), _wrapped(batch.yaw[:, t] - yaw))
    places = (batch.positions[:, t] - place[:, None]) * _direction(-yaw)[:, None]
    return LocalGiven(places, batch.given[:, t], motion, moved)


def _reveal(
    state: State, batch: Batch, t: int, place: torch.Tensor, yaw: torch.Tensor
) -> tuple[State, torch.Tensor, torch.Tensor]:
    """State and pose with the true values of frames t − 1 and t − 2, where the protocol is one-step."""
    one = batch.protocol == ONE_STEP
    place, yaw = torch.where(one, batch.place[:, t - 1], place), torch.where(one, batch.yaw[:, t - 1], yaw)
    local = _direction(-yaw)[:, None]
    people, own, exact = state.people, state.observer, yaw.new_ones(())
    last, before = (one[:, None] & (batch.true[:, t - back] > 0.5) for back in (1, 2))
    people = people._replace(
        place=torch.where(last, (batch.positions[:, t - 1] - place[:, None]) * local, people.place),
        place_before=torch.where(before, (batch.positions[:, t - 2] - place[:, None]) * local, people.place_before),
        exact=torch.where(last, exact, people.exact),
        exact_before=torch.where(before, exact, people.exact_before),
    )
    step = (batch.place[:, t - 1] - batch.place[:, t - 2]) * local[:, 0] / batch.dt
    turn = _wrapped(batch.yaw[:, t - 1] - batch.yaw[:, t - 2]) / batch.dt
    own = own._replace(
        step=torch.where(one, step, own.step),
        turn=torch.where(one, turn, own.turn),
        given=torch.where(one, exact, own.given),
    )
    return State(people, own), place, yaw


def _errors(batch: Batch, t: int, place: torch.Tensor, yaw: torch.Tensor, answer: Answer) -> tuple[torch.Tensor, ...]:
    """The fields of `Errors` for one frame, in its order."""
    true_place, true_yaw, true = batch.place[:, t], batch.yaw[:, t], batch.positions[:, t]
    facing = _direction(yaw)
    wrong = place[:, None] + answer.places * facing[:, None] - true
    relative = answer.places - (true - true_place[:, None]) * _direction(-true_yaw)[:, None]
    counted, shown = batch.scored[:, t], (batch.sights.seen[:, t].sum(-1) > 0).float()
    with torch.no_grad():
        ahead = (true_place - place) * facing.conj()
        off = torch.stack([ahead.real, ahead.imag, _wrapped(true_yaw - yaw)], -1).clip(-MOST_WRONG, MOST_WRONG)
        aside = -wrong * (facing[:, None] * batch.sights.ray[:, t]).conj()
        astray = torch.stack([aside.real, aside.imag], -1).clip(-MOST_WRONG, MOST_WRONG)
    pose_loss, pose_surprise = _likelihood(answer.pose_spread, off)
    place_loss, place_surprise = _likelihood(answer.place_spread, astray)
    spread_loss = pose_loss * shown + (place_loss * counted).sum(-1) / (counted.sum(-1) + 1e-3)
    return (
        _length(wrong),
        _length(relative),
        counted,
        _length(place - true_place),
        _wrapped(yaw - true_yaw).abs(),
        shown,
        pose_surprise,
        place_surprise,
        spread_loss,
    )


def _likelihood(spread: torch.Tensor, off: torch.Tensor) -> tuple[torch.Tensor, torch.Tensor]:
    """−ln of the normal density of errors ``off``, up to a constant, and their squares over the variances."""
    spread = spread.clip(NARROWEST, WIDEST)
    surprise = off**2 * torch.exp(-2.0 * spread)
    return (spread + 0.5 * surprise).sum(-1), surprise.detach()


def _length(vector: torch.Tensor) -> torch.Tensor:
    return torch.sqrt(vector.real**2 + vector.imag**2 + 1e-6)


def _wrapped(angle: torch.Tensor) -> torch.Tensor:
    return torch.remainder(angle + torch.pi, 2.0 * torch.pi) - torch.pi


def _compressed(error: torch.Tensor) -> torch.Tensor:
    return torch.log1p(SHARPNESS * error) / SHARPNESS
