"""The filter's update: velocities are corrected by a learned share (gain) of the last innovation.

A person has a gain along and one across the ray, where boxes err differently; the observer's are forward, left and in
turn rate. Innovations also add up in traces, which decay at learned rates.
"""

from typing import NamedTuple

from vbbench_baselines.former.heads import odds_after, smoothed
from vbbench_baselines.former.layers import Network
from vbbench_baselines.former.operations import Array
from vbbench_baselines.former.state import TRACES, Observer, State, Walkers


class Walks(NamedTuple):
    """Filtered velocities and traces, in the axes of the last pose.

    Attributes
    ----------
    velocity, traces : [..., K] and [..., K, `TRACES`] of people, in m/s, complex.
    offsets : [..., K, 2] of people, see `vbbench_baselines.former.state.Walkers`.
    begins : [..., K] 1 where a track has just begun.
    own : the observer, with updated velocity, turn rate and traces.
    surprise : [..., 3] the observer's innovation.
    own_begins : [...] as ``begins``.
    """

    velocity: Array
    traces: Array
    offsets: Array
    begins: Array
    own: Observer
    surprise: Array
    own_begins: Array


def taken_in(network: Network, state: State, dt: Array) -> Walks:
    """The filtered velocities after the last frame; the next one is ``dt`` [...] s later."""
    return Walks(*_people(network, state.people, dt), *_observer(network, state.observer, dt))


def _people(network: Network, people: Walkers, dt: Array) -> tuple[Array, Array, Array, Array]:
    """People's velocities, traces and offsets, and 1 where a track begins."""
    xp = network.operations
    kept = xp.sqrt(people.place.real**2 + people.place.imag**2 + 1e-4)
    toward = people.place / kept
    fresh = people.shown * people.traceable
    strange = (people.place - people.place_before) / dt[..., None] - people.velocity
    back = toward.conj()
    off, pace = strange * back, people.velocity * back
    begins = xp.where(people.seen < 2.5, fresh, 0.0 * fresh)
    offs = xp.pairs(off)
    by_box = xp.stack([people.by_height, people.by_feet])
    farther = xp.clip(xp.log(kept)[..., None] - by_box, -0.5, 0.5) - people.offsets
    farther = farther * xp.stack([people.shown, people.shown * people.has_feet])
    past = [begins, people.exact, people.exact_before, xp.log(1.0 + people.seen), xp.log(kept)]
    past.append(xp.log(dt)[..., None] + 0.0 * kept)
    facts = [xp.asinh(2.0 * offs), xp.pairs(pace), 0.3 * offs, 5.0 * farther, xp.stack(past), people.memory]
    told = network.perceptron("walk", xp.join(facts))
    taken = fresh[..., None]
    gains = xp.sigmoid(told[..., :2] + (4.0 * begins)[..., None]) * taken
    velocity = people.velocity + xp.point(gains[..., 0] * off.real, gains[..., 1] * off.imag) * toward
    offsets = people.offsets + xp.sigmoid(told[..., 2:4]) * farther
    keep = 1.0 - taken * (1.0 - xp.sigmoid(told[..., 4 : 4 + TRACES]))
    add = xp.tanh(told[..., 4 + TRACES :]) * taken * (1.0 - begins)[..., None]
    return velocity, people.traces * keep + add * strange[..., None], offsets, begins


def _observer(network: Network, own: Observer, dt: Array) -> tuple[Observer, Array, Array]:
    """The updated observer, its innovation, and 1 where its motion begins."""
    xp = network.operations
    strange, turned = own.step - own.velocity, own.turn - own.turn_rate
    begins = xp.where(own.frames < 2.5, 1.0 + 0.0 * dt, 0.0 * dt)
    surprise = xp.asinh(2.0 * xp.stack([strange.real, strange.imag, turned]))
    others = xp.stack([own.velocity.real, own.velocity.imag, own.turn_rate, begins, own.told, xp.log(dt)])
    told = network.perceptron("own_walk", xp.join([surprise, others, own.memory]))
    moved = own.moved[..., None]
    gains = xp.sigmoid(told[..., :3] + 4.0 * begins[..., None]) * moved
    keep = 1.0 - moved * (1.0 - xp.sigmoid(told[..., 3 : 3 + TRACES]))
    add = xp.tanh(told[..., 3 + TRACES :]) * (own.moved * (1.0 - begins))[..., None]
    smooth = xp.where(own.frames < 2.5, own.step, smoothed(xp, own.smooth, own.step, dt)) * own.moved
    odds = odds_after(xp, own.head_odds, smooth, own.turn, dt)
    renewed = own._replace(
        velocity=own.velocity + xp.point(gains[..., 0] * strange.real, gains[..., 1] * strange.imag),
        turn_rate=own.turn_rate + gains[..., 2] * turned,
        smooth=smooth,
        head_odds=xp.where(own.frames < 3.5, own.head_odds, odds),
        traces=own.traces * keep + add * strange[..., None],
    )
    return renewed, surprise, begins
