"""Readers of files of boxes by their content: text, JSON, archives, folders of labels.

labels/NAME_12.txt    YOLO: ``class u v width height [score] [id]`` of frame 12, shares of the picture
*.json                COCO (images and annotations, with videos or without), COCO results, lists of records
*.zip                 one of these, such as the export of an annotation tool
"""

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.errors import FileError, quoted
from vbbench.exchange.box_tables import NOUNS, SIDES, BoxTable, box_table, read_box_text
from vbbench.exchange.sequence_files import SequenceInfo
from vbbench.exchange.text_tables import columns_of_records, decode
from vbbench.generation.archives import open_archive
from vbbench.parsing.column_names import name_columns
from vbbench.parsing.numbers import parse_number

Picture = tuple[float, float] | None
_CSV = "write CSV with columns frame,id,left,top,width,height"
_XML = "XML; export the boxes as MOT 1.1 or COCO from the annotation tool"
_UNREAD = (
    (b"\x80", f"is a Python pickle, which is not safe to read; {_CSV}"),
    (b"\x93NUMPY", f"is an array of NumPy without names of columns; {_CSV}"),
    (b"MATLAB", f"is a file of MATLAB; {_CSV}"),
    (b"\x89HDF", f"is HDF5; {_CSV}"),
    (b"SQLite", f"is a database; {_CSV}"),
    (b"\xd0\xcf\x11\xe0", "is an Excel workbook; save the sheet as CSV"),
    (b"#ROSBAG", "is a ROS bag; write bag: before its name"),
    (b"- ", f"is YAML; {_CSV}"),
    (b"<", f"is {_XML}"),
    (b"version https://git-lfs", "is a pointer of Git LFS; fetch the file itself with git lfs pull"),
    ((b"\x89PNG", b"\xff\xd8\xff"), "is a picture; name the file of its boxes"),
    (b"%PDF", "is a PDF; name the file of boxes"),
    (b"PAR1", f"is Parquet; {_CSV}"),
    (b"ARROW1", f"is Feather; {_CSV}"),
    (b"\x1f\x8b", "is packed by gzip; unpack it"),
    ((b"7z\xbc\xaf", b"Rar!"), "is a 7z or RAR archive; unpack it"),
)
"""How files begin that are not read, and what to do."""
_FRAME_KEYS = ("frame_id", "frame_index", "frame_idx", "frame_number", "frame")
_NOT_OF_PEOPLE = {"category_id", "track_id", "tracker_id"}
"""Keys next to which ``id`` numbers boxes."""
_PICTURES = (".jpg", ".jpeg", ".png", ".bmp", ".webp", ".tif", ".tiff", ".ppm")


def read_box_file(path: Path, picture: Picture = None) -> BoxTable:
    """The boxes of a file, or of a folder of labels; ``picture`` is (width, height) in px, for shares of it."""
    if folder := label_folder(path):
        return _labels(path, {file.name: file.read_bytes() for file in sorted(folder.glob("*.txt"))}, picture)
    if not path.is_file():
        raise FileError(path, "is a folder; name the file of boxes" if path.is_dir() else "the file is missing")
    if path.name.lower().endswith(".zip"):
        return _of_archive(path, picture)
    table = _of_content(path, path.read_bytes(), picture)
    labels = path.parent / "labels.txt"
    return _with_names(table, labels.read_bytes()) if labels.is_file() else table


def label_folder(path: Path) -> Path | None:
    """A folder, or its subfolder ``labels``, with a text file for each frame; ``None`` without, or with pictures."""
    if not path.is_dir() or holds_pictures(path):
        return None
    return next((one for one in (path, path / "labels") if any(one.glob("*.txt"))), None)


def holds_pictures(folder: Path) -> bool:
    """Whether a folder directly contains pictures."""
    return any(one.suffix.lower() in _PICTURES for one in folder.iterdir())


def _of_content(path: Path, content: bytes, picture: Picture) -> BoxTable:
    """The boxes of a file's ``content``; the ending of its name matters only for text."""
    if content.startswith(b"PK\x03\x04"):
        return _of_archive(path, picture)
    for begin, problem in _UNREAD:
        if content.startswith(begin):
            raise FileError(path, problem)
    text = decode(path, content)
    if text.lstrip()[:1] in (b"{", b"["):
        return _of_json(path, text, picture)
    if _is_label(text):
        raise FileError(path, "seems to be YOLO's labels of one picture; name the folder of all of them")
    return read_box_text(path, text, picture)


def _of_archive(path: Path, picture: Picture) -> BoxTable:
    with open_archive(path) as archive:
        whole = [name for name in archive.names if "__MACOSX" not in name]
        names = [name for name in whole if not name.rpartition("/")[2].startswith(".")]
        if "xl/workbook.xml" in names:
            raise FileError(path, "is an Excel workbook; save the sheet as CSV")
        lists = ("labels.txt", "obj.names", "classes.txt")
        named = next((name for name in names if name.endswith(lists)), None)
        rest = ("seqinfo.ini", "train.txt", "valid.txt", "readme.txt", *lists)
        tables = [name for name in names if name.lower().endswith((".txt", ".csv", ".tsv", ".json", ".parquet"))]
        tables = [name for name in tables if not name.lower().endswith(rest)]
        texts = [name for name in tables if name.endswith(".txt")]
        found = [name for name in tables if name.endswith("gt/gt.txt")] or tables
        if texts and (len(texts) > 1 or len(tables) == 1) and _is_label(archive.read(texts[0])):
            table = _labels(path, {name: archive.read(name) for name in texts}, picture)
        elif len(found) == 1:
            table = _of_content(path / found[0], archive.read(found[0]), picture)
        elif not found and any(name.endswith(".xml") for name in names):
            raise FileError(path, f"holds {_XML}")
        else:
            listed = ", ".join(map(quoted, (found or names)[:4]))
            what = "several tables" if found else "no table of boxes"
            raise FileError(path, f"holds {what}: {listed}; unpack it, and name the file of boxes")
        return _with_names(table, archive.read(named)) if named else table


def _with_names(table: BoxTable, content: bytes, first: int | None = None) -> BoxTable:
    """The boxes with names of classes from a list, which starts at ``first``, or at class 0 if the boxes have it."""
    first = (0 if (table.classes == 0).any() else 1) if first is None else first
    lines = content.decode("utf-8-sig", "replace").split("\n")
    names = {first + number: line.strip() for number, line in enumerate(lines) if line.strip()}
    return replace(table, class_names=names)


def _is_label(content: bytes) -> bool:
    """Whether the first line is a class and four shares, or more."""
    cells = [parse_number(cell.decode("utf-8", "replace")) for cell in content.partition(b"\n")[0].split()]
    numbers = [cell for cell in cells if cell is not None]
    return len(numbers) == len(cells) >= 5 and numbers[0].is_integer() and all(0.0 <= n <= 1.0 for n in numbers[1:5])


def _labels(path: Path, files: Mapping[str, bytes], picture: Picture) -> BoxTable:
    """YOLO's labels: a file for each frame, with the number in its name."""
    lists = [name for name in files if Path(name).name in ("classes.txt", "labels.txt")]
    rows = list[tuple[str, list[str]]]()
    for name in (name for name in files if name not in lists):
        for line, text in enumerate(files[name].decode("utf-8", "replace").split("\n"), 1):
            cells = text.split()
            if cells and not 5 <= len(cells) <= 7:
                problem = f"{len(cells)} columns, wanted class u v width height [score] [id]"
                raise FileError(path / name, f"{problem}; polygons are not read, nor keypoints", line)
            rows += [(name, cells)] if cells else []
    if not rows:
        raise FileError(path, "holds no box")
    # Of scores and ids in the sixth and seventh cells one may be missing.
    sixth = [(frame, cells[5]) for frame, cells in rows if len(cells) > 5]
    whole = all(cell.isdigit() for _, cell in sixth) and not any(len(cells) == 7 for _, cells in rows)
    rest = ("id",) if whole and len(set(sixth)) == len(sixth) else ("score", "id")
    columns = ("frame", "class", "u_norm", "v_norm", "width_norm", "height_norm", *rest)
    records = [dict(zip(columns, (frame, *cells), strict=False)) for frame, cells in rows]
    boxes = box_table(columns_of_records(path, records, NOUNS), picture, base=0)
    loose = np.array([not record.get("id") for record in records])
    if loose.any() and not loose.all():
        note = f"{int(loose.sum())} of {len(loose)} boxes are dropped: they have no id"
        boxes = replace(boxes.select(~loose), notes=(note,))
    boxes = replace(boxes, base=1)
    return _with_names(boxes, files[lists[0]], 0) if lists else boxes


def _of_json(path: Path, text: bytes, picture: Picture) -> BoxTable:
    try:
        value = json.loads(text)
    except json.JSONDecodeError:
        try:
            value = [json.loads(line) for line in text.splitlines() if line.strip()]
        except json.JSONDecodeError as error:
            raise FileError(path, f"is not JSON: {error.msg}", error.lineno) from error
    except (RecursionError, UnicodeDecodeError) as error:
        raise FileError(path, "is not JSON that can be read") from error
    if isinstance(value, dict) and {"images", "annotations"} <= value.keys():
        try:
            records, first = _coco(path, value, picture)
        except (KeyError, TypeError) as error:
            problem = f"is not whole COCO: image or key {error} is missing or of another kind"
            raise FileError(path, problem) from error
    else:
        records, first = list(_records(value, {})), 0
    if not records:
        raise FileError(path, f"holds no boxes, as lists of objects; {_CSV}, or COCO")
    table = columns_of_records(path, records, NOUNS)
    if not table.columns.keys() & {"left", "right", "u", "width"}:
        listed = quoted(", ".join(table.header.names if table.header else ()))
        problem = f"holds no boxes as objects with bbox, or left, top, width, height: {listed}"
        raise FileError(path, f"{problem}; {_CSV}, or COCO")
    return replace(box_table(table, picture, base=0), base=first)


def _records(value: Any, outer: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    """The boxes in JSON: objects in lists, with the values of enclosing objects, such as the frame."""
    if isinstance(value, list):
        for number, one in enumerate(value):  # a list in a list is a frame
            yield from _records(one, {"frame": number, **outer} if isinstance(one, list) else outer)
    elif isinstance(value, dict):
        inner = [part for part in value.values() if isinstance(part, dict)]
        lists = {k: part for one in (*inner, value) for k, part in one.items() if _are_objects(part)}
        here = {**outer, **_flat({key: part for key, part in value.items() if key not in lists})}
        numbered = bool(lists) and len(lists) == len(value) and all(re.search(r"\d", key) for key in lists)
        for key, part in lists.items():
            noun = "id" if name_columns(list(part[0]), ("frame",)).columns else "frame"
            yield from _records(part, {**here, noun: key} if numbered else here)
        if not lists and not any(part == [] for part in value.values()):
            yield {key: part for key, part in here.items() if key != "id" or not here.keys() & _NOT_OF_PEOPLE}


def _are_objects(part: Any) -> bool:
    return isinstance(part, list) and bool(part) and all(isinstance(one, dict) for one in part)


def _flat(value: Mapping[str, Any]) -> dict[str, Any]:
    """The numbers and words of an object and of nested ones, with the four numbers of a box under separate names."""
    flat = dict[str, Any]()
    for key, part in value.items():
        names = next((sides for keys, sides in SIDES.items() if key.lower() in keys.split()), None)
        if names and isinstance(part, list) and len(part) == len(names):
            flat |= dict(zip(names, part, strict=True))
        elif isinstance(part, dict):
            flat |= {name if key == "attributes" else f"{key}.{name}": one for name, one in _flat(part).items()}
        elif isinstance(part, str | int | float) or (isinstance(part, list) and [*map(type, part)] == [str]):
            flat[key] = part[0] if isinstance(part, list) else part
    return flat


def _coco(path: Path, value: Mapping[str, Any], picture: Picture) -> tuple[list[dict[str, Any]], int]:
    """The annotations of COCO or CocoVid, each with its frame and class name; and the number of the first frame.

    Raises KeyError or TypeError where something is missing or of another kind.
    """
    images = {image["id"]: image for image in value["images"]}
    used = [images[one["image_id"]] for one in value["annotations"]]
    names = {one["id"]: one["name"] for one in value.get("categories", ())}
    videos = {one["id"]: str(one.get("name", one["id"])) for one in value.get("videos", ())}
    sizes = {(image.get("width"), image.get("height")) for image in used} - {(None, None), (0, 0)}
    if picture and sizes and not any(wide == picture[0] and picture[1] in (high, np.inf) for wide, high in sizes):
        SequenceInfo(path, size=min(sizes, key=str)).refuse_other("the given camera's", picture)
    films = {image["id"]: videos.get(one := image.get("video_id"), one) for image in used}
    frames = {image["id"]: _frame_of(image) for image in used}
    if len(set(frames.values())) < len(frames) and len(set(films.values())) == 1:
        raise FileError(path, "several of its images have one frame number; write a file for each film")
    records = []
    for one in value["annotations"]:
        record = _flat({key: part for key, part in one.items() if key not in ("id", "image_id", "category_id")})
        if "track_id" in record:
            record.pop("instance_id", None)
        kind = one.get("category_id")
        of_class = {"class_name": names[kind]} if kind in names else {"class": kind}
        records.append({**record, **of_class, "frame": frames[one["image_id"]], "video": films[one["image_id"]]})
    first = min((frame for frame in map(_frame_of, images.values()) if isinstance(frame, int)), default=0)
    return records, min(max(first, 0), 1)


def _frame_of(image: Mapping[str, Any]) -> Any:
    return next((image[key] for key in _FRAME_KEYS if key in image), image.get("file_name", image["id"]))
