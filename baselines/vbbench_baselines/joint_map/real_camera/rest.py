"""Whether a vehicle that is taken to stand has set off, which few people alone hardly tell from their changing ways.

In every frame it is tried that it moves. The newest frames alone tell at once, if surely enough. What they tell is soon
taken for people who changed their ways; the whole window remembers longer. A crowd that sets off together looks like a
camera that does for some tenths of a second, but not for a second.
"""

import numpy as np

from vbbench.geometry import BoolArray, FloatArray
from vbbench_baselines.joint_map.real_camera.descent import Settled, copied, settle
from vbbench_baselines.joint_map.real_camera.joint import Model, Point, Seen
from vbbench_baselines.joint_map.real_camera.observer import VEHICLE
from vbbench_baselines.joint_map.real_camera.shares import Shares

MOVING, FEW, ROUNDS = 3, 2, 4
"""For how many newest frames it is tried that it moves, the rounds after which that must be more probable, if only a
little, and most rounds until it is settled."""

SURER_BY, SURE = 40.0, 20.0
"""How much lower the deviance must be then: in the newest frames at once, or in the whole window for `LONG`. Frames are
not as independent as the model takes them to be."""

LONG, MANY = 1.0, 10
"""In s, or so many frames where these are fewer: a window is of frames."""

SUSPECTED, DISMISSED = 8.0, 5.0
"""The window is asked from when the newest frames' deviance is so much lower, until its own is lower by less."""

DOUBTFUL_BY, FADING = 20.0, 4.0
"""From how much lower a deviance on it may as well be so, and in s: a doubt fades to a third."""


class Rest:
    """What has been found so far of whether the vehicle moves.

    Attributes
    ----------
    doubt : [3, 3] what has to be added to the covariance of the newest pose, since it may: by how far it is off then.
    """

    def __init__(self) -> None:
        self.end()

    def end(self) -> None:
        """It moves, or something else tells of where it is."""
        self.doubt: FloatArray = np.zeros((3, 3))
        self._suspected, self._sure = False, 0

    def left_at_once(self, best: Settled, seen: Seen, model: Model) -> Settled:
        """The ``best`` of the newest frames, or where their descent ends if the vehicle moves, if that is surer."""
        if not seems_to_stand(best, seen):
            self.end()
            return best
        tried = _setting_off(best.point, seen, model, FEW)
        if tried.deviance < best.deviance:
            tried = _freed(_setting_off(tried.point, seen, model, ROUNDS), seen, model)
        surer = best.deviance - tried.deviance
        if surer > SURER_BY:
            self.end()
            return tried
        self._suspected |= surer > SUSPECTED
        self.doubt = self.doubt * np.exp(-model.dt / FADING)
        self._doubt(surer, best.point, tried.point)
        return best

    def left_before(self, point: Point, seen: Seen, model: Model) -> Point:
        """The ``point`` of the whole window, or where its descent ends if the vehicle moves, if that is sure by now."""
        if not self._suspected:
            return point
        best = settle(copied(point), seen, model, FEW, len(seen.fixed), False)
        tried = _freed(_setting_off(best.point, seen, model, ROUNDS), seen, model)
        surer = best.deviance - tried.deviance
        self._suspected, self._sure = surer > DISMISSED, self._sure + 1 if surer > SURE else 0
        if self._sure >= MANY or self._sure * model.dt >= LONG:
            self.end()
            return tried.point
        self._doubt(surer, best.point, tried.point)
        return point

    def _doubt(self, surer: float, stands: Point, moves: Point) -> None:
        """Doubt that it stands: towards where it is otherwise, the variance is at least by how far that is off."""
        apart = moves.frames[-1, :3] - stands.frames[-1, :3]
        far = min(max(surer / DOUBTFUL_BY, 0.0), 1.0) * (apart @ apart)
        if far > 0.0:
            along = apart / np.linalg.norm(apart)
            self.doubt = self.doubt + max(far - along @ self.doubt @ along, 0.0) * np.outer(along, along)


def seems_to_stand(settled: Settled, seen: Seen) -> bool:
    """Whether a vehicle probably stands during the newest step, of which boxes alone tell."""
    told = seen.fixed[-1] or seen.blind[-1] or not seen.free[-1]
    return not told and bool(standing(settled.shares)[-1])


def standing(shares: Shares) -> BoolArray:
    """[T] whether a vehicle probably stands during the step into a frame, whatever else tells of it."""
    return np.asarray(np.minimum(shares.standing, shares.laws[VEHICLE]) > 0.5)


def _setting_off(point: Point, seen: Seen, model: Model, rounds: int) -> Settled:
    """Where so many ``rounds`` lead if the vehicle moves in the newest frames."""
    moving = model._replace(observer=model.observer._replace(going=MOVING))
    return settle(copied(point), seen, moving, rounds, len(seen.fixed), False)


def _freed(moved: Settled, seen: Seen, model: Model) -> Settled:
    """Where it goes from there if nothing is taken for granted any more."""
    return settle(copied(moved.point), seen, model, ROUNDS, len(seen.fixed), False)
