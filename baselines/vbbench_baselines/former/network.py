"""One frame through the network: what walks did, what is expected, who is believed, the pose, and what is remembered.

People are seen from the last pose and told apart by nothing but what they do: the answer does not depend on their order,
or on where the world begins. In turn,

1. each walk's velocity takes in a share of what the last frame showed that was not expected,
2. everybody is expected to walk on, and a plain robust fit of the pose tells roughly how the camera moved,
3. people and observer look at one another (attention), and tell where else they expect each, and how far they trust it,
4. the pose is fitted with these weights, looked at again, and fitted again,
5. people are moved a share of the way to where their boxes show them, and memories take in what was left over.
"""

from dataclasses import dataclass
from typing import NamedTuple

from vbbench_baselines.former.layers import Network
from vbbench_baselines.former.operations import Array
from vbbench_baselines.former.pose_fit import Motion, Views, Weighing, fit, view
from vbbench_baselines.former.sights import HIGHEST, LOWEST, Sights, without_feet
from vbbench_baselines.former.state import TRACES, Observer, State, Walkers

STRIDE, WALK, EXACT = 0.4, 0.15, 0.01
"""In m/s, what an error is measured by, and how far people stray from a straight walk; in m, how far those given do."""
OWN_WALK, OWN_TURN = 0.3, 1.5
"""In m/s and rad/s: how far the observer strays."""
FAR = 1e4
"""As good as infinite, for a logarithm."""


class Told(NamedTuple):
    """What is given of a frame, from the last pose.

    Attributes
    ----------
    places, placed : where people are, [..., K] in m (complex), and 1 where that is given.
    motion, moved : the observer's, and 1 [...] where it is.
    """

    places: Array
    placed: Array
    motion: Motion
    moved: Array


class Answer(NamedTuple):
    """What the network says of a frame.

    Attributes
    ----------
    motion : of the observer since the last pose; ``rough`` before the network looked.
    places : of people from the new pose, [..., K] in m, complex.
    pose_spread : [..., 3] ln of the standard deviation of the pose ahead, to the left and in yaw, since all was given.
    place_spread : [..., K, 2] the same of people's places in the world, along and across their rays.
    """

    motion: Motion
    rough: Motion
    places: Array
    pose_spread: Array
    place_spread: Array


class _Walks(NamedTuple):
    """Step 1: velocities and traces, and the observer's with the turn rate; ``surprise`` is what was not expected."""

    velocity: Array
    traces: Array
    offsets: Array
    own: Observer
    surprise: Array
    begins: Array
    own_begins: Array


@dataclass(frozen=True)
class Birdifier:
    """The network with its options.

    Parameters
    ----------
    network : its layers.
    pure : whether the pose is told by the network, and not fitted.
    feet : whether it may see where feet stand.
    """

    network: Network
    pure: bool = False
    feet: bool = True

    def advance(self, state: State, sights: Sights, told: Told, dt: Array, spread: Array) -> tuple[State, Answer]:
        """The state after a frame of ``dt`` [...] s, and the answer; ``spread`` [...] of heights as a share of the mean."""
        xp = self.network.operations
        sights = sights if self.feet else without_feet(xp, sights)
        walks = self._walks(state, dt)
        people, own = state.people._replace(offsets=walks.offsets), walks.own
        given = told.placed > 0.5
        known = xp.where((people.seen > 0.5) | given, sights.seen, 0.0 * sights.seen)
        distance, distance_std = self._distance(people, sights, spread)
        views = Views(
            expected=xp.where(given, told.places, people.place + walks.velocity * dt[..., None]),
            seen=sights.ray * xp.exp(distance),
            ray=sights.ray,
        )
        box_along, box_across = distance_std * xp.exp(distance), sights.noise[..., 0] * xp.exp(distance)
        stray = (WALK * dt + EXACT)[..., None] ** 2
        stray = xp.where(given, EXACT**2 + 0.0 * distance, stray + 0.0 * distance)
        along, across = box_along**2 + stray, box_across**2 + stray
        expected = Motion(own.velocity * dt, own.turn_rate * dt)
        walk, turn = (OWN_WALK * dt + 0.01) ** -2.0, (OWN_TURN * dt + 0.05) ** -2.0
        inertia = xp.stack([walk, walk, turn])
        plain = Weighing(known / along, known / across, 0.0 * views.ray, inertia, expected)
        rough, _ = fit(xp, views, plain, expected, 2)
        _, off = view(xp, views, rough)
        doubtful = 1.0 + 0.25 * (off.real**2 / along + off.imag**2 / across)
        plain = plain._replace(along=plain.along / doubtful, across=plain.across / doubtful)
        rough, _ = fit(xp, views, plain, rough, 1)
        rough = self._given(rough, told)

        scale = (STRIDE * dt)[..., None]
        _, off = view(xp, views, rough)
        _, off_expected = view(xp, views, expected)
        there = known[..., None]
        std_along, std_across = xp.sqrt(along), xp.sqrt(across)
        turned = xp.direction(-rough.turn)
        vectors = walks.velocity * turned[..., None] * views.ray.conj()
        own_vector = (own.velocity * turned)[..., None] * views.ray.conj()
        traces = walks.traces * turned[..., None, None] * views.ray.conj()[..., None]
        facts = xp.join(
            [
                xp.stack(
                    [
                        known * xp.asinh(off.real / scale),
                        known * xp.asinh(off.imag / scale),
                        known * 0.5 * xp.asinh(off_expected.real / scale),
                        known * 0.5 * xp.asinh(off_expected.imag / scale),
                        known * xp.asinh(off.real / std_along),
                        known * xp.asinh(off.imag / std_across),
                        known * xp.clip(off.real, -3.0, 3.0),
                        known * xp.clip(off.imag, -3.0, 3.0),
                        *_parts(vectors),
                        *_parts(own_vector),
                    ]
                ),
                self._interleaved(traces),
                xp.stack([*_parts(views.ray), known, told.placed]),
                self._person_facts(people, sights, walks, distance, distance_std, dt, spread),
                sights.cut,
                xp.stack([xp.log(std_along + 1e-3), xp.log(std_across + 1e-3)]),
                people.memory,
            ]
        )
        rows = self.network.perceptron("person", facts)
        count = known.sum(-1)
        own_row = self.network.perceptron(
            "observer", self._observer_facts(walks, rough, expected, count, sights, dt, spread)
        )
        hidden = xp.join([(sights.seen - 1.0) * FAR, 0.0 * dt[..., None]])
        rows = self.network.attend(xp.append_row(rows, own_row), hidden)
        rows, own_row = rows[..., :-1, :], rows[..., -1, :]

        trust, own_trust = self.network.linear("trust", rows), self.network.linear("own_trust", own_row)
        free = 1.0 - told.placed
        weights = xp.exp(xp.clip(trust[..., 2:4], -6.0, 5.0))
        weighing = Weighing(
            along=known / along * weights[..., 0],
            across=known / across * weights[..., 1],
            offset=xp.point(trust[..., 0], trust[..., 1]) * (scale * free),
            inertia=inertia * xp.exp(xp.clip(own_trust[..., 3:6], -6.0, 6.0)),
            motion=Motion(
                expected.step + xp.point(own_trust[..., 0], own_trust[..., 1]) * (0.3 * dt),
                expected.turn + own_trust[..., 2] * (0.5 * dt),
            ),
        )
        if self.pure:
            said = weighing.motion
            motion = Motion(
                said.step + xp.point(own_trust[..., 6], own_trust[..., 7]) * dt, said.turn + own_trust[..., 8] * dt
            )
        else:
            motion, _ = fit(xp, views, weighing, rough, 2)
        motion = self._given(motion, told)

        _, off = view(xp, views, motion)
        off = off - weighing.offset
        seen_again = xp.stack(
            [
                known * xp.asinh(off.real / scale),
                known * xp.asinh(off.imag / scale),
                known * xp.asinh(off.real / std_along),
                known * xp.asinh(off.imag / std_across),
                known * xp.asinh(weighing.offset.real / scale),
                known * xp.asinh(weighing.offset.imag / scale),
                known * xp.clip(off.real, -3.0, 3.0),
                known * xp.clip(off.imag, -3.0, 3.0),
            ]
        )
        again = self.network.hidden("look_again", xp.join([rows, seen_again]))
        mean = (again * there).sum(-2) / (count[..., None] + 1e-3)
        again = self.network.hidden("together", xp.join([again, mean[..., None, :] + 0.0 * again]))
        trust = self.network.linear("trust_again", again)
        offset = weighing.offset + xp.point(trust[..., 2], trust[..., 3]) * (scale * free)
        uncertain = 0.0 * inertia
        if not self.pure:
            weights = xp.exp(xp.clip(trust[..., :2], -6.0, 4.0))
            weighing = weighing._replace(
                along=weighing.along * weights[..., 0], across=weighing.across * weights[..., 1], offset=offset
            )
            motion, variances = fit(xp, views, weighing, motion, 2)
            uncertain = xp.stack([xp.log(variance + 1e-9) for variance in variances])
        motion = self._given(motion, told)

        places, off = view(xp, views, motion)
        gains = xp.sigmoid(trust[..., 4:6])
        left = off - offset
        moved = places + (offset + xp.point(gains[..., 0] * left.real, gains[..., 1] * left.imag)) * views.ray
        new = xp.where(given, places, moved)
        new = xp.where(known > 0.5, new, xp.where(sights.seen > 0.5, views.seen, places))

        kept = xp.sqrt(new.real**2 + new.imag**2 + 1e-4)
        surprise = xp.stack(
            [
                known * xp.asinh(off.real / scale),
                known * xp.asinh(off.imag / scale),
                known * xp.asinh(offset.real / scale),
                known * xp.asinh(offset.imag / scale),
            ]
        )
        memory = self.network.remember("memory", xp.join([again, surprise]), people.memory)
        memory = xp.where(sights.seen[..., None] > 0.5, memory, people.memory)
        pace, turning = motion.step / dt, motion.turn / dt
        beyond = (motion.step - expected.step) / dt
        change = xp.stack(
            [
                xp.asinh(3.0 * beyond.real),
                xp.asinh(3.0 * beyond.imag),
                xp.asinh(3.0 * (motion.turn - expected.turn) / dt),
                *_parts(pace),
                turning,
            ]
        )
        own_memory = self.network.remember("own_memory", xp.join([own_row, change]), own.memory)
        thought = self.network.hidden("doubt", xp.detach(xp.join([own_row, own_memory])))
        crowd = xp.log(1.0 + count)[..., None]
        doubt = self.network.remember("doubts", xp.join([thought, xp.detach(uncertain) * 0.2, crowd]), own.doubt)
        spreads = xp.join(
            [
                xp.detach(again),
                doubt[..., None, :] + 0.0 * again[..., : doubt.shape[-1]],
                xp.log(xp.stack([box_along, box_across]) + 1e-3),
                xp.stack([told.placed, xp.detach(xp.log(kept))]),
            ]
        )
        answer = Answer(
            motion=motion,
            rough=rough,
            places=new,
            pose_spread=self.network.linear("pose_spread", doubt),
            place_spread=self.network.perceptron("place_spread", spreads),
        )
        back = xp.direction(-motion.turn)
        after = State(
            Walkers(
                place=new,
                place_before=(people.place - motion.step[..., None]) * back[..., None],
                velocity=walks.velocity * back[..., None],
                traces=walks.traces * back[..., None, None],
                memory=memory,
                offsets=people.offsets,
                seen=people.seen + sights.seen,
                away=(people.away + dt[..., None]) * (1.0 - sights.seen),
                shown=sights.seen,
                traceable=xp.where(people.seen > 0.5, 1.0 + 0.0 * kept, 0.0 * kept),
                exact=told.placed * sights.seen,
                exact_before=people.exact,
                by_height=sights.by_height,
                by_feet=sights.by_feet,
                has_feet=sights.has_feet,
            ),
            Observer(
                step=pace * back,
                turn=turning,
                velocity=own.velocity * back,
                turn_rate=own.turn_rate,
                traces=own.traces * back[..., None],
                memory=own_memory,
                doubt=doubt,
                moved=xp.where(own.frames > 0.5, 1.0 + 0.0 * dt, 0.0 * dt),
                told=told.moved + 0.0 * dt,
                frames=own.frames + 1.0,
            ),
        )
        return after, answer

    def _walks(self, state: State, dt: Array) -> _Walks:
        """Step 1."""
        xp, people, own = self.network.operations, state.people, state.observer
        kept = xp.sqrt(people.place.real**2 + people.place.imag**2 + 1e-4)
        toward = people.place / kept
        fresh = people.shown * people.traceable
        strange = (people.place - people.place_before) / dt[..., None] - people.velocity
        off, pace = strange * toward.conj(), people.velocity * toward.conj()
        begins = xp.where(people.seen < 2.5, fresh, 0.0 * fresh)
        told = xp.stack([people.by_height, people.by_feet])
        farther = xp.clip(xp.log(kept)[..., None] - told, -0.5, 0.5) - people.offsets
        farther = farther * xp.stack([people.shown, people.shown * people.has_feet])
        facts = [
            *(xp.asinh(2.0 * part) for part in _parts(off)),
            *_parts(pace),
            *(0.3 * part for part in _parts(off)),
            5.0 * farther[..., 0],
            5.0 * farther[..., 1],
            begins,
            people.exact,
            people.exact_before,
            xp.log(1.0 + people.seen),
            xp.log(kept),
            xp.log(dt)[..., None] + 0.0 * kept,
        ]
        told = self.network.perceptron("walk", xp.join([xp.stack(facts), people.memory]))
        taken = fresh[..., None]
        gains = xp.sigmoid(told[..., :2] + (4.0 * begins)[..., None]) * taken
        offsets = people.offsets + xp.sigmoid(told[..., 2:4]) * farther
        velocity = people.velocity + xp.point(gains[..., 0] * off.real, gains[..., 1] * off.imag) * toward
        keep = 1.0 - taken * (1.0 - xp.sigmoid(told[..., 4 : 4 + TRACES]))
        add = xp.tanh(told[..., 4 + TRACES :]) * taken * (1.0 - begins)[..., None]
        traces = people.traces * keep + add * strange[..., None]

        own_strange, own_turned = own.step - own.velocity, own.turn - own.turn_rate
        own_begins = xp.where(own.frames < 2.5, 1.0 + 0.0 * dt, 0.0 * dt)
        surprise = xp.stack([xp.asinh(2.0 * part) for part in (*_parts(own_strange), own_turned)])
        others = xp.stack([*_parts(own.velocity), own.turn_rate, own_begins, own.told, xp.log(dt)])
        told = self.network.perceptron("own_walk", xp.join([surprise, others, own.memory]))
        gains = xp.sigmoid(told[..., :3] + 4.0 * own_begins[..., None]) * own.moved[..., None]
        keep = 1.0 - own.moved[..., None] * (1.0 - xp.sigmoid(told[..., 3 : 3 + TRACES]))
        add = xp.tanh(told[..., 3 + TRACES :]) * (own.moved * (1.0 - own_begins))[..., None]
        own = own._replace(
            velocity=own.velocity + xp.point(gains[..., 0] * own_strange.real, gains[..., 1] * own_strange.imag),
            turn_rate=own.turn_rate + gains[..., 2] * own_turned,
            traces=own.traces * keep + add * own_strange[..., None],
        )
        return _Walks(velocity, traces, offsets, own, surprise, begins, own_begins)

    def _distance(self, people: Walkers, sights: Sights, spread: Array) -> tuple[Array, Array]:
        """ln of the distance [..., K] in m by height and feet together, and its standard deviation."""
        xp = self.network.operations
        stature = spread[..., None] * (1.0 + people.seen) ** -0.5
        by_height = 1.0 / (sights.noise[..., 1] ** 2 + stature**2 + 1e-5)
        by_feet = sights.has_feet / (sights.noise[..., 2] ** 2 + 1e-5)
        measured = by_height * (sights.by_height + people.offsets[..., 0])
        measured = measured + by_feet * (sights.by_feet + people.offsets[..., 1])
        total = by_height + by_feet
        return xp.clip(measured / total, LOWEST, HIGHEST), total**-0.5

    def _person_facts(
        self, people: Walkers, sights: Sights, walks: _Walks, distance: Array, std: Array, dt: Array, spread: Array
    ) -> Array:
        """What the network is told of people besides where they are seen: [..., K, 16]."""
        xp, none = self.network.operations, 0.0 * distance
        by_height, by_feet = people.offsets[..., 0], people.offsets[..., 1]
        apart = xp.clip(sights.by_feet + by_feet - sights.by_height - by_height, -1.0, 1.0) * sights.has_feet
        return xp.stack(
            [
                xp.log(1.0 + people.seen),
                xp.log(1.0 + people.away),
                walks.begins,
                people.exact,
                people.exact_before,
                distance,
                xp.log(sights.noise[..., 0] + 1e-4),
                xp.log(sights.noise[..., 1] + 1e-4),
                xp.log(sights.noise[..., 2] + 1e-4),
                xp.log(std + 1e-3),
                5.0 * apart,
                5.0 * by_height,
                5.0 * by_feet,
                sights.has_feet,
                xp.log(dt)[..., None] + none,
                10.0 * spread[..., None] + none,
            ]
        )

    def _observer_facts(
        self, walks: _Walks, rough: Motion, expected: Motion, count: Array, sights: Sights, dt: Array, spread: Array
    ) -> Array:
        """What the network is told of the observer: [..., `OBSERVER_FACTS`] and the memory."""
        xp, own = self.network.operations, walks.own
        beyond, turned = (rough.step - expected.step) / dt, (rough.turn - expected.turn) / dt
        motion = [*_parts(beyond), turned]
        return xp.join(
            [
                xp.stack([*_parts(own.velocity), own.turn_rate]),
                walks.surprise,
                xp.stack([*motion, *(xp.asinh(3.0 * part) for part in motion)]),
                self._interleaved(own.traces),
                xp.stack(
                    [
                        xp.log(1.0 + count),
                        xp.log(dt),
                        own.told,
                        walks.own_begins,
                        xp.log(1.0 + own.frames),
                        10.0 * spread,
                        0.05 * sights.seen.sum(-1),
                        xp.where(count < 1.5, 1.0 + 0.0 * dt, 0.0 * dt),
                        xp.where(count < 2.5, 1.0 + 0.0 * dt, 0.0 * dt),
                    ]
                ),
                own.memory,
            ]
        )

    def _given(self, motion: Motion, told: Told) -> Motion:
        """The motion, or the one that is given."""
        where, given = self.network.operations.where, told.moved > 0.5
        return Motion(where(given, told.motion.step, motion.step), where(given, told.motion.turn, motion.turn))

    def _interleaved(self, points: Array) -> Array:
        """Complex [..., N] as [..., 2N], each one's parts side by side."""
        pairs = self.network.operations.stack([points.real, points.imag])
        return pairs.reshape((*points.shape[:-1], 2 * points.shape[-1]))


def _parts(points: Array) -> tuple[Array, Array]:
    return points.real, points.imag
