"""The forward pass of one frame: filter, predict, attend, fit the pose, update the state.

Positions are relative to the last pose: the answer is equivariant to people's order and to the world's origin. In turn,

1. each person's velocity is corrected by a share of the last innovation (`walking`),
2. constant velocity predicts all places, and a plain robust fit gives an approximate motion of the camera (`scene`),
3. people and observer attend to one another, which yields the weights and offsets of the residuals,
4. the pose is fitted with these, attended to again, and fitted again,
5. people's places are corrected by a share of their residuals, and memories are updated (`remembering`).
"""

from dataclasses import dataclass
from typing import NamedTuple

from vbbench_baselines.former.heads import head_of
from vbbench_baselines.former.layers import Network
from vbbench_baselines.former.operations import Array
from vbbench_baselines.former.pose_fit import Motion, Weighing, fit, view, with_measured
from vbbench_baselines.former.remembering import (
    Found,
    observer_facts,
    person_facts,
    remembered,
    second_look,
    spreads,
    state_after,
)
from vbbench_baselines.former.scene import LocalGiven, Scene, Sights, foresee, rough_motion
from vbbench_baselines.former.state import State

FAR = 1e4
"""As good as infinite, for a logarithm."""


class Answer(NamedTuple):
    """The network's output for a frame.

    Attributes
    ----------
    motion : motion of the observer since the last pose.
    places : [..., K] places of people relative to the new pose, in m, complex.
    pose_spread : [..., 3] ln of the standard deviations of the pose forward, left and in yaw, since all was given.
    place_spread : [..., K, 2] the same of people's places in the world, along and across their rays.
    """

    motion: Motion
    places: Array
    pose_spread: Array
    place_spread: Array


@dataclass(frozen=True)
class Birdifier:
    """The network with its options.

    Parameters
    ----------
    network : its layers.
    heads : whether the fit includes the factor of `heads`.
    """

    network: Network
    heads: bool = True

    def advance(
        self, state: State, sights: Sights, given: LocalGiven, dt: Array, spread: Array
    ) -> tuple[State, Answer]:
        """The state after a frame of ``dt`` [...] s, and the answer.

        ``spread`` [...] is the standard deviation of heights, as a share of their mean.
        """
        network = self.network
        scene = foresee(network, state, sights, given, dt, spread)
        rough = rough_motion(network.operations, scene)
        rows, own_row = self._attend(scene, rough)
        weighing, motion = self._first_pose(scene, rough, network.linear("trust", rows), own_row)
        found = self._find(scene, weighing, motion, rows, own_row)
        scene = remembered(network, scene, found)
        answer = Answer(found.motion, found.places, *spreads(network, scene, found))
        return state_after(network.operations, scene, found), answer

    def _attend(self, scene: Scene, rough: Motion) -> tuple[Array, Array]:
        """Step 3: hidden features of people [..., K, `WIDTH`] and of the observer [..., `WIDTH`]."""
        xp, network = self.network.operations, self.network
        rows = network.perceptron("person", person_facts(xp, scene, rough))
        own_row = network.perceptron("observer", observer_facts(xp, scene, rough))
        hidden = xp.join([(scene.sights.seen - 1.0) * FAR, 0.0 * scene.dt[..., None]])
        rows = network.attend(xp.append_row(rows, own_row), hidden)
        return rows[..., :-1, :], rows[..., -1, :]

    def _first_pose(self, scene: Scene, rough: Motion, trust: Array, own_row: Array) -> tuple[Weighing, Motion]:
        """Step 4: the weights of the fit, and its motion."""
        xp, dt, own, expected = self.network.operations, scene.dt, scene.own, scene.expected
        own_trust = self.network.linear("own_trust", own_row)
        inertia = scene.inertia * xp.exp(xp.clip(own_trust[..., 3:6], -6.0, 6.0))
        ahead, left, turn = xp.unstack(own_trust[..., :3])
        said = Motion(expected.step + xp.point(ahead, left) * (0.3 * dt), expected.turn + turn * (0.5 * dt))
        inertia, said = with_measured(xp, inertia, said, scene.given.measured)
        weighing = Weighing(
            weights=scene.information * xp.exp(xp.clip(trust[..., 2:4], -6.0, 5.0)),
            offset=xp.points(trust[..., :2]) * (scene.scale * (1.0 - scene.given.placed)),
            inertia=inertia,
            motion=said,
            head=head_of(xp, own.smooth, own.head_odds, dt) if self.heads else None,
        )
        return weighing, scene.or_given(xp, fit(xp, scene.views, weighing, rough, 2)[0])

    def _find(self, scene: Scene, weighing: Weighing, motion: Motion, rows: Array, own_row: Array) -> Found:
        """Steps 4 and 5: the second weights, the pose, and people's places."""
        xp, views = self.network.operations, scene.views
        again = self._look_again(scene, weighing, motion, rows)
        trust = self.network.linear("trust_again", again)
        offset = weighing.offset + xp.points(trust[..., 2:4]) * (scene.scale * (1.0 - scene.given.placed))
        weights = weighing.weights * xp.exp(xp.clip(trust[..., :2], -6.0, 4.0))
        motion, variances = fit(xp, views, weighing._replace(weights=weights, offset=offset), motion, 2)
        uncertain = xp.log(xp.stack(list(variances)) + 1e-9)
        motion = scene.or_given(xp, motion)
        gains = xp.sigmoid(trust[..., 4:6])
        places, off = view(xp, views, motion)
        moved = places + (offset + xp.points(gains * xp.pairs(off - offset))) * views.ray
        moved = xp.where(scene.placed, places, moved)
        unexpected = xp.where(scene.sights.seen > 0.5, views.seen, places)
        places = xp.where(scene.known > 0.5, moved, unexpected)
        kept = xp.sqrt(places.real**2 + places.imag**2 + 1e-4)
        return Found(motion, places, kept, off, offset, again, own_row, uncertain)

    def _look_again(self, scene: Scene, weighing: Weighing, motion: Motion, rows: Array) -> Array:
        """Hidden features [..., K, `WIDTH`] of people given the first pose; each includes the mean over people."""
        xp, network, known = self.network.operations, self.network, scene.known
        _, off = view(xp, scene.views, motion)
        seen = second_look(xp, scene, off - weighing.offset, weighing.offset)
        again = network.hidden("look_again", xp.join([rows, seen]))
        mean = known[..., None, :] @ again / (scene.count[..., None, None] + 1e-3)
        return network.hidden("together", xp.join([again, mean + 0.0 * again]))
