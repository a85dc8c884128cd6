"""One sequence to show: what was observed, where people really are, and what solvers answer.

Plots show one frame of a `Replay`, films and recordings for the viewer all of them.
"""

from collections.abc import Sequence as Several
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from vbbench.boxes import rectangles
from vbbench.camera import Camera
from vbbench.errors import VbbenchError
from vbbench.estimate import Estimate
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import DatasetInfo
from vbbench.files.submission_tables import SubmittedEstimates, unique_names
from vbbench.generation.footage import FOOTAGE
from vbbench.geometry import BoolArray, FloatArray, relative_to_world
from vbbench.protocol import Protocol, get_protocol, scored_frames, scored_positions
from vbbench.scoring.metrics import METRICS, frame_errors
from vbbench.sequence import Given, Sequence, Truth


@dataclass(frozen=True, kw_only=True)
class Answer:
    """A solver's answer.

    Parameters
    ----------
    name : its name in the picture, unique in a replay.
    solver : the name of its solver.
    protocol : the protocol that it was solved under.
    estimate : its poses and positions, and those given; NaN = no answer.
    given : what its protocol gives.
    truth : what it is compared with, NaN where nothing is known; where people's places are known from the camera only,
        they lie around its own poses.
    errors : [T] of scored frames by metric, NaN elsewhere; only metrics of which the truth is known.
    """

    name: str
    solver: str
    protocol: Protocol
    estimate: Estimate
    given: Given
    truth: Truth | None
    errors: dict[str, FloatArray]

    @property
    def title(self) -> str:
        """Name and protocol."""
        return f"{self.name} ({self.protocol.name})"

    def figures(self, frame: int) -> list[str]:
        """The errors of a frame as texts; none if it is not scored."""
        return [
            f"{METRICS[key].symbol} = {values[frame]:.3f} {METRICS[key].unit}"
            for key, values in self.errors.items()
            if np.isfinite(values[frame])
        ]


@dataclass(frozen=True, kw_only=True)
class Replay:
    """What is shown of a sequence.

    Parameters
    ----------
    dataset, sequence : what it is of.
    truth : what is known of the truth, NaN elsewhere; places known from the camera only lie around the poses of the
        first answer, or of a camera that stays at the origin. ``None`` where it is withheld, or was never measured.
    answers : of solvers.
    """

    dataset: Dataset
    sequence: Sequence
    truth: Truth | None
    answers: tuple[Answer, ...] = ()

    def with_answer(self, solver: str, protocol: str, estimate: Estimate, name: str = "") -> "Replay":
        """The same with one answer more, with its errors if the truth is available; ``name``, if not the solver's.

        Raises VbbenchError if there is no such protocol, or the estimate has another shape than the sequence.
        """
        sequence, rules = self.sequence, get_protocol(protocol)
        found, wanted = list(estimate.positions.shape), [*sequence.observed.shape, 2]
        if found != wanted:
            raise VbbenchError(f"the estimate has positions {found}, sequence {sequence.index} has {wanted}")
        given = rules.select_given(sequence.given)
        truth = _known_truth(self.dataset, sequence, estimate.poses)
        errors: dict[str, FloatArray] = {}
        if truth is not None:
            counted = scored_positions(sequence.observed, given)
            poses = estimate.poses if self.info.truth == "relative" else truth.poses
            every = frame_errors(estimate.poses, estimate.positions, poses, truth.positions, counted)
            scored = scored_frames(sequence.observed)
            errors = {
                key: np.where(scored, values, np.nan)
                for key, values in every.items()
                if self.info.truth in METRICS[key].known
            }
        answer = Answer(
            name=name or solver,
            solver=solver,
            protocol=rules,
            estimate=estimate,
            given=given,
            truth=truth,
            errors=errors,
        )
        return replace(self, truth=truth if self.answer is None else self.truth, answers=(*self.answers, answer))

    @property
    def info(self) -> DatasetInfo:
        """The facts of the dataset."""
        return self.dataset.info

    @property
    def camera(self) -> Camera:
        """The observer's camera."""
        return self.dataset.camera(self.sequence)

    @property
    def answer(self) -> Answer | None:
        """The answer that pictures of one answer show: the first."""
        return self.answers[0] if self.answers else None

    @property
    def given(self) -> Given:
        """What the first answer was given, without frames revealed one by one; without answers as in `sequential`."""
        return self.answers[0].given if self.answers else self.sequence.given

    @property
    def known(self) -> Truth | Given:
        """Poses and positions to draw as the real ones: truth if it is available, else what is given."""
        return self.given if self.truth is None else self.truth

    @cached_property
    def viewpoints(self) -> FloatArray:
        """[T, 3] where the camera is drawn that sees: its true pose, else the first answer's, else NaN.

        Where people's places are known from the camera only, and nothing is answered, it stays at the origin.
        """
        poses = self.known.poses
        if self.answer is not None:
            poses = np.where(np.isnan(poses), self.answer.estimate.poses, poses)
        elif self.truth is not None and self.info.truth == "relative":
            poses = np.zeros_like(poses)
        return poses

    @property
    def poses_known(self) -> bool:
        """Whether the observer's true poses are known."""
        return self.truth is not None and self.info.truth != "relative"

    @property
    def places_known(self) -> bool:
        """Whether people's true places are known, if only from the camera."""
        return self.truth is not None and self.info.truth != "poses"

    @property
    def is_footage(self) -> bool:
        """Whether a real camera saw it."""
        return self.info.tier == FOOTAGE

    @property
    def caveat(self) -> str:
        """What is not known of the truth, for readers of a picture; empty if everything is."""
        if self.truth is None:
            return "no truth was ever measured" if self.info.truth == "none" else "no truth available"
        if self.info.truth == "poses":
            return "where people really are is not known"
        if self.info.truth == "relative":
            return f"true places as seen from the {'camera' if self.answer is None else 'estimated camera'}"
        return ""

    @property
    def title(self) -> str:
        """Split and sequence, and the recording of footage."""
        named = self.is_footage and self.sequence.scene < len(self.info.scenes)
        recording = [self.info.scenes[self.sequence.scene]] if named else []
        return "  ·  ".join([self.info.split, *recording, f"sequence {self.sequence.index}"])

    def heading(self, *more: str) -> str:
        """The first line of a picture: `title`, what ``more`` is to be said, the kind of camera, and the tier."""
        info = self.info
        tier = info.tier if info.pixel_std == 0 else f"{info.tier} (σ = {info.pixel_std:g} px)"
        return "  ·  ".join([self.title, *more, self.camera.kind, tier])

    @property
    def cautions(self) -> list[str]:
        """What a reader of a picture must know of its data."""
        return [f"Caution: {self.info.caution}"] if self.info.caution else []

    @property
    def bearings(self) -> dict[str, float]:
        """Columns in px that look behind, left, ahead and right, in a picture that closes on itself; else none."""
        if self.camera.period is None:
            return {}
        azimuth = np.radians([-180.0, -90.0, 0.0, 90.0])
        level = np.stack([np.sin(azimuth), np.zeros(4), np.cos(azimuth)], axis=-1)
        columns = self.camera.pixels(self.camera.to_camera(level))[:, 0].round(6).tolist()
        return dict(zip(("behind", "left 90°", "ahead", "right 90°"), columns, strict=True))

    @cached_property
    def window(self) -> tuple[float, float, float, float]:
        """Left, top, right and bottom in px: the picture, and the boxes whose middles lie beyond its borders.

        Boxes without a lens's distortion lie farther out than the lens showed them. A panorama has no such box.
        """
        size = np.array(self.camera.picture_size, np.float64)
        if self.camera.period is not None:
            return 0.0, 0.0, *size.tolist()
        observations = self.sequence.observations[self.sequence.observed]
        middles, boxes = observations[:, :2], rectangles(observations)
        low = np.min(boxes[:, :2], axis=0, where=middles < 0.0, initial=0.0)
        high = np.max(boxes[:, :2] + boxes[:, 2:] - size, axis=0, where=middles > size, initial=0.0)
        return *low.tolist(), *(size + high).tolist()

    @cached_property
    def distances(self) -> FloatArray:
        """[T, K] distance in m by the box, for a person of mean height."""
        boxes = self.sequence.observations
        return self.camera.depth(self.camera.unproject(boxes, np.full(boxes.shape[:-1], self.info.height_mean)))

    @cached_property
    def estimated(self) -> FloatArray:
        """[T, K, 2] positions in m of the observed people in the first answer, NaN elsewhere."""
        if self.answer is None:
            return np.full((*self.sequence.observed.shape, 2), np.nan)
        return np.where(self.sequence.observed[..., None], self.answer.estimate.positions, np.nan)

    @cached_property
    def false_alarms(self) -> BoolArray:
        """[T, K] which boxes are known to show nobody; in footage, nobody whose true place is known."""
        if self.truth is None or not self.places_known:
            return np.zeros(self.sequence.observed.shape, np.bool_)
        placed = ~np.isnan(self.viewpoints[:, :1])
        return np.asarray(self.sequence.observed & placed & np.isnan(self.truth.positions[..., 0]))

    @cached_property
    def bystanders(self) -> tuple[FloatArray, FloatArray]:
        """People of the scene without a box: positions [T, N, 2] in m, NaN while seen or absent, and heights [N] in m.

        Nobody where people's places are not known.
        """
        sequence = self.sequence
        if not self.places_known:
            return np.empty((sequence.frames, 0, 2)), np.empty(0)
        people, places, heights = self.dataset.surroundings(sequence)
        frame, track = np.nonzero(sequence.observed)
        seen = self.dataset.track_persons(sequence)[frame, track]
        column = np.searchsorted(people, seen).clip(max=len(people) - 1)
        real = people[column] == seen
        places[frame[real], column[real]] = np.nan
        places[:, people == sequence.observer] = np.nan
        ever = np.isfinite(places[..., 0]).any(axis=0)
        if self.info.truth == "relative":
            places = relative_to_world(places, self.viewpoints)
        return places[:, ever], np.where(np.isfinite(heights), heights, self.info.height_mean)[ever]

    def headline(self, frame: int) -> str:
        """What is drawn, and the errors of the first answer in this frame alone."""
        caveat = [self.caveat] if self.caveat else []
        if self.answer is None:
            return "truth" if not caveat else self.caveat + (": what is given" if self.truth is None else "")
        figures = self.answer.figures(frame)
        if figures:
            figures = [f"in this frame {figures[0]}", *figures[1:]]
        elif np.isfinite(self.given.poses[frame]).all():
            figures = ["given"]
        return ",  ".join([self.answer.title, *figures, *caveat])


def _known_truth(dataset: Dataset, sequence: Sequence, around: FloatArray | None = None) -> Truth | None:
    """What is known of a sequence's truth; ``around`` are poses [T, 3] of the camera from which people were measured.

    Without them it stays at the origin.
    """
    if not dataset.has_truth:
        return None
    if dataset.info.truth != "relative":
        return dataset.truth(sequence)
    places = dataset.relative_truth(sequence)
    camera = np.zeros((sequence.frames, 3)) if around is None else around
    return Truth(
        poses=np.full((sequence.frames, 3), np.nan),
        positions=relative_to_world(places, camera),
        heights=np.full(len(sequence.tracks), np.nan),
    )


def load_replay(dataset: Dataset, index: int, submissions: Several[Path | str] = ()) -> Replay:
    """Read a sequence, and the answers of submissions to it.

    Raises VbbenchError if there is no such sequence, or a submission cannot be read or answers another dataset.
    """
    sequence = dataset.sequence(index)
    opened = [SubmittedEstimates(dataset, folder) for folder in submissions]
    names = unique_names([one.info for one in opened], submissions)
    replay = Replay(dataset=dataset, sequence=sequence, truth=_known_truth(dataset, sequence))
    for name, one in zip(names, opened, strict=True):
        replay = replay.with_answer(one.info.solver, one.info.protocol, one.of(sequence), name)
    return replay
