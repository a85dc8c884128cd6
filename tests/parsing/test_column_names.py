"""Names of columns as detectors, trackers and data sets write them."""

import pytest

from vbbench.parsing.column_names import header_of, name_columns, split_cells

BOX = ("frame", "time", "id", "left", "top", "right", "bottom", "u", "v", "width", "height", "class", "class_name")
BOX = (*BOX, "score", "visible", "ignored")
PLACE = ("frame", "time", "id", "x", "y", "z", "qw", "height")


@pytest.mark.parametrize(
    ("line", "nouns", "wanted"),
    [
        (
            "x_min,y_min,x_max,y_max,class_id,confidence,tracker_id,frame_index",
            BOX,
            "left top right bottom class score id frame",
        ),
        ("<frame>, <id>, <bb_left>, <bb_top>, <bb_width>, <bb_height>, <conf>, <x>, <y>, <z>", BOX, None),
        ("Frame Number;Object ID;Bounding Box Left;Top;Width (px);Height", BOX, "frame id left top width height"),
        (
            "name,class,confidence,box.x1,box.y1,box.x2,box.y2,track_id",
            BOX,
            "class_name class score left top right bottom id",
        ),
        ("frame_idx x y w h conf", BOX, "frame left top width height score"),
        ("frame\ttime\tid\tu\tv\tl", BOX, "frame time id u v height"),
        ("frame,id,l,t,r,b", BOX, "frame id left top right bottom"),
        ("frame,id,x0,y0,x1,y1", BOX, "frame id left top right bottom"),
        ("frame,id,x1n,y1n,x2n,y2n", BOX, "frame id left top right bottom"),
        ("image,person_id,xc,yc,w,h", BOX, "frame id u v width height"),
        ("#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w []", PLACE, "time x y z qw"),
        ("# id frame x/m y/m", PLACE, "id frame x y"),
    ],
)
def test_usual_names_are_found(line: str, nouns: tuple[str, ...], wanted: str | None) -> None:
    header = header_of(line, nouns)
    assert header is not None
    assert not header.doubtful
    wanted = wanted or "frame id left top width height score"
    assert {noun: header.columns[noun] for noun in wanted.split()} == {
        noun: column for column, noun in enumerate(wanted.split())
    }
    assert len(header.columns) == len(wanted.split())


def test_numbers_name_nothing() -> None:
    assert not name_columns(split_cells("1,2,3,4,5,6,7"), BOX).columns
    assert not name_columns(split_cells("# made on Monday"), BOX).columns


def test_units_stand_with_names() -> None:
    header = name_columns(["timestamp_ms", "x_center_norm", "y1n", "yaw/deg", "confidence [%]"], ("time", "u", "top"))
    assert dict(header.units) == {"time": "ms", "u": "norm", "top": "n"}
    assert header.ignored == ("yaw/deg", "confidence [%]")
    assert name_columns(["yaw/deg", "confidence [%]"], ("yaw", "score")).units == {"yaw": "deg", "score": "%"}


def test_columns_that_mean_the_same_are_doubtful() -> None:
    header = name_columns(["frame", "id", "track_id", "left", "left"], BOX)
    assert header.doubtful == {"id": ("id", "track_id"), "left": ("left", "left")}


def test_the_surer_name_counts() -> None:
    header = name_columns(["image", "frame", "x", "x_min", "x_min_norm"], BOX)
    assert (header.columns["frame"], header.columns["left"], header.doubtful) == (1, 3, {})


def test_estimated_places_are_places() -> None:
    header = header_of("time,id,x_est,y_est", ("time", "id", "x", "y"))
    assert header is not None
    assert header.columns == {"time": 0, "id": 1, "x": 2, "y": 3}
