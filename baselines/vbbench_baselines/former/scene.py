"""A frame before its pose is fitted: predictions, measurements, their variances, and an approximate motion.

The filter's update: velocities are corrected by a learned share (gain) of the last innovation.

A person has a gain along and one across the ray, where boxes err differently; the observer's are forward, left and in
turn rate. Innovations also add up in traces, which decay at learned rates.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vbbench.geometry import FloatArray
from vbbench.solver import Problem
from vbbench_baselines.common.bearings import FEET_CUT, HEAD_CUT, SIDE_CUT, bearings_of
from vbbench_baselines.former.heads import odds_after, smoothed
from vbbench_baselines.former.layers import Network
from vbbench_baselines.former.operations import Array, Operations
from vbbench_baselines.former.pose_fit import Measured, Motion, Views, Weighing, align, fit, view, with_measured
from vbbench_baselines.former.state import TRACES, Observer, State, Walkers


def _filtered(network: Network, people: Walkers, dt: Array) -> tuple[Walkers, Array]:
    """People after the last frame, the next one ``dt`` [...] s later, and 1 where a track begins."""
    xp = network.operations
    kept = xp.sqrt(people.place.real**2 + people.place.imag**2 + 1e-4)
    far, toward = xp.log(kept), people.place / kept
    fresh = people.shown * people.traceable
    strange = (people.place - people.place_before) / dt[..., None] - people.velocity
    back = toward.conj()
    off, pace = xp.pairs(strange * back), xp.pairs(people.velocity * back)
    begins = fresh * (people.seen < 2.5)
    by_box = xp.stack([people.by_height, people.by_feet])
    farther = xp.clip(far[..., None] - by_box, -0.5, 0.5) - people.offsets
    farther = farther * xp.stack([people.shown, people.shown * people.has_feet])
    past = [begins, people.exact, people.exact_before, xp.log(1.0 + people.seen), far]
    past.append(xp.log(dt)[..., None] + 0.0 * far)
    facts = [xp.asinh(2.0 * off), pace, 0.3 * off, 5.0 * farther, xp.stack(past), people.memory]
    out = network.perceptron("walk", xp.join(facts))
    taken = fresh[..., None]
    gains = xp.sigmoid(out[..., :2] + (4.0 * begins)[..., None]) * taken
    velocity = people.velocity + xp.points(gains * off) * toward
    kept = xp.sigmoid(out[..., 2 : 4 + TRACES])
    offsets = people.offsets + kept[..., :2] * farther
    keep = 1.0 - taken * (1.0 - kept[..., 2:])
    add = xp.tanh(out[..., 4 + TRACES :]) * (fresh - begins)[..., None]
    traces = people.traces * keep + add * strange[..., None]
    return people._replace(velocity=velocity, traces=traces, offsets=offsets), begins


def _filtered_observer(network: Network, own: Observer, dt: Array) -> tuple[Observer, Array, Array]:
    """The updated observer, its innovation [..., 3], and 1 where its motion begins."""
    xp = network.operations
    strange, turned = own.step - own.velocity, own.turn - own.turn_rate
    begins = xp.where(own.frames < 2.5, 1.0 + 0.0 * dt, 0.0 * dt)
    off = xp.stack([strange.real, strange.imag, turned])
    surprise = xp.asinh(2.0 * off)
    others = xp.stack([own.velocity.real, own.velocity.imag, own.turn_rate, begins, own.given, xp.log(dt)])
    out = network.perceptron("own_walk", xp.join([surprise, others, own.memory]))
    moved = own.moved[..., None]
    ahead, left, faster = xp.unstack(xp.sigmoid(out[..., :3] + 4.0 * begins[..., None]) * moved * off)
    keep = 1.0 - moved * (1.0 - xp.sigmoid(out[..., 3 : 3 + TRACES]))
    add = xp.tanh(out[..., 3 + TRACES :]) * (own.moved * (1.0 - begins))[..., None]
    smooth = xp.where(own.frames < 2.5, own.step, smoothed(xp, own.smooth, own.step, dt)) * own.moved
    odds = odds_after(xp, own.head_odds, smooth, own.turn, dt)
    renewed = own._replace(
        velocity=own.velocity + xp.point(ahead, left),
        turn_rate=own.turn_rate + faster,
        smooth=smooth,
        head_odds=xp.where(own.frames < 3.5, own.head_odds, odds),
        traces=own.traces * keep + add * strange[..., None],
    )
    return renewed, surprise, begins


LOWEST, HIGHEST = -1.6, 4.8
"""ln of the nearest and farthest distance in m that counts."""
SMALLEST_SLOPE = 1e-3
"""Feet nearer to the horizon than this, in m per m, have no information."""
LEAST_STD, MOST_STD, UNKNOWN_STD = 1e-4, 3.0, 0.1
"""Bounds of noise, and what stands where there is no box."""
_CUTS = np.array((FEET_CUT, HEAD_CUT, SIDE_CUT))


class Sights(NamedTuple):
    """Measurements of people [..., K]; 0 where there is no box.

    Attributes
    ----------
    seen : 1 where there is a box.
    ray : towards the person, forward + i·left of the camera; 1 where there is no box.
    by_height, by_feet : ln of the distance in m, for a person of mean height, and for feet on level ground.
    has_feet : 1 where the foot cue measures a distance.
    noise : [..., K, 3] standard deviations in rad of the ray, and of the two logarithms.
    cut : [..., K, 3] 1 where the picture's border may cut off feet, head or a side.
    """

    seen: Array
    ray: Array
    by_height: Array
    by_feet: Array
    has_feet: Array
    noise: Array
    cut: Array


def sights_of(problem: Problem, boxes: FloatArray) -> Sights:
    """The measurements of boxes [..., K, 3] (u, v, l) in px; NaN = no box."""
    with np.errstate(divide="ignore", invalid="ignore"):
        camera, found = problem.camera, bearings_of(problem.camera, boxes)
        edge = np.hypot(problem.pixel_std, problem.box_std * found.size) / found.size
        foot = np.where(found.foot > SMALLEST_SLOPE, found.foot, np.nan)
        slope_std = np.hypot(edge * found.length, problem.tilt_std)
        noise = np.empty((*foot.shape, 3))
        np.multiply(edge, found.width, out=noise[..., 0])
        np.multiply(edge, math.sqrt(2.0), out=noise[..., 1])
        np.hypot(slope_std / foot, problem.mount_height_std / camera.mount_height, out=noise[..., 2])
        far = np.log(np.array((problem.height_mean / found.length, camera.mount_height / foot)))
    seen, stands = known = ~np.isnan(far)
    by_height, by_feet = _single(np.where(known, far.clip(LOWEST, HIGHEST), 0.0))
    return Sights(
        seen=_single(seen),
        ray=np.exp(-1j * np.where(seen, found.azimuth, 0.0)).astype(np.complex64),
        by_height=by_height,
        by_feet=by_feet,
        has_feet=_single(seen & stands & (found.cut & FEET_CUT == 0)),
        noise=_single(np.where(np.isnan(noise), UNKNOWN_STD, noise.clip(LEAST_STD, MOST_STD))),
        cut=_single(seen[..., None] & (found.cut[..., None] & _CUTS > 0)),
    )


def _single(values: NDArray[Any]) -> NDArray[np.float32]:
    return values.astype(np.float32)


STRIDE, WALK, EXACT = 0.4, 0.15, 0.01
"""In m/s, what an error is measured by, and how far people stray from a straight walk; in m, how far those given do."""
OWN_WALK, OWN_TURN = 0.3, 1.5
"""In m/s and rad/s: how far the observer strays."""


class LocalGiven(NamedTuple):
    """What is given of a frame, relative to the last pose.

    Attributes
    ----------
    places, placed : [..., K] places of people in m (complex), and 1 where they are given.
    motion, moved : the observer's motion, and [...] 1 where it is given.
    measured : the motion by odometry; ``None`` without it.
    """

    places: Array
    placed: Array
    motion: Motion
    moved: Array
    measured: Measured | None = None


class Scene(NamedTuple):
    """What is known of a frame.

    Attributes
    ----------
    sights, given, dt, spread : as given to `foresee`.
    people, own : state of people and observer with filtered velocities and traces, in the axes of the last pose.
    begins, own_begins : [..., K] and [...] 1 where a track, and the observer's motion, has just begun.
    surprise : [..., 3] the observer's innovation.
    placed : [..., K] True for people whose place is given.
    known : [..., K] 1 for people who are seen and predicted.
    distance, distance_std : [..., K] ln of the distance in m by height and feet together, and its standard deviation.
    views : predictions and measurements for the fit.
    box_stds : [..., K, 2] standard deviations in m of boxes along and across their rays.
    stds : [..., K, 2] the same of boxes and walks together.
    information : [..., K, 2] 1/variance in 1/m² of boxes and walks together; 0 for people who are not known.
    count : [...] number of people known.
    expected, inertia : the observer's predicted motion, and its information [..., 3].
    scale : [..., 1] in m, the unit of residuals as features.
    """

    sights: Sights
    given: LocalGiven
    dt: Array
    spread: Array
    people: Walkers
    own: Observer
    begins: Array
    own_begins: Array
    surprise: Array
    placed: Array
    known: Array
    distance: Array
    distance_std: Array
    views: Views
    box_stds: Array
    stds: Array
    information: Array
    count: Array
    expected: Motion
    inertia: Array
    scale: Array

    def or_given(self, operations: Operations, motion: Motion) -> Motion:
        """The given motion where there is one, else ``motion``."""
        given, moved = self.given.motion, self.given.moved > 0.5
        return Motion(*(operations.where(moved, one, other) for one, other in zip(given, motion, strict=True)))


def foresee(network: Network, state: State, sights: Sights, given: LocalGiven, dt: Array, spread: Array) -> Scene:
    """Predict the frame ``dt`` [...] s after ``state``; parameters as in `network.Birdifier.advance`."""
    xp, placed = network.operations, given.placed > 0.5
    people, begins = _filtered(network, state.people, dt)
    own, surprise, own_begins = _filtered_observer(network, state.observer, dt)
    distance, std = _distance(xp, people, sights, spread)
    reach = xp.exp(distance)
    box_stds = xp.stack([std, sights.noise[..., 0]]) * reach[..., None]
    stray = ((WALK * dt)[..., None] * (1.0 - given.placed) + EXACT) ** 2
    variances = box_stds**2 + stray[..., None]
    known = sights.seen * ((people.seen > 0.5) | placed)
    walk, turn = (OWN_WALK * dt + 0.01) ** -2.0, (OWN_TURN * dt + 0.05) ** -2.0
    return Scene(
        sights=sights,
        given=given,
        dt=dt,
        spread=spread,
        people=people,
        own=own,
        begins=begins,
        own_begins=own_begins,
        surprise=surprise,
        placed=placed,
        known=known,
        distance=distance,
        distance_std=std,
        views=Views(
            expected=xp.where(placed, given.places, people.place + people.velocity * dt[..., None]),
            reach=reach,
            seen=sights.ray * reach,
            ray=sights.ray,
            upright=sights.ray.conj(),
        ),
        box_stds=box_stds,
        stds=xp.sqrt(variances),
        information=known[..., None] / variances,
        count=known.sum(-1),
        expected=Motion(own.velocity * dt, own.turn_rate * dt),
        inertia=xp.stack([walk, walk, turn]),
        scale=(STRIDE * dt)[..., None],
    )


def rough_motion(operations: Operations, scene: Scene) -> Motion:
    """The observer's motion by a robust fit, in which people far from their predictions have less weight."""
    views = scene.views
    inertia, expected = with_measured(operations, scene.inertia, scene.expected, scene.given.measured)
    plain = Weighing(scene.information, 0.0 * views.ray, inertia, expected)
    rough, _ = fit(operations, views, plain, align(operations, views, plain), 1)
    _, off = view(operations, views, rough)
    doubtful = 1.0 + 0.25 * ((operations.pairs(off) / scene.stds) ** 2).sum(-1)
    plain = plain._replace(weights=plain.weights / doubtful[..., None])
    rough, _ = fit(operations, views, plain, rough, 1)
    return scene.or_given(operations, rough)


def _distance(xp: Operations, people: Walkers, sights: Sights, spread: Array) -> tuple[Array, Array]:
    """Ln of the distance [..., K] in m by height and feet together, and its standard deviation."""
    stature = spread[..., None] * (1.0 + people.seen) ** -0.5
    by_height = 1.0 / (sights.noise[..., 1] ** 2 + stature**2 + 1e-5)
    by_feet = sights.has_feet / (sights.noise[..., 2] ** 2 + 1e-5)
    measured = by_height * (sights.by_height + people.offsets[..., 0])
    measured = measured + by_feet * (sights.by_feet + people.offsets[..., 1])
    total = by_height + by_feet
    return xp.clip(measured / total, LOWEST, HIGHEST), total**-0.5
