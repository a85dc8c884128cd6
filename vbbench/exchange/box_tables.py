"""Boxes in files, with any names of columns and any parametrisation of a box, read by the files' content.

A box is given by its left, top, width and height, by two corners, by its middle and size, or by the middle and height
alone; in px, or, by the names, in shares of the picture. Without names columns are in MOTChallenge's order,
``frame,id,left,top,width,height[,conf,class,visibility]`` or ``…,conf,x,y,z``; id −1 is not linked.

labels/NAME_12.txt    YOLO: ``class u v width height [score] [id]`` of frame 12, shares of the picture
*.json                COCO (images and annotations, with videos or without), COCO results, lists of records
*.zip                 one of these, such as the export of an annotation tool
"""

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vbbench.boxes import rectangles
from vbbench.errors import FileError, quoted
from vbbench.exchange.sequence_files import SequenceInfo
from vbbench.exchange.text_tables import Layout, NamedColumns, columns_of_records, decode, read_table, refuse_missing
from vbbench.generation.archives import open_archive
from vbbench.geometry import BoolArray, FloatArray
from vbbench.parsing.column_names import SHARES, UNITS, name_columns, separator_of, split_cells
from vbbench.parsing.numbers import parse_number

Picture = tuple[float, float] | None
"""Width and height of a picture in px, for boxes that are shares of it; ``None`` if they are not known."""
PEOPLE = frozenset(
    ("person", "persons", "people", "pedestrian", "pedestrians", "ped", "human", "humans", "man", "woman", "child")
)
"""Names of classes of people."""
RIVAL = 0.5
"""Boxes of class 1 per box of class 0 from which 0 need not be people, as it is in COCO."""
UNLINKED = -1
"""Track of an unlinked detection; class, which then counts as a person, and visibility if they are unknown."""
NOUNS = (
    *("frame", "time", "id", "film", "left", "top", "right", "bottom", "u", "v", "width", "height"),
    *("class", "class_name", "score", "visible", "ignored"),
)
"""What columns of boxes may be."""
MOT = "frame id left top width height [score:conf class visible:visibility last]"
"""Columns of MOTChallenge text."""
_WORDED = (
    "frame id class truncated occluded alpha left top right bottom h w l x y z rotation",
    "frame id class truncated occluded alpha left top right bottom h w l x y z rotation score",
    "id left top right bottom frame ignored occluded generated class",
)
"""Columns of text in which classes are words: KITTI's tracks, without scores or with, and Stanford's drones."""
SIDES = {
    "bbox tlwh ltwh box bb": ("left", "top", "width", "height"),
    "xyxy tlbr ltrb bbox_xyxy": ("left", "top", "right", "bottom"),
}
"""What four numbers in one column or list are, by its names."""
_FOUR = re.compile(rb"[\"']?[\[(]" + rb"[\s,]+".join([rb"\s*([-+.\deE]+)"] * 4) + rb"\s*[\])][\"']?")
_KEYED = re.compile(rb"\{" + rb", ".join(b"'%s': ([^,}]+)" % name for name in (b"x1", b"y1", b"x2", b"y2")) + rb"\}")
_SIDES = ("left", "right", "u", "width"), ("top", "bottom", "v", "height")
_SIZES = ("left", "top", "width", "height")
FEWEST_HIDDEN = 10
"""Where most of so many boxes have visibility 0, and others 1, it is not known; as many show their third column."""
LEAST_STAMP = 1e9
"""Numbers of frames and pictures from this one on are time stamps, in s, ms, us or ns since 1970."""
FEW_CLASSES, LAST_CLASS = 5, 100.0
"""As few whole numbers, up to this, are of a class."""
_DIGITS, _ENDING = re.compile(r"\d+"), re.compile(r"(\.rf\.\w+)?\.\w*$")
_LOOKED_AT = 5000
"""Rows of which it is looked at whether classes are numbers."""
LEAST_PER_CENT = 10.0
"""Scores of which one is above it are per cent; others above 1 are of a detector that is sure."""


@dataclass(frozen=True, kw_only=True)
class BoxTable(NamedColumns):
    """Boxes of a file before selection, one a row.

    Parameters
    ----------
    frame : [N] numbers of frames, or time stamps in s where ``timed``.
    boxes : [N, 4] (left, top, width, height) in px from 0.
    id : [N] whole numbers, `UNLINKED` for none, or texts.
    classes : [N] numbers or names; `UNLINKED` or empty for none.
    scores, visible : [N], NaN where the file has none; visible as a share.
    ignored : [N] mask of rows that the file marks as ignored.
    base : number of a film's first frame in the file.
    class_names : names of class numbers, if the file has them.
    """

    frame: FloatArray
    boxes: FloatArray
    id: NDArray[Any]
    classes: NDArray[Any]
    scores: FloatArray
    visible: FloatArray
    ignored: BoolArray
    base: int
    timed: bool
    class_names: Mapping[int, str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


def read_box_text(path: Path, content: bytes, picture: Picture = None, layout: Layout = MOT) -> BoxTable:
    """The boxes of a text; ``picture`` is (width, height) in px, for shares; ``layout`` is that of rows without names.

    Frames and px of CSV with a header count from 0, of any other text from 1.
    """

    def layout_of(cells: list[str]) -> Layout:
        worded = [place for place, cell in enumerate(cells) if parse_number(cell) is None]
        known = ((names, names.index("class")) for names in map(str.split, _WORDED) if len(names) == len(cells))
        one = next((names for names, place in known if worded == [place]), [])
        if not one and worded and worded[-1] > 5 and cells[worded[-1]]:
            problem = f"its first line has {quoted(cells[worded[-1]])} in column {worded[-1] + 1}"
            raise ValueError(f"{problem}; write what its columns are above it, such as frame,id,left,top,width,height")
        return " ".join(name if name in NOUNS else f"({name})" for name in one) or layout

    table = read_table(path, _four_columns(content), NOUNS, layout=layout_of, required=_SIZES)
    if table.header is None and "right" not in table:
        found = box_table(_mot_columns(table), picture, base=1)
        return replace(found, timed=found.timed or bool((found.frame % 1.0).any()))
    from_zero = table.header is None or path.suffix.lower() in (".csv", ".tsv")
    return box_table(table, picture, base=0 if from_zero else 1)


def _four_columns(content: bytes) -> bytes:
    """A text with four columns in place of one of lists or dicts, ``bbox`` with ``"[1, 2, 3, 4]"``, as of pandas."""
    head, _, body = content.partition(b"\n")
    if _KEYED.search(body, 0, 1000):
        head, body = re.sub(rb"\bbox\b", b"xyxy", head), _KEYED.sub(rb"[\1, \2, \3, \4]", body)
    found = _FOUR.search(body, 0, 1000)
    if not found:
        return content
    mark = separator_of(head.decode("utf-8", "replace"))
    cells = split_cells(head.decode("utf-8", "replace"))
    sides = {name: four for names, four in SIDES.items() for name in names.split()}
    names = mark.join(name for cell in cells for name in sides.get(cell.lower(), (cell,)))
    if mark == "," and b"," in found[0]:
        return names.encode() + b"\n" + body.translate(None, b"\"'[]()")
    return names.encode() + b"\n" + _FOUR.sub(mark.encode().join(rb"\%d" % n for n in range(1, 5)), body)


def box_table(table: NamedColumns, picture: Picture, base: int) -> BoxTable:
    """The boxes of a table by what its columns are; ``base`` counts frames and px that are not of time or shares."""
    table.refuse_films()
    wanted = [("frame", "time"), ("left", "right", "u"), ("top", "bottom", "v"), ("height", "bottom")]
    refuse_missing(table, wanted if "u" in table else [*wanted, ("width", "right", "height")])
    across, down = (_axis(table, names, picture and picture[n]) for n, names in enumerate(_SIDES))
    if across is None and down is not None and "u" in table:
        middle = _px(table, "u", picture and picture[0])
        boxes = rectangles(np.stack([middle, down[0] + 0.5 * down[1], down[1]], axis=-1))
    elif across is None or down is None:
        shown = quoted(",".join(table.header.names if table.header else ()))
        known = "left, top, width, height, two corners, or the middle and size of boxes"
        raise FileError(table.path, f"its columns {shown} do not say where boxes are; wanted: {known}")
    else:
        boxes = np.stack([across[0], down[0], across[1], down[1]], axis=-1)
    if not SHARES.intersection(table.unit(noun) for names in _SIDES for noun in names):
        boxes -= [base, base, 0.0, 0.0]
    scores = table.scaled("score")
    if (scores[scores < 0.0] == UNLINKED).all():
        scores[scores < 0.0] = np.nan
    # Scores of 1 and 0 alone are marks of rows that count or not, as in ground truth.
    flags = bool((scores == 1.0).any() and np.isin(scores[~np.isnan(scores)], (0.0, 1.0)).all())
    classes = _classes(table)
    if classes.dtype.kind in "if" and "class_name" in table and (table["class_name"] != "").any():
        classes = table["class_name"]
    stamps = _stamps_of_frames(table) if "frame" in table else table.scaled("time")
    return BoxTable(
        **vars(table),
        frame=frame_numbers(table) if stamps is None else stamps,
        boxes=boxes,
        id=table.columns.get("id", np.full(len(table), UNLINKED)),
        classes=classes,
        scores=scores,
        visible=table.numbers("visible"),
        ignored=(table.numbers("ignored", 0.0) != 0.0) | (flags & (scores == 0.0)),
        timed=stamps is not None,
        base=base,
    )


def _stamps_of_frames(table: NamedColumns) -> FloatArray | None:
    """[N] time stamps in s from numbers of frames or names of pictures, as in ROS and EuRoC; ``None`` for others."""

    def stamp(name: str) -> float:
        return parse_number(re.sub(r"\.[A-Za-z]\w*$", "", name.rpartition("/")[2])) or 0.0

    if (names := table["frame"]).dtype.kind in "if":
        found, inverse = table.numbers("frame"), np.arange(len(names))
    else:
        names, inverse = np.unique(names, return_inverse=True)
        found = np.array(list(map(stamp, names.tolist())))
    if not found.size or not found.min() >= LEAST_STAMP:
        return None
    unit = next(unit for unit, most in ((1.0, 1e11), (1e-3, 1e14), (1e-6, 1e17), (1e-9, np.inf)) if found.max() < most)
    return np.asarray(unit * found[inverse])


def frame_numbers(table: NamedColumns) -> FloatArray:
    """[N] numbers of frames, which may be the last number in a picture's name."""
    if table["frame"].dtype.kind in "if":
        return table.numbers("frame")
    names, row_of, inverse = np.unique(table["frame"], return_index=True, return_inverse=True)
    if any(parse_number(name) is not None for name in names.tolist()):
        return table.numbers("frame")
    found = [_DIGITS.findall(_ENDING.sub("", name)) or _DIGITS.findall(name) for name in names.tolist()]
    for row, digits in sorted(zip(row_of.tolist(), found, strict=True)):
        if not digits:
            raise table.fault(row, f"frame is {quoted(str(table['frame'][row]))}; write a number")
    for place in range(1, 1 + min(map(len, found))):  # the last numbers that differ: a size may follow
        numbers = np.array([float(digits[-place]) for digits in found])
        if len(np.unique(numbers)) == len(numbers):
            return numbers[inverse]
    numbers = np.array([float(digits[-1]) for digits in found])
    order = np.argsort(numbers, kind="stable")
    same = int(np.argmax(np.diff(numbers[order]) == 0.0))
    shown = " and ".join(quoted(str(name)) for name in names[order[same : same + 2]])
    raise FileError(table.path, f"pictures {shown} have one number; keep the boxes of one film")


def _axis(table: NamedColumns, names: tuple[str, ...], picture: float | None) -> tuple[FloatArray, FloatArray] | None:
    """Begin and size of boxes on an axis, [N] each, from two of near end, far end, middle and size."""
    low, high, middle, size = names
    if low in table and high in table:
        begin, end = _px(table, low, picture), _px(table, high, picture)
        problem = f"{high} is {{0:g}} and {low} {{1:g}}; is it the {size}? Then name it so"
        table.refuse(end <= begin, problem, end, begin)
        return begin, end - begin
    if size not in table:
        return None
    length = _px(table, size, picture)
    for name, share in ((low, 0.0), (middle, 0.5), (high, 1.0)):
        if name in table:
            return _px(table, name, picture) - share * length, length
    return None


def _px(table: NamedColumns, noun: str, picture: float | None) -> FloatArray:
    """[N] coordinates of boxes in px, from a column in px or in shares of the ``picture``."""
    values, unit = table.numbers(noun), table.unit(noun)
    table.refuse(~np.isfinite(values), f"{noun} is empty or nan; write a number")
    if unit not in SHARES:
        return values
    shares = values * UNITS[unit]
    if picture is None:
        raise FileError(table.path, f"{noun} is a share of the picture, whose size is not given; write px")
    problem = f"{noun} is {{0:g}}, and its name says that it is a share of the picture"
    table.refuse(np.abs(shares) > 1.5, problem, values)
    return np.asarray(shares * picture)


def _classes(table: NamedColumns) -> NDArray[Any]:
    """[N] numbers or names of classes; raises FileError at the first name among numbers."""
    classes = table.columns.get("class", np.full(len(table), UNLINKED))
    sample = np.unique(classes[:: 1 + len(classes) // _LOOKED_AT]).tolist()
    numbered = classes.dtype.kind in "if" or any(parse_number(cell) is not None for cell in sample)
    return table.numbers("class", UNLINKED) if numbered and "class" in table else classes


def _mot_columns(table: NamedColumns) -> NamedColumns:
    """The columns of MOTChallenge text by what they are here: its seventh to tenth have several meanings.

    Ground truth has 1 or 0 in the seventh, whether the row counts. What follows is class and visibility, or in 2D
    MOT15 a place in the world; trackers write class and −1, or class and the number of a detection.
    """
    _refuse_class_as_left(table)
    scores, classes = _scores_and_classes(table)
    visible = table.numbers("visible", UNLINKED)
    last = table.numbers("last", UNLINKED) if table.columns.get("last", scores).dtype.kind in "if" else scores * 0.0
    flags, ten = bool(np.isin(scores, (0.0, 1.0, UNLINKED)).all()), len(table.columns) == 10
    unknown = np.full(len(table), float(UNLINKED))
    if classes.dtype.kind in "if":
        no_class = ((classes != np.round(classes)) | (classes < UNLINKED)).any()
        plain = [(one % 1.0 == 0.0) | ((one >= 0.0) & (one <= 1.0)) for one in (visible, last)]  # and no place
        world = ten and not np.all(plain)
        if no_class or world or ((classes == 0) & (visible == 0) & (last == 0)).all():
            classes, visible = np.full(len(table), UNLINKED), unknown
    hidden, fractions = visible == 0.0, ((visible > 0.0) & (visible < 1.0)).any()
    mostly = len(table) >= FEWEST_HIDDEN and hidden.mean() >= 0.5
    truncated = hidden.any() and not fractions and (ten or not flags or mostly)
    if truncated or (not flags and (visible > 1.0).any() and (visible == np.round(visible)).all()):
        visible = unknown  # truncation, or the number of a detection
    counts = flags and ((scores == 1.0).any() or (visible != UNLINKED).any())
    columns = {
        "id": table["id"] if table["id"].dtype.kind in "if" else table.numbers("id"),  # raises at the first word
        "class": classes,
        "score": np.where(scores == UNLINKED, np.nan, scores) if counts or (scores != 0.0).any() else scores * np.nan,
        "visible": np.where(visible == UNLINKED, np.nan, visible),
        "ignored": ((scores == 0.0) & counts | (visible == 0.0)).astype(np.float64),
    }
    return replace(table, columns={**table.columns, **columns})


def _scores_and_classes(table: NamedColumns) -> tuple[FloatArray, NDArray[Any]]:
    """[N] the seventh and eighth column, which are class and score where these are whole numbers and shares."""
    scores, classes = table.numbers("score"), _classes(table)
    shares = classes.dtype.kind == "f" and ((classes >= 0.0) & (classes <= 1.0)).all() and (classes % 1.0).any()
    if not shares or (scores % 1.0).any() or ("visible" in table and (table.numbers("visible") != UNLINKED).any()):
        return scores, classes
    kinds = np.unique(scores).tolist()
    if kinds == [0.0, 1.0]:
        problem = "its last columns could be class and score, or a mark of rows that count and a visibility"
        raise FileError(table.path, f"{problem}; name the columns in a first line")
    return (scores, classes) if kinds in ([1.0], [UNLINKED]) else (classes, scores)


def _refuse_class_as_left(table: NamedColumns) -> None:
    """Raise FileError if the third column of a table without names is a class or score, and no side of boxes."""
    left = table.numbers("left")
    if len(left) < FEWEST_HIDDEN:
        return
    kinds = np.unique(left[:1000])
    few = len(kinds) <= FEW_CLASSES and not (left % 1.0).any() and left.min() >= 0.0 and left.max() <= LAST_CLASS
    share = left.min() >= 0.0 and left.max() <= 1.0 and (left % 1.0).any()
    rest = table.stacked("top", "width", "height") if few or share else np.zeros(1)
    if (few and (rest % 1.0).any()) or (share and (np.abs(rest) > 1.5).any()):
        shown, what = ", ".join(f"{one:g}" for one in kinds[:3]), "a score" if share else "a class"
        problem = f"left would be {shown} in all {len(left)} boxes: is it {what}? Then name the columns in a first line"
        raise FileError(table.path, f"{problem}: frame,id,class,left,top,…")


def people_in(table: BoxTable, person_class: int | str | None = None) -> tuple[BoolArray, tuple[str, ...]]:
    """Mask [N] of boxes of people that are not ignored; and notes that count the others, by class.

    Class 0 is people if it occurs, as in COCO; else class 1, as in MOTChallenge, whose ground truth has no class 0.
    The user may state the class of people, ``person_class``, by its number or name.
    """
    counted, classes = ~table.ignored, table.classes
    if not counted.any():
        raise FileError(table.path, f"all {len(counted)} boxes are marked as ignored: conf 0 or visibility 0")
    numbered = classes.dtype.kind in "if"
    known = counted & (np.isfinite(classes) & (classes != UNLINKED) if numbered else classes != "")
    values, place, count = np.unique(classes[known], return_inverse=True, return_counts=True)
    words = [table.class_names.get(int(one), f"{one:g}") if numbered else str(one) for one in values.tolist()]
    counts, kept, why = dict(zip(words, count.tolist(), strict=True)), counted.copy(), list[str]()
    if counts:
        chosen = _class_of_people(table.path, counts, person_class)
        kept[known] = np.array([word in chosen for word in words])[place]
        rest = {word: count for word, count in counts.items() if word not in chosen}
        why += [f"{_listed(rest)} (people are class {' or '.join(sorted(chosen))})"] if rest else []
    if not counted.all():
        why += [f"{int((~counted).sum())} marked as ignored (conf 0 or visibility 0)"]
    dropped = f"{int((~kept).sum())} of {len(kept)} boxes are dropped: {' and '.join(why)}"
    return kept, (dropped,) if why else ()


def _class_of_people(path: Path, counts: Mapping[str, int], given: int | str | None) -> set[str]:
    """The classes of people among those with boxes; raises FileError if the file does not show them."""
    if given is not None:
        chosen = {word for word in counts if word.lower() == str(given).strip().lower()}
        if not chosen:
            raise FileError(path, f"has no box of class {given}; it has {_listed(counts)}")
        return chosen
    named = {word for word in counts if PEOPLE & set(word.lower().replace(".", " ").split())}
    zero, one = counts.get("0", 0), counts.get("1", 0)
    numbered = {"0"} if zero and one <= RIVAL * zero else {"1"} if one and not zero else set[str]()
    if not named and not numbered:
        problem = f"has {_listed(counts)}; people are class 0 in COCO, 1 in MOTChallenge"
        raise FileError(path, f"{problem}; write which one is people: `person_class` N, or a name")
    return named or numbered


def _listed(counts: Mapping[str, int]) -> str:
    most = sorted(counts.items(), key=lambda one: -one[1])
    shown = ", ".join(f"{count} of class {word}" for word, count in most[:6])
    return f"{shown} and {len(most) - 6} other classes" if len(most) > 6 else shown


def scores_as_shares(scores: FloatArray) -> FloatArray:
    """Scores [N] from 0 to 1, for trackers: 1 if there is none, or it is larger.

    Scores below 0 are log-odds; where none is, and one is above `LEAST_PER_CENT`, they are per cent.
    """
    known = scores[~np.isnan(scores)]
    if len(known) and (known.min() < 0.0):
        scores = 1.0 / (1.0 + np.exp(-np.clip(scores, -50.0, 50.0)))
    elif len(known) and known.max() > LEAST_PER_CENT:
        scores = scores / max(100.0, float(known.max()))
    return np.minimum(np.where(np.isnan(scores), 1.0, scores), 1.0)


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
