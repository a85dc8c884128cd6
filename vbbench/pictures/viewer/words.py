"""The texts of a recording: facts about the dataset and the submissions, and a line for each frame."""

import numpy as np

from vbbench.files.dataset_info import describe
from vbbench.pictures.replay import Answer, Replay
from vbbench.pictures.viewer.marks import Tape
from vbbench.scoring.metrics import METRICS
from vbbench.sequence import Given

FACTS, NOW = "facts", "now"

_READING = """\
**How to read it.** Solid bodies are people at their true places, each in its own colour; grey wire frames are people
without a box. Wire frames in a submission's colour are its estimates, red lines join the two, blue rings are given
positions. The map shows world (x, y) at (x, −y), since rows count downwards there. Only heights are known: widths of
bodies and boxes are made up."""


def record_words(tape: Tape, replay: Replay) -> None:
    """Record the facts, and the text of every frame."""
    rr = tape.rr
    tape.always(FACTS, rr.TextDocument(_facts(replay), media_type=rr.MediaType.MARKDOWN))
    texts = [_frame_text(replay, frame) for frame in range(replay.sequence.frames)]
    media = [str(rr.MediaType.MARKDOWN)] * len(texts)
    tape.each(NOW, rr.TextDocument, text=texts, media_type=media)


def _facts(replay: Replay) -> str:
    info, sequence = replay.info, replay.sequence
    heading, *lines = describe(info).splitlines()
    lines = [line.strip() for line in lines if not line.strip().startswith("caution: ")]
    parts = [
        f"**{heading}**",
        f"**Sequence {sequence.index}**: {sequence.frames} frames, {len(sequence.tracks)} tracks, "
        f"{_recorded_by(replay)}" + (f"; **{replay.caveat}**." if replay.caveat else "."),
        *([f"> **Caution:** {info.caution}"] if info.caution else []),
        "\n".join(f"* {line}" for line in lines),
        *(_answer_text(answer) for answer in replay.answers),
        _READING,
    ]
    return "\n\n".join(parts) + "\n"


def _recorded_by(replay: Replay) -> str:
    sequence = replay.sequence
    if replay.is_footage and sequence.scene < len(replay.info.scenes):
        return f"of recording {replay.info.scenes[sequence.scene]} from its frame {sequence.first_frame}"
    return f"observer {sequence.observer} in scene {sequence.scene}"


def _answer_text(answer: Answer) -> str:
    known = {key: values for key, values in answer.errors.items() if np.isfinite(values).any()}
    means = [f"{METRICS[key].symbol} {np.nanmean(values):.3f} {METRICS[key].unit}" for key, values in known.items()]
    figures = f" Means over the frames scored: {', '.join(means)}." if means else ""
    return f"**{answer.name}** ({answer.protocol.id}).{figures} {' '.join(answer.protocol.text.split())}"


def _frame_text(replay: Replay, frame: int) -> str:
    seen, seconds = int(replay.sequence.observed[frame].sum()), frame * replay.info.dt
    lines = [f"**Frame {frame}** of 0–{replay.sequence.frames - 1}, {seconds:.2f} s, {seen} people seen"]
    if not replay.answers:
        return "\n\n".join([*lines, f"Given (sequential): {_given_words(replay.given, frame)}"])
    answers = [
        ", ".join([f"* **{one.name}**: given {_given_words(one.given, frame)}", *one.figures(frame)])
        for one in replay.answers
    ]
    return "\n\n".join([*lines, "\n".join(answers)])


def _given_words(given: Given, frame: int) -> str:
    people = int(np.isfinite(given.positions[frame, :, 0]).sum())
    pose = ["the pose"] if np.isfinite(given.poses[frame, 0]) else []
    return " and ".join([*pose, *([f"{people} positions"] if people else [])]) or "nothing"
