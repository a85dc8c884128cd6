"""``gt/gt.txt`` of MOTChallenge Head Tracking 21, and the heads in it that count."""

import numpy as np

from vbbench.errors import FileError
from vbbench.exchange.mot.text import COLUMNS, PEDESTRIAN, UNLINKED, MotTable, parse_mot
from vbbench.geometry import BoolArray, FloatArray
from vbbench_generators.crohd.finding import RecordingFiles
from vbbench_generators.crohd.heads import HeadBoxes
from vbbench_generators.crohd.seqinfo import SequenceInfo, parse_seqinfo
from vbbench_generators.readers.gates import check_size

_LEAST_TRACKS, _LEAST_FRAMES = 2, 2


def read_heads(files: RecordingFiles) -> HeadBoxes:
    """The heads of a recording that count: of class 1 (walking people), with conf other than 0, visible at all.

    Frame rate, length and size are those of ``seqinfo.ini``. Rows that do not count (statues, ignored regions, people
    on vehicles, hidden heads) only have to be rows of numbers.

    Raises
    ------
    FileError
        With file and line: not 9 columns, text or NaN in a number, and, of a head that counts, a frame that the
        recording has not, a bad id, a box without size, a second box in a frame. Or if the heads that count
        are no crowd, or too many.
    """
    info = parse_seqinfo(files.seqinfo.path, files.seqinfo.content)
    table = parse_mot(files.boxes.path, files.boxes.content, least=len(COLUMNS), most=len(COLUMNS))
    return _heads(table.select(_counts(table.values)), info)


def _heads(table: MotTable, info: SequenceInfo) -> HeadBoxes:
    table.check(info.frames)
    table.refuse_repetition()
    frame, track = table.frame, table.track
    if np.any(track == UNLINKED):
        line = int(table.lines[(track == UNLINKED).argmax()])
        raise FileError(table.path, "id is -1: these are detections; tracks of heads are wanted", line)
    tracks, frames = len(np.unique(track)), int(frame.max(initial=-1)) + 1
    if tracks < _LEAST_TRACKS or len(np.unique(frame)) < _LEAST_FRAMES:
        problem = "holds no crowd: two tracks and two frames at least of class 1, conf not 0 and visibility above 0"
        raise FileError(table.path, problem)
    check_size(table.path, frames, tracks, len(frame))
    order = np.lexsort((frame, track))
    return HeadBoxes(
        name=info.name,
        dt=info.dt,
        size=info.size,
        frame=frame[order],
        track=track[order],
        boxes=table.boxes[order],
        visible=table.values[order, 8],
    )


def _counts(values: FloatArray) -> BoolArray:
    """Which rows [N, 9] count."""
    confidence, kind, visible = values[:, 6:].T
    counts: BoolArray = (kind == PEDESTRIAN) & (confidence != 0.0) & (visible > 0.0)
    return counts
