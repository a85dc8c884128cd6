"""Files of boxes of the user's own: what is read alike, and what is said of bad rows."""

import numpy as np
import pytest

from tests.lib.own_recording import HEAD
from vbbench.errors import FileError
from vbbench.exchange.box_rows import read_boxes
from vbbench.exchange.box_tables import scores_as_shares

TIMED = HEAD.replace("frame", "time")


def test_a_fast_reader_and_the_careful_one_agree(read):
    head = "frame,id,left,top,width,height,score,visible\n"
    one = read("plain.csv", head + "0,1,2,3,4,50,.5,\n1,1,2,3,4,50,,1\n")
    other = read("quoted.csv", head + '0,"1", 2,3,4,50,0.5,\n\n1,1,2,3,4,50,,1\n')
    for name in ("frame", "track", "boxes", "scores", "visible"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    assert other.lines.tolist() == [2, 4]


@pytest.mark.parametrize(
    ("text", "line", "problem"),
    [
        ("frame,id,left,top,width\n0,1,2,3,4\n", 1, "no column height"),
        ("fram,id,left,top,width,height\n0,1,2,3,4,50\n", 1, "no column frame or time; did you mean 'frame'"),
        ("frame,id,track_id,left,top,width,height\n0,0,1,2,3,4,50\n", 1, "'id' and 'track_id' could both be the id"),
        ("x,y,w,h\n1,2,3,4\n", 1, "no column frame or time; its columns are 'x,y,w,h', wanted: frame or time, left"),
        (HEAD, None, "holds no box"),
        (HEAD + "0,1,2,3,4\n", 2, "5 columns, the first line names 6"),
        (HEAD + "0,1,2,3,4,50\n1,1,x,3,4,50\n", 3, "left is 'x'; write a number"),
        (HEAD + "0,1,2,3,4,50\n1,1,nan,3,4,50\n", 3, "left is nan"),
        (HEAD + "0,1,2,3,4,50\n1,1,2,3,0,50\n", 3, "the box is 0 x 50 px"),
        (HEAD + "0,1,2,3,4,50\n1,1,2e7,3,4,50\n", 3, "reaches 2e\\+07 px"),
        (HEAD + "0,1,2,3,4,50\n0,1,2,3,4,50\n", 3, "id 1 already has a box in this frame, in line 2"),
        (HEAD + "0,1,2,3,4,50\n1,1.5,2,3,4,50\n", 3, "id 1.5 is not a whole number"),
        (HEAD + "0,1,2,3,4,50\n1,-1,2,3,4,50\n", 3, "the id is missing here"),
        (HEAD + "0,1,2,3,4,50\n1.5,1,2,3,4,50\n", 3, "frame 1.5 is not a whole number from 0 on"),
        (
            HEAD + "0,1,2,3,4,50\n1e15,1,2,3,4,50\n1,1,2,3,4,50\n",
            3,
            "frame 1e\\+15 is 1e\\+14 s after the one before, 1; split",
        ),
        (
            HEAD + "".join(f"{10**8 + n * 10**6},1,2,3,4,50\n" for n in range(12)),
            3,
            "are these time stamps\\? Then name the column time_ms or time_ns",
        ),
        (HEAD + "0,1,2,3,4,50\n1e300,1,2,3,4,50\n", 3, "frame 1e\\+300 is 1e\\+299 s after the one before, 0; split"),
        ("frame,id,left,top,width,height,visible\n0,1,2,3,4,50,2\n", 2, "visibility is 2"),
        (TIMED + "0,1,2,3,4,50\n.1,1,2,3,4,50\n.13,1,2,3,4,50\n", 4, "0.03 s after the frame before"),
        (
            TIMED + "0,1,2,3,4,50\n.1,1,2,3,4,50\n.2,1,2,3,4,50\n.1,1,2,3,4,50\n.2,1,2,3,4,50\n",
            5,
            "id 1 already has a box in this frame, in line 3; remove one of them, or split the recording in line 5",
        ),
        (TIMED + "0,1,2,3,4,50\n.1,1,2,3,4,50\n3600,1,2,3,4,50\n", 4, "the clock jumps by 3599.9 s"),
        (
            TIMED + "0,1,2,3,4,50\n33,1,2,3,4,50\n67,1,2,3,4,50\n",
            3,
            "frames are 33 s apart; times are in seconds",
        ),
        (TIMED + "0,1,2,3,4,50\n1e12,1,2,3,4,50\n2e12,1,2,3,4,50\n", 3, "are these milliseconds, or nanoseconds"),
        (TIMED + "5,1,2,3,4,50\n", None, "all boxes are of one time"),
    ],
)
def test_a_bad_row_is_named(read, text, line, problem):
    with pytest.raises(FileError, match=problem) as caught:
        read("boxes.csv", text)
    assert caught.value.line == line


def test_clocks_that_drift_and_frames_in_steps_are_counted(read):
    lines = [f"{0.1035 * t:.4f},1,{100 + t},100,20,60\n" for t in range(50) if t != 20]
    rows = read("boxes.csv", TIMED + "".join(lines))
    assert rows.frame.tolist() == [t for t in range(50) if t != 20]
    assert rows.timeline.dt == pytest.approx(0.1035)
    assert "every 0.1035 s, and dt is 0.1 s" in rows.timeline.notes[0]
    rows = read("boxes.csv", HEAD + "".join(f"{t},1,{100 + t},100,20,60\n" for t in range(7, 60, 4)), dt=0.04)
    assert (rows.frame[-1], rows.timeline.dt, rows.timeline.times[0]) == (13, pytest.approx(0.16), pytest.approx(0.28))
    assert "in steps of 4" in rows.timeline.notes[0]


@pytest.mark.parametrize("name", ["boxes.csv", "boxes.txt", "boxes"])
def test_a_file_that_is_not_there_is_named(tmp_path, name):
    with pytest.raises(FileError, match=f"{name}: the file is missing"):
        read_boxes(tmp_path / name, 0.1)


@pytest.mark.parametrize("tick", [0.097, 0.1003, 0.104])
def test_stamps_that_shake_are_of_the_nearest_frame(read, tick):
    shake = np.random.default_rng(3).uniform(-0.03, 0.03, 200)
    stamps = 1.7e9 + tick * np.arange(200) + shake
    assert np.round(np.diff(stamps) / 0.1).min() < 1
    rows = read("boxes.csv", TIMED + "".join(f"{t:.4f},1,2,3,4,50\n" for t in np.delete(stamps, 50)))
    assert rows.frame.tolist() == [n for n in range(200) if n != 50]
    assert rows.timeline.frames == 200


def test_stamps_slower_than_frames_are_counted(read):
    lines = [f"{0.1 * n:.4f},1,2,3,4,50\n" for n in range(20) if n != 7]
    rows = read("boxes.csv", TIMED + "".join(lines), dt=1 / 30)
    assert rows.frame.tolist() == [n for n in range(20) if n != 7]
    assert rows.timeline.dt == pytest.approx(0.1)
    assert "time stamps come every 3 frames: one every 3 x 0.0333333 = 0.1 s is used" in rows.timeline.notes


def test_times_between_frames_that_are_sparse_are_of_none(read):
    """As places of people at every frame, where boxes are at every third."""
    lines = [f"{0.1 * n:.4f},1,2,3,4,50\n" for n in range(20)]
    timeline = read("boxes.csv", TIMED + "".join(lines), dt=1 / 30).timeline
    assert timeline.frame_of_time(np.array([0.0, 0.033, 0.067, 0.1, 0.11])).tolist() == [0, -1, -1, 1, 1]


@pytest.mark.parametrize(
    ("times", "problem"),
    [
        (
            [(n, 1) for n in range(9)] + [(n, 2) for n in range(9)] + [(4, 2), (5, 2)],
            "id 2 already has a box in this frame, in line 15; remove one of them, or split the recording in line 20",
        ),
        ([(n, 1) for n in (*range(9), 0)], "id 1 already has a box in this frame, in line 2; remove one of them"),
    ],
)
def test_a_repeated_row_is_named(read, times, problem):
    with pytest.raises(FileError, match=problem):
        read("boxes.csv", TIMED + "".join(f"{0.1 * n:.1f},{k},2,3,4,50\n" for n, k in times), dt=None)


def test_scores_become_shares():
    """Per cent where one is beyond what a sure detector says; a little above 1 is sure."""
    assert scores_as_shares(np.array([0.3, 1.02, np.nan])).tolist() == [0.3, 1.0, 1.0]
    assert scores_as_shares(np.array([1.0, 2.0, 60.0, 95.0])).tolist() == [0.01, 0.02, 0.6, 0.95]
    assert scores_as_shares(np.array([-1.0, 0.0, 3.0]))[1] == 0.5


@pytest.mark.parametrize(("unit", "per_second"), [("ms", 10**3), ("us", 10**6), ("ns", 10**9)])
@pytest.mark.parametrize("step", [1, 4])
def test_times_in_parts_of_a_second_are_read_where_dt_decides_it(read, unit, per_second, step):
    stamps = [1_700_000_000 * per_second + n * step * per_second // 10 for n in range(12)]
    text = TIMED + "".join(f"{stamp},1,2,3,4,50\n" for stamp in stamps)
    rows = read("boxes.csv", text)
    assert rows.frame.tolist() == list(range(12))
    assert rows.timeline.dt == pytest.approx(0.1 * step)
    assert f"times are read as {unit}" in rows.timeline.notes
    with pytest.raises(FileError, match="name them time_ms or time_ns"):
        read("boxes.csv", text, dt=None)


def test_rows_without_a_box_are_of_nobody(read):
    text = "0,1,2,3,4,50\n1,,,,,\n2,1,nan,nan,nan,nan\n3,1,2,3,4,50\n4,1,2,3,4,50\n"
    assert read("boxes.csv", HEAD + text).frame.tolist() == [0, 3, 4]


def test_a_stamp_that_is_missing_among_stamps_of_64_bits_is_named(read):
    rows = [f"{1_700_000_000_000_000_000 + n * 100_000_000},1,2,3,4,50\n" for n in range(5)]
    with pytest.raises(FileError, match="line 3: frame is 'None'; write a number"):
        read("gt.txt", "".join([*rows[:2], "None,1,2,3,4,50\n", *rows[3:]]))


@pytest.mark.parametrize(("times", "lasts"), [([0.0, 0.04, 0.08], 0.04), ([0, 40, 80], 0.04), ([0, 100, 200], None)])
def test_times_next_to_frames_contradict_the_time_of_a_frame_or_are_it(read, times, lasts):
    rows = "".join(f"{frame},{time},1,2,3,4,50\n" for frame, time in enumerate(times))
    text = "frame,timestamp,id,left,top,width,height\n" + rows
    found = read("boxes.csv", text)
    assert found.timeline.dt == 0.1
    assert [note.split(",")[0] for note in found.notes] == ([] if lasts is None else ["times go on by 0.04 s a frame"])
    assert read("boxes.csv", text, dt=None).timeline.dt == pytest.approx(lasts or 0.1)


def test_dates_next_to_frames_do_no_harm(read):
    rows = "".join(f"{n},2024-05-01 12:00:0{n},1,2,3,4,50\n" for n in range(5))
    found = read("boxes.csv", "sep=,\nframe,timestamp,id,left,top,width,height\n" + rows)
    assert found.frame.tolist() == [0, 1, 2, 3, 4]


def walkers(order, frames=12):
    """MOTChallenge text of three people who walk to the right."""
    rows = [(t + 1, 7 + k, 100.0 + 200.0 * k + 3.0 * t, 50.0) for t in range(frames) for k in range(3)]
    return "".join(",".join(f"{row[n]:g}" if n < 4 else "0" for n in order) + ",30,80\n" for row in rows)


@pytest.mark.parametrize(
    ("order", "problem"),
    [
        ([1, 0, 2, 3], r"frame and id seem to be swapped.*'# id,frame,left,top,width,height'"),
        ([0, 4, 2, 3], r"all boxes have id 0.* is this column the class"),
    ],
)
def test_columns_in_another_order_are_refused_by_how_boxes_move(read, order, problem):
    with pytest.raises(FileError, match=problem):
        read("gt.txt", walkers(order))
    for text in (walkers([0, 1, 2, 3]), "# id,frame,left,top,width,height\n" + walkers([1, 0, 2, 3])):
        assert len(np.unique(read("gt.txt", text).track)) == 3


def test_a_visibility_that_is_zero_throughout_is_not_known(read):
    rows = read("gt.txt", "".join(f"{n},1,2,3,40,90,1,1,0\n" for n in range(1, 13)))
    assert len(rows) == 12
    assert np.isnan(rows.visible).all()


@pytest.mark.parametrize(("blocks", "asked"), [(["12", "34"], 1), (["12", "12"], 0), (["1", "2"], 0), (["123"], 0)])
def test_a_second_recording_whose_ids_go_on_is_asked_about(read, blocks, asked):
    again = 10 * (blocks[0] == blocks[-1])  # the same ids in later frames
    rows = [(frame + again * n, name) for n, names in enumerate(blocks) for frame in range(4) for name in names]
    found = read("boxes.csv", HEAD + "".join(f"{frame},{name},9{name},3,40,90\n" for frame, name in rows))
    assert sum("are these two recordings?" in note for note in found.notes) == asked


@pytest.mark.parametrize(("first", "step"), [(17 * 10**17, 10**8), (17 * 10**11, 100), (17 * 10**8, 1)])
@pytest.mark.parametrize("suffix", ["csv", "txt"])
def test_frames_that_are_time_stamps_are_times(read, first, step, suffix):
    text = (HEAD if suffix == "csv" else "") + "".join(f"{first + n * step},1,2,3,4,50\n" for n in range(12))
    rows = read(f"boxes.{suffix}", text, dt=1.0 if step == 1 else 0.1)
    assert rows.frame.tolist() == list(range(12))
    assert rows.timeline.times[0] == 17e8


@pytest.mark.parametrize("name", ["video", "sequence", "source_id", "view"])
def test_boxes_of_two_films_are_refused(read, name):
    with pytest.raises(FileError, match=r"rows of 2 films \('a', 'b'\); write a file for each"):
        read("boxes.csv", f"{name},frame,id,left,top,width,height\na,0,1,2,3,4,50\nb,0,2,2,3,4,50\n")


@pytest.mark.parametrize(
    "text",
    [
        'frame,id,left,top,width,height\n{0},1,"12,5","3,25","40,0","90,5"\n',
        "frame id left top width height\n{0} 1 12,5 3,25 40,0 90,5\n",
        "frame;id;left;top;width;height\n{0};1;12,5;3,25;40,0;90,5\n",
        "{0} 1 13,5 4,25 40,0 90,5\n",
        "{0};1;13,5;4,25;40,0;90,5\n",
    ],
)
def test_decimal_commas_are_read_whatever_separates_cells(read, text):
    head, _, row = text.rpartition("\n{0}")
    lines = (("\n" * bool(n or head) + "{0}" + row.rstrip()).format(n + 1) for n in range(3))
    rows = read("boxes.csv", head + "".join(lines))
    assert rows.boxes.tolist() == [[12.5, 3.25, 40.0, 90.5]] * 3


def test_scores_of_one_and_zero_alone_mark_rows_that_count(read):
    lines = "".join(f"{n},{k},2,3,40,90,{k}\n" for n in range(5) for k in (0, 1))
    assert read("boxes.csv", "frame,id,left,top,width,height,conf\n" + lines).track.tolist() == [1] * 5
