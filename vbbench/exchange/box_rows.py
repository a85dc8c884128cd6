"""Boxes of people, one a row: the result of every reader of boxes, with ids, checks, and the times of their frames."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from vbbench.errors import FileError, quoted
from vbbench.exchange.box_tables import UNLINKED, BoxTable, frame_numbers, people_in, read_box_file
from vbbench.exchange.text_tables import NamedColumns, Rows
from vbbench.files.tables import LARGEST_ID, first_repetition
from vbbench.folders.replacing import write_text_atomically
from vbbench.geometry import FloatArray, IntArray, freeze
from vbbench.parsing.column_names import UNITS

SAME_FRAME = 0.1
"""Time stamps that differ by less, in frames, are of one frame."""
UNEVEN = 0.25
"""How far the time between two frames may be from a whole number of frames before it is worth a note."""
SLOWEST, MOST_FRAMES = 5.0, 300.0
"""Stamps that are usually so many s apart, or frames whose duration is given, are no seconds."""
LONGEST_GAP, LONGEST_ABSENCE = 60.0, 3600.0
"""A clock that goes on by more seconds from one box to the next has jumped; so has a frame number."""
SEVERAL_TICKS, DOUBTED = 200, 0.12
"""Ticks that show how long one of an even clock lasts, and by what share that may differ from what is stated."""
FIRST_TICKS, FOLLOWS = 10, 0.1
"""Stamps that show when it ticks, and the share of what a stamp is off by that it follows."""
DRIFT = 0.02
"""How far the mean time of a frame may be from the stated one before it is worth a note, as a share."""


@dataclass(frozen=True)
class Timeline:
    """The times of a recording's frames.

    Parameters
    ----------
    frames : number of frames T.
    times : [T] in s by the clock of the boxes' file, to which poses and odometry refer.
    first_number, step : number of frame 0 in the file, and difference to the next; 0 and 1 with time stamps.
    numbered : whether frames have numbers in the file, and no time stamps.
    near : greatest distance in s of a time from its frame; ``None`` for half of ``dt``.
    """

    frames: int
    dt: float
    times: FloatArray
    first_number: int = 0
    step: int = 1
    notes: tuple[str, ...] = ()
    near: float | None = None
    numbered: bool = False

    @property
    def frame_time(self) -> float:
        """Seconds from a frame of the film to the next, of which every ``step``-th is used."""
        return self.dt / self.step

    def frame_of_time(self, time: FloatArray) -> FloatArray:
        """The nearest frames of time stamps; −1 if none is near."""
        frame = nearest(self.times, time)
        near = np.abs(self.times[frame] - time) <= (0.5 * self.dt if self.near is None else self.near) + 1e-9
        return np.where(near, frame, -1.0)


def number_frames(rows: Rows, numbers: FloatArray, dt: float | None, base: int) -> tuple[IntArray, Timeline]:
    """The frame of each row by its frame number [N]; ``base`` is the number of the first frame of the film.

    Numbers with a constant step, as of a film of which every fourth frame was used, become consecutive frames.
    """
    wrong = (numbers != np.round(numbers)) | (numbers < 0)
    rows.refuse(wrong, "frame {0:.10g} is not a whole number from 0 on", numbers)
    if dt is None:
        problem = "its frames are numbered, and no file says how long one lasts"
        raise FileError(rows.path, f"{problem}: give --dt, or write dt or fps in camera.toml")
    different = np.unique(numbers)
    apart = np.diff(different) * dt
    if (apart > LONGEST_ABSENCE).any():
        gap = int(np.argmax(apart > LONGEST_ABSENCE))
        before, after = different[gap : gap + 2]
        problem = f"frame {after:.10g} is {apart[gap]:.6g} s after the one before, {before:.10g}"
        stamped = len(apart) >= FIRST_TICKS and np.median(apart) > LONGEST_ABSENCE
        name = "are these time stamps? Then name the column time_ms or time_ns"
        advice = name if stamped else "split the recording there"
        raise rows.fault(int(np.argmax(numbers == after)), f"{problem}; {advice}")
    different = different.astype(np.int64)
    step = max(1, int(np.gcd.reduce(np.diff(different)))) if len(different) > 1 else 1
    first = int(different[0])
    frame = (numbers.astype(np.int64) - first) // step
    count = int(frame.max()) + 1
    note = f"frames are numbered in steps of {step}: one every {step} x {dt:g} = {step * dt:g} s is used"
    times = np.asarray((first - min(base, first) + step * np.arange(count)) * dt, np.float64)
    return frame, Timeline(count, step * dt, times, first, step, (note,) if step > 1 else (), numbered=True)


def time_frames(rows: Rows, times: FloatArray, dt: float | None) -> tuple[IntArray, Timeline]:
    """The frame of each row by its time stamp in s [N], in whatever order the rows are.

    The time from a frame to the next is rounded to whole frames, which tolerates a small error of the clock's rate.
    With large jitter, ticks of a regular clock are counted instead.
    """
    order = np.argsort(times, kind="stable")
    begins = np.concatenate([[True], np.diff(times[order]) > SAME_FRAME * (dt or 0.001)])
    stamps, group = times[order][begins], np.cumsum(begins) - 1
    if len(stamps) < 2:
        raise FileError(rows.path, "all boxes are of one time; a map needs a film")
    apart = np.diff(stamps)
    usual, row_of = float(np.quantile(apart, 0.5, method="lower")), order[np.flatnonzero(begins)]
    if usual > (MOST_FRAMES * dt if dt else SLOWEST):
        unit = next((one for one in ("ms", "us", "ns") if dt and 0.9 < usual * UNITS[one] / dt <= MOST_FRAMES), None)
        if unit is None:
            advice = "times are in seconds: are these milliseconds, or nanoseconds? Then name them time_ms or time_ns"
            raise rows.fault(int(row_of[1]), f"frames are {usual:.6g} s apart; {advice}; else write dt")
        frame, timeline = time_frames(rows, times * UNITS[unit], dt)
        return frame, replace(timeline, notes=(f"times are read as {unit}", *timeline.notes))
    said = dt or usual
    steps = apart / said
    whole = np.round(steps).astype(np.int64)
    if (whole < 1).any():
        whole = _by_the_clock(stamps, said)
    wrong = (whole < 1) | (apart > LONGEST_GAP)
    if wrong.any():
        after = int(wrong.argmax())
        if apart[after] > LONGEST_GAP:
            problem = f"the clock jumps by {apart[after]:.6g} s, from {stamps[after]:.10g} s; split the recording there"
        else:
            late = f"{apart[after]:.3g} s after the frame before"
            problem = f"time {stamps[after + 1]:.10g} s is {late}, a frame lasts {said:g} s; write the dt of the stamps"
        raise rows.fault(int(row_of[after + 1]), problem)
    number = np.concatenate([[0], np.cumsum(whole)])
    every = int(np.gcd.reduce(np.diff(number)))
    number, steps, notes = number // every, steps / every, list[str]()
    if every > 1:
        notes += [f"time stamps come every {every} frames: one every {every} x {said:g} = {every * said:g} s is used"]
    near = 0.5 * said
    said *= every
    frame = np.empty(len(times), np.int64)
    frame[order] = number[group]
    count = int(number[-1]) + 1
    middle = number - number.mean()
    mean = float(middle @ (stamps - stamps.mean()) / (middle @ middle))  # the slope of all, whatever the ends' jitter
    lasts = said if abs(mean / said - 1.0) <= DRIFT else round(mean, 6)
    if lasts != said:
        stated = f"every {mean:.4g} s, and dt is {said:g} s"
        notes += [f"time stamps come {stated}: motions are taken to last {mean:.4g} s"]
    uneven = int((np.abs(steps - np.round(steps)) > UNEVEN).sum())
    if uneven:
        grid = f"more than {UNEVEN:g} frames from an even grid of {said:g} s"
        notes += [f"{uneven} of {len(steps)} time stamps are {grid}"]
    times = np.interp(np.arange(count), number, stamps)
    return frame, Timeline(count, lasts, times, notes=tuple(notes), near=near if every > 1 else None)


def _by_the_clock(stamps: FloatArray, dt: float) -> IntArray:
    """[N − 1] frames from each stamp to the next, by the nearest tick of a regular clock, for stamps with jitter.

    The clock follows the stamps slowly, as its rate may have a small error. A step below 1 means that two stamps belong
    to one tick.
    """
    since = stamps - stamps[0]
    shown = since[since <= SEVERAL_TICKS * dt]
    finest = 0.1 * dt / max(float(shown[-1]) / dt, 1.0)
    ticks = dt + finest * np.arange(-round(DOUBTED * dt / finest), round(DOUBTED * dt / finest) + 1)
    dt = float(ticks[np.abs(np.exp(2j * np.pi * shown / ticks[:, None]).sum(axis=1)).argmax()])  # the best period
    first = since[:FIRST_TICKS] / dt
    clock = stamps[0] + dt * float(np.angle(np.exp(2j * np.pi * first).mean())) / (2.0 * np.pi)
    steps = np.empty(len(stamps), np.int64)
    for n, stamp in enumerate(stamps.tolist()):
        steps[n] = round((stamp - clock) / dt)
        clock += steps[n] * dt
        clock += FOLLOWS * (stamp - clock)
    return steps[1:]


def nearest(times: FloatArray, wanted: FloatArray) -> IntArray:
    """[M] the row of ``times`` [N], ascending, nearest to each that is ``wanted`` [M]."""
    after = np.searchsorted(times, wanted).clip(min(1, len(times) - 1), len(times) - 1)
    before = np.maximum(after - 1, 0)
    return np.where(np.abs(times[before] - wanted) <= np.abs(times[after] - wanted), before, after)


FARTHEST = 1e6
"""Largest side or size of a box in px."""
MOST_BACK = 3
"""Times that a clock goes back; a file whose times do so more often is in no order."""
FEWEST_ALONE = 10
"""So many boxes of which no two have one id are numbered, not linked."""
SAMPLE = 5000
"""Rows of which it is looked at whether frames and ids are swapped."""
OTHER_RATE = 0.1
"""Share by which times may differ from the frames that they stand next to."""
OFF_FRAME = 0.25
"""How far a time stamp may be from a frame of another recording, in frames."""


@dataclass(frozen=True)
class Ids:
    """Numbers of tracks for the ids of a file: these ids, or 1, 2, … if they are texts or have 64 bits.

    ``originals`` [K] are the ids of tracks 1 to K, ascending; ``None`` where tracks have the ids of the file.
    """

    originals: NDArray[Any] | None = None

    def tracks(self, ids: NDArray[Any]) -> IntArray:
        """[N] the track of each id; ids without boxes follow those with boxes."""
        if self.originals is None:
            return ids.astype(np.int64)
        more = np.setdiff1d(ids.astype(self.originals.dtype), self.originals)
        every = np.concatenate([self.originals, more])
        order = np.argsort(every)
        return 1 + order[np.searchsorted(every[order], ids.astype(every.dtype))]

    def of(self, tracks: IntArray) -> NDArray[Any]:
        """[N] the ids of the file of some tracks."""
        return tracks if self.originals is None else self.originals[tracks - 1]


AS_THEY_ARE = Ids()
"""Ids of a file that are the numbers of tracks."""


@dataclass(frozen=True, kw_only=True)
class BoxRows(Rows):
    """Boxes of one sequence, one a row.

    Parameters
    ----------
    frame : [N] from 0.
    track : [N] ids, `UNLINKED` for detections that no tracker has linked.
    boxes : [N, 4] (left, top, width, height) in px from 0.
    scores : [N] scores of the detector or tracker; NaN where there is none.
    visible : [N] visible fraction; NaN where it is not known.
    ids : ids of the tracks in the file.
    notes : notes for the user.
    """

    frame: IntArray
    track: IntArray
    boxes: FloatArray
    scores: FloatArray
    visible: FloatArray
    ids: Ids = AS_THEY_ARE
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        count = len(self.frame)
        freeze(self, np.int64, frame=(count,), track=(count,), lines=(count,))
        freeze(self, scores=(count,), visible=(count,), boxes=(count, 4))

    @property
    def linked(self) -> bool:
        """Whether boxes have ids."""
        return bool((self.track != UNLINKED).any())

    def within(self, frames: int) -> Self:
        """The rows themselves; raises FileError at the first box outside a recording of ``frames`` frames."""
        beyond = (self.frame < 0) | (self.frame >= frames)
        problem = f"frame {{0}}, counted from 0, is beyond the recording of {frames} frames"
        if len(self) and self.frame.min() > 0 and self.frame.max() == frames:
            problem += "; do the frames of this file count from 1? Then subtract 1"
        self.refuse(beyond, problem, self.frame)
        return self

    def dense(self, frames: int, *values: FloatArray) -> tuple[IntArray, FloatArray]:
        """Track ids [K], and ``values`` [N, …] side by side, [T, K, C]; NaN where a track has no box."""
        tracks, column = np.unique(self.track, return_inverse=True)
        rows = np.column_stack(values)
        dense = np.full((frames, len(tracks), rows.shape[1]), np.nan)
        dense[self.frame, column] = rows
        return tracks.astype(np.int64), dense

    def check(self) -> Self:
        """The rows themselves; raises FileError at the first box that cannot be a person or repeats track and frame."""
        width, height = self.boxes[:, 2:].T
        reach = np.abs(self.boxes).max(axis=1, initial=0.0)
        self.refuse((width <= 0.0) | (height <= 0.0), "the box is {0:g} x {1:g} px; remove it", width, height)
        self.refuse(reach > FARTHEST, "the box reaches {0:g} px; boxes are in px of the picture", reach)
        hidden = (self.visible < 0.0) | (self.visible > 1.0)
        self.refuse(hidden, "visibility is {0:g}; it is a share, from 0 to 1", self.visible)
        linked = np.flatnonzero(self.track != UNLINKED)
        twice = first_repetition(self.frame[linked], self.track[linked])
        if twice is not None:
            before, again = linked[np.array(twice)]
            back = 1 + np.flatnonzero(np.diff(self.frame) < 0)
            between = back[(back > before) & (back <= again)].tolist() if len(back) <= MOST_BACK else []
            hint = f", or split the recording in line {self.lines[between[-1]]}: time goes back" if between else ""
            box = f"id {self.ids.of(self.track[[again]])[0]} already has a box in this frame, in {self.place(before)}"
            raise self.fault(again, f"{box}; remove one of them{hint}")
        return self


Boxes = TypeVar("Boxes", bound=BoxRows)


def rows_of(
    path: Path, frame: IntArray, track: IntArray, boxes: FloatArray, scores: FloatArray, lines: IntArray | None = None
) -> BoxRows:
    """Rows without visible fractions; without ``lines`` they are of no file."""
    lines = np.zeros(len(frame), np.int64) if lines is None else lines
    visible = np.full(len(frame), np.nan)
    return BoxRows(path=path, lines=lines, frame=frame, track=track, boxes=boxes, scores=scores, visible=visible)


def linked_rows(table: BoxTable, frame: IntArray) -> BoxRows:
    """The boxes of a table in frames [N] from 0, checked; a note says where tracks have other ids than the file."""
    track, ids, notes = _tracks_of(table)
    names = ("path", "lines", "where", "boxes", "scores", "visible")
    return BoxRows(frame=frame, track=track, ids=ids, notes=notes, **{n: getattr(table, n) for n in names}).check()


def _tracks_of(table: BoxTable) -> tuple[IntArray, Ids, tuple[str, ...]]:
    """The tracks of rows, `UNLINKED` if none has an id (empty or −1); the file's ids; and notes."""
    ids = table.id
    texts = ids.dtype.kind not in "if"
    loose = (ids == "") | (ids == str(UNLINKED)) if texts else np.isnan(ids.astype(np.float64)) | (ids == UNLINKED)
    if loose.all():
        return np.full(len(ids), UNLINKED), AS_THEY_ARE, ()
    table.refuse(loose, "the id is missing here, other boxes have one; give every box an id, or none")
    if not texts:
        wrong = (ids != np.round(ids)) | (ids < 0)
        table.refuse(wrong, "id {0} is not a whole number from 0 on; give every box an id, or none", ids)
    times, originals, many = len(np.unique(table.frame)), np.unique(ids), len(ids) >= FEWEST_ALONE
    if many and len(originals) == len(ids) and times > 1:
        problem = f"no id occurs in two of {len(ids)} boxes: these are numbers of boxes, not of people"
        raise FileError(table.path, f"{problem}; remove the column to have boxes linked")
    if many and len(originals) == 1 and 2 * times <= len(ids):
        problem = f"all boxes have id {ids[0]}, several of them in one frame: is this column the class?"
        raise FileError(table.path, f"{problem} Then name the columns in a first line")
    if table.header is None and not texts:
        _refuse_swapped(table)
    if ids.dtype.kind == "f":
        table.refuse(ids > 2.0**53, "the id is {0:g}: digits are lost; write ids without point and exponent", ids)
    if not texts and ids.max() <= LARGEST_ID:
        return ids.astype(np.int64), AS_THEY_ARE, ()
    named, count = Ids(originals if texts else originals.astype(np.int64)), len(originals)
    kind = "texts" if texts else f"larger than {LARGEST_ID}"
    first = f"{quoted(str(named.of(np.ones(1, np.int64))[0]))} is 1"
    note = f"ids are {kind}: in dataset and submission, tracks are numbered 1 to {count}, {first}"
    return named.tracks(ids), named, (note,)


def _refuse_swapped(table: BoxTable) -> None:
    """Raise FileError if steps of people are much shorter with the columns of frame and id swapped."""
    frame, ids, boxes = table.frame[:SAMPLE], table.id[:SAMPLE], table.boxes[:SAMPLE]

    def steps(person: NDArray[Any], time: NDArray[Any]) -> FloatArray:
        order = np.lexsort((time, person))
        left, height = boxes[order, 0], np.maximum(boxes[order, 3], 1e-9)  # boxes without height are refused later
        return np.asarray((np.abs(np.diff(left)) / height[1:])[np.diff(person[order]) == 0])

    given, swapped = steps(ids, frame), steps(frame, ids)
    if min(len(given), len(swapped)) >= FEWEST_ALONE and np.median(given) > max(0.5, 4.0 * np.median(swapped)):
        problem = f"frame and id seem to be swapped: an id moves by {np.median(given):.2g} heights of its box a frame"
        raise FileError(table.path, f"{problem}; if so, write '# id,frame,left,top,width,height' in a first line")


@dataclass(frozen=True, kw_only=True)
class OwnBoxes(BoxRows):
    """The boxes of one recording with the times of its frames.

    ``plain`` is whether the file is text whose reading does not depend on its name.
    """

    timeline: Timeline
    plain: bool = False


def read_boxes(
    path: Path,
    dt: float | None,
    *,
    picture: tuple[float, float] | None = None,
    person_class: int | str | None = None,
) -> OwnBoxes:
    """Read boxes of people.

    Parameters
    ----------
    path : a file, or a folder of YOLO's labels (`vbbench.exchange.box_tables`).
    dt : seconds per frame, ``None`` if only the file's time stamps say it.
    picture : width and height in px, for boxes that are shares of it.
    person_class : class of people, by number or name, where the file does not show it.
    """
    table = read_box_file(path, picture)
    if not len(table.frame):
        raise FileError(path, "holds no box")
    lasts = None if table.timed else _frame_time(table, dt)
    dt, rate = dt or lasts, ""
    if lasts and dt and abs(lasts / dt - 1.0) > OTHER_RATE:
        rate = f"times go on by {lasts:.4g} s a frame, and a frame is said to last {dt:g} s, which counts: is it right?"
    if table.timed:
        frame, timeline = time_frames(table, table.frame, dt)
    else:
        frame, timeline = number_frames(table, table.frame, dt, base=table.base)
    kept, notes = people_in(table, person_class)
    table = table.select(kept)
    plain = table.path == path and bool(table.lines.any()) and person_class is None and not table.class_names
    rows = OwnBoxes(**vars(linked_rows(table, frame[kept])), timeline=timeline, plain=plain)
    return replace(rows, notes=(*table.notes, *notes, *rows.notes, *filter(None, (rate, _goes_back(rows)))))


def _frame_time(table: BoxTable, dt: float | None) -> float | None:
    """Seconds per frame from times next to frame numbers, in the unit that fits; ``None`` without times."""
    times, ends = table.scaled("time"), [int(table.frame.argmin()), int(table.frame.argmax())]
    (passed,), (frames,) = np.diff(times[ends]), np.diff(table.frame[ends])
    if not passed > 0.0:
        return None
    lasts = (float(passed * unit / frames) for unit in table.time_units)
    return min(lasts, key=lambda one: abs(np.log(one / (dt or 0.1))))


def rows_in_frames(rows: OwnBoxes, frames: int, dt: float) -> BoxRows:
    """The boxes in a recording of ``frames`` frames, ``dt`` s apart, whose first one is at 0 s."""
    exact = rows.timeline.times[rows.frame] / dt
    found = replace(rows, frame=np.round(exact).astype(np.int64)).within(frames)
    between = np.abs(exact - found.frame) > OFF_FRAME
    problem = f"time {{0:.10g}} s lies between two frames; frame n is at n x {dt:g} s, from 0"
    rows.refuse(between, problem, exact * dt)
    return found


def write_boxes(path: Path, rows: OwnBoxes) -> None:
    """Write CSV that `read_boxes` reads as the same boxes, of people alone, at the same times."""
    columns = {"time": rows.timeline.times[rows.frame]}
    if rows.linked:
        columns["id"] = rows.ids.of(rows.track)
    columns |= dict(zip(("left", "top", "width", "height"), rows.boxes.T, strict=True))
    columns |= {"score": rows.scores, "visible": rows.visible}
    cells = [["" if cell == "nan" else cell for cell in map(str, column.tolist())] for column in columns.values()]
    lines = [",".join(columns), *map(",".join, zip(*cells, strict=True))]
    write_text_atomically(path, "\n".join(lines) + "\n")


def _goes_back(rows: OwnBoxes) -> str:
    """A note if the clock goes back a few times; that of unordered rows does so often, in order of ids at each id."""
    apart = np.diff(rows.timeline.times[rows.frame])
    back = np.flatnonzero(apart < 0.0)
    if not rows.lines.any() or not 0 < len(back) <= MOST_BACK:
        return ""
    parts = rows.track[: back[0] + 1], rows.track[back[0] + 1 :]
    if rows.linked and (min(len(np.unique(part)) for part in parts) < 2 or np.isin(*parts).any()):
        return ""
    split = "ids before and after differ: are these two recordings?"
    what = split if rows.linked else "boxes of one time are taken for one frame"
    return f"{rows.path.name}, line {rows.lines[back[0] + 1]}: the clock goes back by {-apart[back[0]]:.4g} s; {what}"


def named_frames(table: NamedColumns, timeline: Timeline) -> IntArray:
    """The frame of each row of a table of the same recording, −1 where there is none.

    Times are in the unit of their name, or in whichever of s, ms, us and ns most frames have.
    """
    if "frame" in table:
        exact = [(frame_numbers(table) - timeline.first_number) / timeline.step]
    else:
        exact = [timeline.frame_of_time(table.scaled("time") * unit) for unit in table.time_units]
    there = [(one == np.round(one)) & (one >= 0) & (one < timeline.frames) for one in exact]
    frames = [np.where(known, one, -1.0).astype(np.int64) for known, one in zip(there, exact, strict=True)]
    return max(frames, key=lambda one: len(np.unique(one)))
