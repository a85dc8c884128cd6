"""The words of a recording: facts about the dataset and the submissions, and a line for each frame."""

import numpy as np

from vbbench.files.dataset_info import describe
from vbbench.pictures.viewer.take import Answer, Take
from vbbench.pictures.viewer.tape import Tape
from vbbench.protocol import get_protocol
from vbbench.scoring.metrics import METRICS

FACTS, NOW = "facts", "now"

_READING = """\
**How to read it.** Solid bodies are people where they are, in the colour of their id; grey wire frames are people who
are there without a box. Wire frames in a submission's colour are where it says that they are, red lines join the two,
blue rings are given positions. The map shows world (x, y) at (x, −y), since rows count downwards there. Only heights
are known: widths of bodies and boxes are made up."""


def record_words(tape: Tape, take: Take) -> None:
    """Record the facts, and the words of every frame."""
    rr = tape.rr
    tape.always(FACTS, rr.TextDocument(_facts(take), media_type=rr.MediaType.MARKDOWN))
    texts = [_frame_text(take, frame) for frame in range(take.sequence.frames)]
    media = [str(rr.MediaType.MARKDOWN)] * len(texts)
    tape.each(NOW, rr.TextDocument, text=texts, media_type=media)


def _facts(take: Take) -> str:
    info, sequence = take.dataset.info, take.sequence
    heading, *lines = describe(info).splitlines()
    lines = [line.strip() for line in lines if not line.strip().startswith("caution: ")]
    parts = [
        f"**{heading}**",
        f"**Sequence {sequence.index}**: {sequence.frames} frames, {len(sequence.tracks)} tracks, "
        f"observer {sequence.observer} in scene {sequence.scene}"
        + ("." if take.truth is not None else "; **truth is withheld**."),
        *([f"> **Caution:** {info.caution}"] if info.caution else []),
        "\n".join(f"* {line}" for line in lines),
        *(_answer_text(answer) for answer in take.estimates),
        _READING,
    ]
    return "\n\n".join(parts) + "\n"


def _answer_text(answer: Answer) -> str:
    protocol = get_protocol(answer.info.protocol)
    means = [_figure(key, np.nanmean(values)) for key, values in _known(answer).items()]
    figures = f" Means over the frames scored: {', '.join(means)}." if means else ""
    return f"**{answer.name}** ({protocol.id}).{figures} {' '.join(protocol.text.split())}"


def _known(answer: Answer) -> dict[str, np.ndarray]:
    return {key: values for key, values in answer.errors.items() if np.isfinite(values).any()}


def _frame_text(take: Take, frame: int) -> str:
    seen, seconds = int(take.sequence.observed[frame].sum()), frame * take.dataset.info.dt
    lines = [f"**Frame {frame}** of 0–{take.sequence.frames - 1}, {seconds:.2f} s, {seen} people seen"]
    if not take.estimates:
        given = int(np.isfinite(take.sequence.given.positions[frame, :, 0]).sum())
        lines.append(f"Given (sequential): {_given_words(np.isfinite(take.sequence.given.poses[frame, 0]), given)}")
        return "\n\n".join(lines)
    return "\n\n".join([*lines, "\n".join(_frame_line(answer, frame) for answer in take.estimates)])


def _frame_line(answer: Answer, frame: int) -> str:
    given = int(np.isfinite(answer.given.positions[frame, :, 0]).sum())
    parts = [f"given {_given_words(bool(np.isfinite(answer.given.poses[frame, 0])), given)}"]
    for key, values in answer.errors.items():
        if np.isfinite(values[frame]):
            parts.append(_figure(key, values[frame]))
    return f"* **{answer.name}**: {', '.join(parts)}"


def _figure(metric: str, value: float) -> str:
    return f"{METRICS[metric].symbol} {value:.3f} {METRICS[metric].unit}"


def _given_words(pose: bool, people: int) -> str:
    words = [*(["the pose"] if pose else []), *([f"{people} positions"] if people else [])]
    return " and ".join(words) or "nothing"
