"""Files of boxes as trackers, detectors and annotation tools write them."""

import json
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.exchange.conftest import PICTURE
from vbbench.birdify.birdify import is_film
from vbbench.errors import FileError
from vbbench.exchange.box_rows import OwnBoxes, read_boxes, write_boxes
from vbbench.exchange.own.recording import boxes_in

FRAMES = range(6)
Read = Callable[..., OwnBoxes]


def packed(path: Path, files: dict[str, str]) -> Path:
    with zipfile.ZipFile(path, "w") as archive:
        for name, text in files.items():
            archive.writestr(name, text)
    return path


def test_sinks_of_supervision_are_read(tmp_path: Path) -> None:
    sv = pytest.importorskip("supervision")
    found = sv.Detections(
        xyxy=np.array([[10.0, 20.0, 30.0, 60.0], [50.0, 60.0, 70.0, 80.0]]),
        confidence=np.array([0.75, 0.5]),
        class_id=np.array([0, 1]),
        tracker_id=np.array([7, 9]),
        data={"class_name": np.array(["person", "bicycle"])},
    )
    for sink, name in ((sv.CSVSink, "a.csv"), (sv.JSONSink, "a.json")):
        with sink(str(tmp_path / name)) as file:
            for frame in FRAMES:
                file.append(found, custom_data={"frame_index": frame})
        rows = read_boxes(tmp_path / name, 0.1)
        assert rows.track.tolist() == [7] * len(FRAMES)
        assert rows.boxes[0].tolist() == [10.0, 20.0, 20.0, 40.0]
        assert rows.scores[0] == 0.75
        assert "6 of class bicycle (people are class person)" in rows.notes[0]


@pytest.mark.parametrize(
    ("row", "kept", "scores", "visible"),
    [
        ("{0} {1} 11 21 20 40 0 0 -1", 2, np.nan, np.nan),  # boxmot 10, whose scores are cut to whole numbers
        ("{0},{1},11,21,20,40,0.5,1,{2}", 2, 0.5, np.nan),  # boxmot 18: classes from 1, the number of the detection
        ("{0},{1},11,21,20,40,1,0,0.75", 2, 1.0, 0.75),  # boxmot 11: counts, class, score
        ("{0} {1} 11 21 20 40 -1 -1 -1 0 ", 2, np.nan, np.nan),  # Yolov5_StrongSORT
        ("{0},{1},11,21,20,40,0.5,-1,-1,-1", 2, 0.5, np.nan),  # ByteTrack
        ("{0},{1},11,21,20,40,0.5,0,-1,-1", 2, 0.5, np.nan),  # a class of COCO among ten columns
        ("{0},{1},11,21,20,40,1,{1},0,{2}", 1, 1.0, np.nan),  # VisDrone: class, truncated, occluded
        ("{0},{1},11,21,20,40,{2},-1.5,8.25,0.5", 1, 1.0, np.nan),  # ground truth of 2D MOT15
        ("{0},{1},11,21,20,40,1,{1},0.25", 1, 1.0, 0.25),  # ground truth of MOT16
        ("{0},{1},11,21,20,40,1,0,0,0", 2, 1.0, np.nan),
        ("{0},{1},11,21,20,40,1,1,{2}", 2, 1.0, np.nan),  # occluded or not
        ("{0},{1},11,21,20,40,{2}{2},0.75", 1, 0.75, np.nan),  # class, score
        ("{0},{1},11,21,20,40,{2}{2},0.75,-1,-1", 1, 0.75, np.nan),
    ],
)
def test_the_last_columns_mean_what_the_whole_file_shows(
    read: Read, row: str, kept: int, scores: float, visible: float
) -> None:
    rows = read("tracks.txt", "".join(f"{row.format(1 + n, 1 + k, k)}\n" for n in FRAMES for k in (1, 0)))
    assert len(rows.frame) == kept * len(FRAMES)
    assert rows.boxes[0].tolist() == [10.0, 20.0, 20.0, 40.0]
    np.testing.assert_equal(rows.scores[0], scores)
    np.testing.assert_equal(rows.visible[0], visible)


def test_columns_that_could_be_class_or_mark_are_refused(read: Read) -> None:
    with pytest.raises(FileError, match="could be class and score, or a mark of rows that count and a visibility"):
        read("tracks.txt", "".join(f"{1 + n},{1 + k},11,21,20,40,{k},0.75\n" for n in FRAMES for k in (1, 0)))


@pytest.mark.parametrize("third", ["0", "0.75"])
def test_a_class_or_score_is_no_left(read: Read, third: str) -> None:
    with pytest.raises(FileError, match=r"left would be 0.* in all 12 boxes: is it a (class|score)"):
        read("tracks.txt", "".join(f"{n},{k},{third},11.5,21,31,61\n" for n in FRAMES for k in (1, 2)))


def classes(counts: dict[Any, int], column: str = "class") -> str:
    lines = [f"frame,id,left,top,width,height,{column}"]
    kinds = [kind for kind, count in counts.items() for _ in range(count)]
    lines += [f"{frame},{k},10,20,20,40,{kind}" for frame in FRAMES for k, kind in enumerate(kinds)]
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize(
    ("counts", "kept"),
    [
        ({0: 4, 1: 1, 2: 3}, 4),
        ({0: 1}, 1),
        ({1: 2, 7: 3}, 2),
        ({"Person": 2, "car": 5}, 2),
        ({"human.pedestrian.adult": 1, "car": 1}, 1),
    ],
)
def test_people_are_of_the_class_that_the_file_shows(read: Read, counts: dict[Any, int], kept: int) -> None:
    rows = read("boxes.csv", classes(counts))
    assert len(rows.frame) == kept * len(FRAMES)
    assert len(rows.notes) == (len(counts) > 1)


@pytest.mark.parametrize("counts", [{0: 2, 1: 2}, {2: 3}, {"car": 1, "bus": 2}])
def test_classes_that_do_not_show_people_are_counted_and_refused(read: Read, counts: dict[Any, int]) -> None:
    with pytest.raises(FileError, match=r"12 of class .*`person_class`" if len(counts) > 1 else "18 of class 2"):
        read("boxes.csv", classes(counts))
    chosen = next(iter(counts))
    rows = read("boxes.csv", classes(counts), person_class=chosen)
    assert len(rows.frame) == counts[chosen] * len(FRAMES)
    with pytest.raises(FileError, match="no box of class 99; it has"):
        read("boxes.csv", classes(counts), person_class="99")


@pytest.mark.parametrize(
    ("head", "row"),
    [
        ("frame_idx;track_id;x_center;y_center;w;h", "{0};5;20,0;40,0;20;40"),
        ("Frame\tID\tLeft\tTop\tRight\tBottom", "{0}\t5\t10\t20\t30\t60"),
        ("image,person_id,bb_left,bb_top,bb_width,bb_height", "img/{0:06d}.jpg,5,10,20,20,40"),
        ("filename,width,height,track,xmin,ymin,xmax,ymax", "f{0}.png,1280,720,5,10,20,30,60"),
        ("frame,id,x_center_norm,y_center_norm,width_norm,height_norm", "{0},5,0.015625,0.0555556,0.015625,0.0555556"),
        ("timestamp_ms,id,u,v,width,l", "{0}00,5,20,40,20,40"),
        ("frame,timestamp,id,x,y,w,h", "{0},{0}.5,5,10,20,20,40"),
        ("# frame id x1 y1 x2 y2", "{0} 5 10 20 30 60"),
        (
            "frame_num,object_id,rect_params.left,rect_params.top,rect_params.width,rect_params.height",
            "{0},5,10,20,20,40",
        ),
        ("frame,id,left,top,width,height,outside", "{0},5,10,20,20,40,False"),
        ("frame,track_id,bbox,conf", '{0},5,"[10, 20, 20, 40.0]",0.5'),
        ("frame,track_id,conf,xyxy", "{0},5,0.5,[10.  20.  30.  60.]"),
    ],
)
def test_columns_are_found_by_their_names(read: Read, head: str, row: str) -> None:
    rows = read("boxes.csv", f"{head}\n" + "".join(f"{row.format(frame)}\n" for frame in FRAMES))
    assert rows.frame.tolist() == list(FRAMES)
    assert rows.track.tolist() == [5] * len(FRAMES)
    np.testing.assert_allclose(rows.boxes, [[10.0, 20.0, 20.0, 40.0]] * len(FRAMES), atol=1e-3)


def test_a_header_in_txt_counts_from_one(read: Read) -> None:
    rows = read("tracks.txt", "id,frame,h,w,y,x\n" + "".join(f"5,{1 + n},40,20,21,11\n" for n in FRAMES))
    assert rows.boxes[0].tolist() == [10.0, 20.0, 20.0, 40.0]
    assert rows.timeline.times[0] == 0.0


def test_utf_16_is_read(read: Read) -> None:
    text = "frame,id,left,top,width,height\r\n" + "".join(f"{n},5,10,20,20,40\r\n" for n in FRAMES)
    assert read("boxes.csv", text.encode("utf-16")).boxes[0].tolist() == [10.0, 20.0, 20.0, 40.0]


@pytest.mark.parametrize("ids", [(2**60 + 1, 2**60 + 2), (2**64 - 2, 2**64 - 1), ("a3-f2", "b1-9c")])
def test_ids_of_64_bits_and_texts_are_kept(read: Read, tmp_path: Path, ids: tuple[Any, Any]) -> None:
    head = "frame,track_id,left,top,width,height\n"
    rows = read("boxes.csv", head + "".join(f"{n},{one},10,20,20,40\n" for n in FRAMES for one in ids))
    assert set(rows.track.tolist()) == {1, 2}
    assert [str(one) for one in rows.ids.of(rows.track[:2])] == [str(one) for one in ids]
    assert "numbered 1 to 2" in rows.notes[0]
    write_boxes(tmp_path / "again.csv", rows)
    again = read_boxes(tmp_path / "again.csv", 0.1)
    np.testing.assert_array_equal(again.boxes, rows.boxes)
    np.testing.assert_array_equal(again.ids.of(again.track), rows.ids.of(rows.track))
    with pytest.raises(FileError, match="digits are lost"):
        read("boxes.csv", head + "".join(f"{n},9.1e18,10,20,20,40\n" for n in FRAMES))


def test_numbers_of_boxes_are_no_ids(read: Read) -> None:
    text = "frame,id,left,top,width,height\n" + "".join(f"{n // 2},{n},10,20,20,40\n" for n in range(12))
    with pytest.raises(FileError, match="no id occurs in two of 12 boxes"):
        read("boxes.csv", text)


def test_a_folder_of_motchallenge_has_boxes(tmp_path: Path) -> None:
    assert is_film(tmp_path)
    for name in ("det/det.txt", "gt/gt.txt"):
        (tmp_path / name).parent.mkdir()
        (tmp_path / name).write_text("1,1,1,1,5,9,1,-1,-1,-1\n")
        assert not is_film(tmp_path)
        assert boxes_in(tmp_path) == tmp_path / name
    (tmp_path / "1.png").write_bytes(b"")
    assert is_film(tmp_path)


def labels(folder: Path, cells: Callable[[int, int], str], count: int = 2) -> Path:
    folder.mkdir()
    for n in FRAMES:
        text = "".join(f"0 0.5 0.5 0.1 0.2{cells(n, k)}\n" for k in range(count)) + "2 0.5 0.5 0.1 0.2" + cells(n, 9)
        (folder / f"film_{1 + n}.txt").write_text(text + "\n")
    return folder


@pytest.mark.parametrize(
    ("cells", "linked", "score"),
    [
        (lambda n, k: "", False, np.nan),
        (lambda n, k: f" {k + 1}", True, np.nan),
        (lambda n, k: " 0.25", False, 0.25),
        (lambda n, k: f" 0.25 {k + 1}", True, 0.25),
        (lambda n, k: " 1", False, 1.0),
    ],
)
def test_label_folders_are_read(tmp_path: Path, cells: Callable[[int, int], str], linked: bool, score: float) -> None:
    folder = labels(tmp_path / "labels", cells)
    assert not is_film(folder)
    rows = read_boxes(folder, 0.1, picture=PICTURE)
    assert rows.linked == linked
    assert rows.timeline.first_number == 1
    np.testing.assert_allclose(rows.boxes[0], [576.0, 288.0, 128.0, 144.0])
    np.testing.assert_equal(rows.scores[0], score)
    assert "6 of class 2 (people are class 0)" in rows.notes[0]
    (folder / "film_1.jpg").write_bytes(b"")
    assert is_film(folder)


def test_labels_without_an_id_among_others_are_left_out(tmp_path: Path) -> None:
    rows = read_boxes(labels(tmp_path / "a", lambda n, k: "" if n == 2 else f" {k}"), 0.1, picture=PICTURE)
    assert "3 of 18 boxes are dropped: they have no id" in rows.notes[0]
    assert len(rows.frame) == 10


@pytest.mark.parametrize("first", ["nan", "inf", "0.5"])
def test_a_first_line_that_is_no_class_and_shares_is_no_label(read: Read, first: str) -> None:
    with pytest.raises(FileError, match="line 1: 5 columns with blanks between, wanted 6"):
        read("boxes.txt", f"{first} 0.5 0.5 0.1 0.2\n")


def test_polygons_and_a_label_alone_are_refused(tmp_path: Path) -> None:
    folder = labels(tmp_path / "a", lambda n, k: " 0.5 0.5 0.6 0.6")
    with pytest.raises(FileError, match="polygons are not read"):
        read_boxes(folder, 0.1, picture=PICTURE)
    with pytest.raises(FileError, match="name the folder"):
        read_boxes(folder / "film_1.txt", 0.1, picture=PICTURE)


def coco(**more: Any) -> dict[str, Any]:
    return {
        "images": [{"id": 10 + n, "file_name": f"{n:06d}.jpg", "width": 1280, "height": 720} for n in FRAMES],
        "categories": [{"id": 1, "name": "car"}, {"id": 2, "name": "person"}],
        "annotations": [
            {"id": 9 * n + k, "image_id": 10 + n, "category_id": 1 + (k < 2), "bbox": [10, 20, 20, 40], "iscrowd": 0}
            | {"attributes": {"track_id": k, "occluded": False}}
            for n in FRAMES
            for k in range(3)
        ],
        **more,
    }


BOX = {"track_id": 5, "xyxy": [10, 20, 30, 60]}


@pytest.mark.parametrize(
    "value",
    [
        coco(),
        [{"image_id": n, "id": n, "category_id": 1, "bbox": [10, 20, 20, 40], "score": 0.5} for n in FRAMES],
        {"frames": [{"frame": n, "objects": [BOX]} for n in FRAMES]},
        {f"{n:06d}.jpg": [BOX] for n in FRAMES},
        [[BOX] for n in FRAMES],
        [{"frame": n, "name": "person", "class": 0, "box": {"x1": 10, "y1": 20, "x2": 30, "y2": 60}} for n in FRAMES],
    ],
)
def test_json_is_read(read: Read, value: Any) -> None:
    rows = read("boxes.json", json.dumps(value))
    assert rows.timeline.frames == len(FRAMES)
    np.testing.assert_array_equal(rows.boxes, [[10.0, 20.0, 20.0, 40.0]] * len(rows.boxes))


def test_json_of_one_object_a_line_is_read(read: Read) -> None:
    assert len(read("a.jsonl", "\n".join(json.dumps({"frame": n, **BOX}) for n in FRAMES)).frame) == len(FRAMES)


def test_frames_of_coco_count_as_its_images_do(read: Read) -> None:
    images = [{"id": n, "frame_id": n + 1} for n in FRAMES]
    boxes = [{"image_id": n, "category_id": 1, "bbox": [10, 20, 20, 40], "track_id": 5} for n in FRAMES if n]
    rows = read("a.json", json.dumps({"images": images, "annotations": boxes}))
    np.testing.assert_allclose(rows.timeline.times, [0.1, 0.2, 0.3, 0.4, 0.5])


@pytest.mark.parametrize("name", ["cam0/{0}.{1:06d}.png", "{0}{1:06d}000.png"])
def test_pictures_named_by_their_time_are_timed(read: Read, name: str) -> None:
    lines = [f"{name.format(1700000000, 100000 * n)},5,10,20,20,40\n" for n in FRAMES]
    rows = read("a.csv", "image,id,left,top,width,height\n" + "".join(lines))
    np.testing.assert_allclose(rows.timeline.times, 1.7e9 + 0.1 * np.arange(len(FRAMES)), rtol=0, atol=1e-6)


@pytest.mark.parametrize("people", [0, 1])
def test_names_of_classes_count_as_classes_do(read: Read, tmp_path: Path, people: int) -> None:
    (tmp_path / "labels.txt").write_text("person\nbicycle\n")
    rows = read("t.txt", "".join(f"{1 + n},{k},11,21,20,40,.9,{k}\n" for n in FRAMES for k in (people, people + 1)))
    assert np.unique(rows.track).tolist() == [people]


def test_several_films_in_one_file_are_named(read: Read) -> None:
    value = coco(videos=[{"id": 1, "name": "north"}, {"id": 2, "name": "south"}])
    for image in value["images"]:
        image["video_id"] = 1 + image["id"] % 2
    with pytest.raises(FileError, match="holds rows of 2 films \\('north', 'south'\\)"):
        read("boxes.json", json.dumps(value))
    head = "image,id,left,top,width,height\n"
    with pytest.raises(FileError, match=r"'a/1\.jpg' and 'b/1\.jpg' have one number"):
        read("boxes.csv", head + "a/1.jpg,1,10,20,20,40\nb/1.jpg,1,10,20,20,40\n")


def test_archives_of_annotation_tools_are_read(tmp_path: Path) -> None:
    gt = "".join(f"{1 + n},{k},11,21,20,40,1,{k},1\n" for n in FRAMES for k in (1, 2))
    cvat = packed(tmp_path / "cvat.zip", {"gt/gt.txt": gt, "gt/labels.txt": "car\nperson\n"})
    rows = read_boxes(cvat, 0.1, picture=PICTURE)
    assert rows.track.tolist() == [2] * len(FRAMES)
    yolo = {f"obj_train_data/frame_{n:06d}.txt": "0 .5 .5 .1 .2\n1 .5 .5 .1 .2\n" for n in FRAMES}
    rows = read_boxes(packed(tmp_path / "yolo.zip", {"obj.names": "car\nperson\n", **yolo}), 0.1, picture=PICTURE)
    assert len(rows.frame) == len(FRAMES)
    made = packed(tmp_path / "coco.zip", {"annotations/instances_default.json": json.dumps(coco())})
    assert len(read_boxes(made, 0.1).frame) == 2 * len(FRAMES)
    with pytest.raises(FileError, match=r"holds several tables: 'a\.csv', 'b\.csv'"):
        read_boxes(packed(tmp_path / "two.zip", {"a.csv": "", "b.csv": ""}), 0.1)
    with pytest.raises(FileError, match="holds XML; export the boxes as MOT"):
        read_boxes(packed(tmp_path / "xml.zip", {"annotations.xml": ""}), 0.1)
    with pytest.raises(FileError, match="is an Excel workbook; save the sheet as CSV"):
        read_boxes(packed(tmp_path / "table.xlsx", {"xl/workbook.xml": ""}), 0.1)


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (b"\x80\x04\x95", "a Python pickle"),
        (b"PAR1", "is Parquet; write CSV"),
        (b"version https://git-lfs.github.com/spec/v1", "is a pointer of Git LFS; fetch the file itself"),
        (b"\x93NUMPY\x01", "an array of NumPy"),
        (b"<?xml version='1.0'?>", "is XML; export"),
        (b"\xd0\xcf\x11\xe0", "an Excel workbook"),
        (b"f\0r\0a\0m\0e\0", "UTF-16 without its mark"),
        (b"{nope", "is not JSON"),
        (b'{"images": [{"id": 1}], "annotations": [{"image_id": 1, "category_id": [1]}]}', "is not whole COCO"),
        (b"", "holds no box"),
        (b"frame,id,x1,y1,x2,y2\n0,1,500,200,40,90\n", "right is 40 and left 500; is it the width"),
        (b"frame,id,left_norm,top_norm,width_norm,height_norm\n0,1,500,200,40,90\n", "says that it is a share"),
        (b"frame,id,class,left,top,width,height\n0,1,0,1,1,5,5\n0,2,car,1,1,5,5\n", "class is 'car'; write a number"),
    ],
)
def test_what_is_not_read_is_named(read: Read, content: bytes, problem: str) -> None:
    with pytest.raises(FileError, match=problem):
        read("boxes.csv", content)


KITTI = "{frame} {track} {kind} 0 0 -1.5 10 20 40 110 1.7 0.6 0.8 1 1.5 10 -1.5"
DRONES = '{track} 10 20 40 110 {frame} {lost} 0 1 "{kind}"'
LABELLED = [(3, "Pedestrian", 0), (4, "Car", 0), (-1, "DontCare", 1)]


@pytest.mark.parametrize("form", [KITTI, f"{KITTI} 0.9", DRONES])
def test_text_of_kittis_tracks_and_of_stanfords_drones_is_read(read: Read, form: str) -> None:
    rows = [form.format(frame=t, track=i, kind=kind, lost=lost) for t in FRAMES for i, kind, lost in LABELLED]
    found = read("0000.txt", "\n".join(rows) + "\n")
    assert found.track.tolist() == [3] * len(FRAMES)
    assert found.frame.tolist() == list(FRAMES)
    assert found.boxes[0].tolist() == [10.0, 20.0, 30.0, 90.0]


HASHES = [f"{0x1F3A9 + 7919 * t:x}{t * 31 % 97}" for t in FRAMES]


@pytest.mark.parametrize("name", ["walk_mp4-{:04d}_jpg.rf.{}.jpg", "walk_{:04d}_1280x720.png"])
def test_numbers_that_follow_the_frame_in_names_of_pictures_are_none(read: Read, name: str) -> None:
    rows = "".join(f"{name.format(t, HASHES[t])},7,10,20,40,110\n" for t in FRAMES)
    assert read("boxes.csv", "image,id,xmin,ymin,xmax,ymax\n" + rows).frame.tolist() == list(FRAMES)


BOX = {"x1": 10.0, "y1": 20.0, "x2": 40.0, "y2": 110.0}
NESTED: dict[str, Any] = {
    "tracks by their ids": {"7": [{"frame": t, "bbox": [10, 20, 30, 90]} for t in FRAMES]},
    "AlphaPose": [{"image_id": f"{t}.jpg", "category_id": 1, "box": [10, 20, 30, 90], "idx": 7} for t in FRAMES],
    "BDD100K": [
        {"name": f"v-{t}.jpg", "frameIndex": t, "labels": [{"id": "7", "category": "pedestrian", "box2d": BOX}]}
        for t in FRAMES
    ],
    "Datumaro": {
        "items": [
            {
                "id": f"frame_{t:06d}",
                "image": {"path": f"frame_{t:06d}.png"},
                "annotations": [
                    {"id": 0, "type": "bbox", "label_id": 0, "attributes": {"track_id": 7}, "bbox": [10, 20, 30, 90]}
                ],
            }
            for t in FRAMES
        ]
    },
    "in objects": [{"value": {"sequence": [{"frame": t, **BOX, "id": 7} for t in FRAMES]}}],
}


@pytest.mark.parametrize("name", NESTED)
def test_ids_and_frames_around_boxes_are_kept(read: Read, name: str) -> None:
    found = read("boxes.json", json.dumps(NESTED[name]))
    assert found.ids.of(found.track).astype(int).tolist() == [7] * len(FRAMES)
    assert found.frame.tolist() == list(FRAMES)
    assert found.boxes[0].tolist() == [10.0, 20.0, 30.0, 90.0]


def test_shares_of_darknet_are_read(read: Read) -> None:
    middle = {"center_x": 0.5, "center_y": 0.25, "width": 0.1, "height": 0.5}
    frames = [{"frame_id": t, "objects": [{"class_id": 0, "relative_coordinates": middle}]} for t in FRAMES]
    np.testing.assert_allclose(read("result.json", json.dumps(frames)).boxes[0], [576.0, 0.0, 128.0, 360.0])


@pytest.mark.parametrize("value", [{"a": [[1, 2]]}, [{"frame_id": 0, "bboxes": [[1, 2, 3, 4]]}]])
def test_json_without_boxes_of_objects_says_what_to_write(read: Read, value: Any) -> None:
    with pytest.raises(FileError, match=r"no boxes as objects with bbox.*write CSV"):
        read("boxes.json", json.dumps(value))


def test_a_label_in_a_list_is_the_class(read: Read) -> None:
    box = {"type": "rectangle", "labels": ["Person"], "x": 100, "y": 90, "width": 40, "height": 90}
    values = [{"id": 4, "sequence": [{**box, "frame": frame} for frame in FRAMES]}]
    rows = read("studio.json", json.dumps(values))
    assert rows.boxes[0].tolist() == [100.0, 90.0, 40.0, 90.0]


def test_boxes_of_ultralytics_are_dicts_in_a_cell(read: Read) -> None:
    box = "\"{'x1': 100.5, 'y1': 90.0, 'x2': 140.5, 'y2': 180.0}\""
    rows = read(
        "df.csv", "frame,name,class,confidence,box,track_id\n" + f"0,person,0,0.9,{box},4\n1,person,0,0.9,{box},4\n"
    )
    assert rows.boxes.tolist() == [[100.5, 90.0, 40.0, 90.0]] * 2


def test_images_of_coco_have_the_cameras_size(read: Read) -> None:
    def coco(width: int, height: int) -> str:
        images = [{"id": frame, "file_name": f"{frame}.jpg", "width": width, "height": height} for frame in FRAMES]
        boxes = [{"id": frame, "image_id": frame, "bbox": [100, 90, 40, 90], "track_id": 1} for frame in FRAMES]
        return json.dumps({"images": images, "annotations": boxes, "categories": []})

    assert len(read("whole.json", coco(1280, 720))) == len(FRAMES)
    with pytest.raises(FileError, match=r"its pictures have 640 x 360 px, the given camera's 1280 x 720; write those"):
        read("half.json", coco(640, 360))
