"""Names of columns: what detectors, trackers and data sets call the frame, the id, the borders of a box and so on.

Names are matched without case, blanks, underscores, dots and brackets, and without the words ``bbox``, ``bb`` or
``box`` before them. A unit may follow, as in ``time_ns``, ``x [m]``, ``yaw/deg`` or ``left_norm``.
"""

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

_COLUMN_NAMES: dict[str, tuple[str, ...]] = {
    "frame": (
        "frame frameid frameidx frameindex frameno framenr framenum framenumber frames fr timestep",
        "image imageid imageidx imageindex imagename img imgid imgname picture filename imagefile imagepath framename",
        "file",
    ),
    "time": ("time timestamp timestamps stamp t sec secs seconds frametime framestamp headerstamp stampsecs",),
    "nanoseconds": ("nanosec nsec nsecs nanosecs stampnanosec stampnsecs headerstampnanosec headerstampnsecs",),
    "id": (
        "id trackid trackerid tracknumber tracklet trackletid tid objectid objid personid pid pedid pedestrianid "
        "targetid agentid actorid subjectid playerid humanid instanceid identity identities uuid idobject idperson "
        "tracktoken instancetoken",
        "track tracker person ped pedestrian agent target actor subject player object obj instance",
        "idx",
    ),
    "film": (
        "video videoid videoname videofile clip clipid camera cameraid cam camid sequence seq sequenceid seqid "
        "sequencename seqname scene sceneid scenename view viewid source sourceid stream streamid recording "
        "recordingid",
    ),
    "left": ("left x1 xmin x0 xtl xleft leftx minx xlt tlx topleftx xtopleft ltx l", "x x_"),
    "top": ("top y1 ymin y0 ytl ytop topy miny ylt tly toplefty ytopleft lty t", "y"),
    "right": ("right x2 x1 xmax xbr xright rightx maxx xrb brx bottomrightx xbottomright rbx r",),
    "bottom": ("bottom y2 y1 ymax ybr ybottom bottomy maxy yrb bry bottomrighty ybottomright rby b",),
    "u": ("u xcenter xcentre centerx centrex xc cx xctr ctrx xmid midx ucenter centeru",),
    "v": ("v ycenter ycentre centery centrey yc cy yctr ctry ymid midy vcenter centerv",),
    "width": ("width w boxwidth dx xsize",),
    "height": ("height h boxheight dy ysize", "l"),
    "class": (
        "class classid classidx classindex classno cls clsid clsidx category categoryid catid objectcategory "
        "objectclass objecttype objecttypeid label labels labelid labelidx",
        "type",
    ),
    "class_name": (
        "classname clsname categoryname labelname catname objectname classlabel typename",
        "name",
    ),
    "score": (
        "score scores conf confidence confidences prob probability detscore detconf detectionscore "
        "detectionconfidence detconfidence objectconf trackconf trackscore certainty likelihood",
    ),
    "visible": ("visible visibility vis visratio visibilityratio visiblefraction visibleratio visiblity",),
    "ignored": ("ignored ignore isignored ignoreflag ignoreregion lost outside outofview dontcare iscrowd",),
    "x": (
        "x xest px tx easting posx posex xpos positionx positionsx posepositionx xworld worldx groundx xground prsrx "
        "xcenter xcentre centerx",
    ),
    "y": (
        "y yest py ty northing posy posey ypos positiony positionsy posepositiony yworld worldy groundy yground prsry "
        "ycenter ycentre centery",
    ),
    "z": ("z pz tz posz zpos positionz positionsz posepositionz zworld worldz prsrz",),
    "qx": ("qx quatx quaternionx orientationx poseorientationx rotationx rotx qrsx",),
    "qy": ("qy quaty quaterniony orientationy poseorientationy rotationy roty qrsy",),
    "qz": ("qz quatz quaternionz orientationz poseorientationz rotationz rotz qrsz",),
    "qw": ("qw quatw quaternionw orientationw poseorientationw rotationw rotw qrsw",),
    "yaw": ("yaw heading theta poseyaw posetheta orientation psi azimuth rotationyaw",),
    "vx": ("vx velx velocityx xvel speedx",),
    "vy": ("vy vely velocityy yvel speedy",),
}
"""Names of each noun, the sure ones first: a later group counts only where no name of an earlier one is there."""

UNITS: dict[str, float] = {
    **dict.fromkeys(("s", "sec", "seconds"), 1.0),
    **dict.fromkeys(("ms", "msec", "milliseconds"), 1e-3),
    **dict.fromkeys(("us", "µs", "usec", "microseconds"), 1e-6),
    **dict.fromkeys(("ns", "nanoseconds"), 1e-9),
    "m": 1.0, "meters": 1.0, "metres": 1.0, "cm": 1e-2, "mm": 1e-3, "km": 1e3, "ft": 0.3048, "feet": 0.3048,
    "rad": 1.0, "radians": 1.0, **dict.fromkeys(("deg", "degree", "degrees", "°"), 0.017453292519943295),
    "px": 1.0, "pixel": 1.0, "pixels": 1.0,
    "norm": 1.0, "normalized": 1.0, "normalised": 1.0, "rel": 1.0, "relative": 1.0, "ratio": 1.0, "n": 1.0,
    "pct": 0.01, "percent": 0.01, "%": 0.01,
}  # fmt: skip
"""Factors of the units that names can have, to s, m, rad, px and shares of the whole."""
LONGEST_NAME, LONGEST_HEADER = 60, 20_000
"""Characters of a name that are looked at, and of a line that may be a header."""
SHARES = frozenset(("norm", "normalized", "normalised", "rel", "relative", "ratio", "n", "pct", "percent", "%"))
"""Units of a share of the picture, or of the whole."""

_KNOWN = {
    noun: {name: rank for rank, names in enumerate(groups) for name in names.split()}
    for noun, groups in _COLUMN_NAMES.items()
}
_BRACKETS = re.compile(r"(.*\S)\s*(?:[\[(]\s*(.*?)\s*[\])]|/\s*([a-z]+))")
_SUFFIX = re.compile(r"(.*?)[_ .]?(?:(?<=[_ .])([a-z]+)|(?<=\d)(n))")
_PREFIX = re.compile(r"(norm|normalized|normalised|rel|relative|pct|percent)(?:[\W_]coord[a-z]*)?[\W_]+(.*)")
_BOX = re.compile(r"(?:bounding[ _]?box|bndbox|bbox|bb|box|rect(?:_?params)?|ltwh|tlwh|xywh|xyxy)(?:2d)?[\W_]*(.+)")

_COMMAS = re.compile(r"\s*[-+]?\d+(,\d+)?([eE][-+]?\d+)?( +[-+]?\d+(,\d+)?([eE][-+]?\d+)?)+\s*")
_QUOTES = " \t\r\n\"'\ufeff<>#"


@dataclass(frozen=True)
class Header:
    """What the columns of a table are.

    Parameters
    ----------
    names : of all columns, as in the file.
    columns : the column of each noun that is there.
    units : the unit of each noun whose name has one, a key of `UNITS`.
    doubtful : nouns for which several columns stand, with their names.
    """

    names: tuple[str, ...]
    columns: Mapping[str, int]
    units: Mapping[str, str]
    doubtful: Mapping[str, tuple[str, ...]]

    def __contains__(self, noun: str) -> bool:
        return noun in self.columns

    @property
    def ignored(self) -> tuple[str, ...]:
        """Names of columns that no noun stands for."""
        used = set(self.columns.values())
        return tuple(name for column, name in enumerate(self.names) if column not in used and name)


def name_columns(names: Sequence[str], nouns: Collection[str]) -> Header:
    """Find the columns of those ``nouns`` of the table that a reader looks for.

    Of several names for one noun the surer one counts: in MOTChallenge's ``bb_left,…,x,y,z``, ``x`` is not the left
    border. Two equally sure ones, or one name twice, are ``doubtful``, and the first column counts.
    """
    columns, units, doubtful = dict[str, int](), dict[str, str](), dict[str, tuple[str, ...]]()
    read = [_forms(name) for name in names]
    letters = {forms[0][0] for forms in read} | {word for forms in read for word, _ in forms if len(word) == 2}
    for noun in nouns:
        known = _KNOWN[noun]
        found = []
        for column, forms in enumerate(read):
            here = [(word, unit) for word, unit in forms if word in known and _may_be(noun, word, letters)][:1]
            found += [(known[word] + 0.5 * (unit in SHARES), column, unit) for word, unit in here]
        if not found:
            continue
        best = [one for one in found if one[0] == min(found)[0]]
        columns[noun] = best[0][1]
        if best[0][2]:
            units[noun] = best[0][2]
        if len(best) > 1:
            doubtful[noun] = tuple(names[column].strip(_QUOTES) for _, column, _ in best)
    return Header(tuple(name.strip(_QUOTES) for name in names), columns, units, doubtful)


def _may_be(noun: str, word: str, words: Collection[str]) -> bool:
    """Whether a word that two nouns share stands for this one, by the other words of the table.

    ``l`` and ``t`` together are borders, alone a height and a time; ``x1`` is the left border, but after ``x0`` the
    right one.
    """
    if word in ("x1", "y1"):
        return (noun in ("right", "bottom")) == ("x0" in words and "x2" not in words)
    borders = {"l", "t"} <= set(words)
    return word not in ("l", "t", "r", "b") or (noun in ("left", "top", "right", "bottom")) == borders


def header_of(line: str, nouns: Collection[str]) -> Header | None:
    """The columns that a line names, a first line or a comment; ``None`` if it is too long to do so.

    Names are separated by semicolons, tabs, commas, bars or blanks: `split_cells`.
    """
    return name_columns(split_cells(line.strip(_QUOTES)), nouns) if len(line) <= LONGEST_HEADER else None


def separator_of(line: str) -> str:
    """What separates the cells of a line: a semicolon, tab, comma, bar, or blanks, also between decimal commas."""
    return " " if _COMMAS.fullmatch(line) else next((mark for mark in ";\t,|" if mark in line), " ")


def split_cells(line: str) -> list[str]:
    """The cells of a line, without quotes and blanks around them."""
    mark = separator_of(line)
    cells = re.split(r"\s+(?![\[(])", line.strip()) if mark == " " else line.split(mark)
    return [cell.strip(_QUOTES) for cell in cells]


def _forms(name: str) -> list[tuple[str, str]]:
    """The words under which a name is looked for, with the unit that each leaves: as it is, then without a suffix."""
    text = name.strip(_QUOTES).lower()[:LONGEST_NAME]
    bracket, suffix, prefix = _BRACKETS.fullmatch(text), _SUFFIX.fullmatch(text), _PREFIX.fullmatch(text)
    if bracket and (bracket[3] is None or bracket[3] in UNITS):
        unit = bracket[2] or bracket[3] or ""
        return [(_word(bracket[1]), unit if unit in UNITS else "")]
    forms = [(_word(text), "")]
    if suffix and (suffix[2] or suffix[3]) in UNITS:
        forms.append((_word(suffix[1]), suffix[2] or suffix[3]))
    if prefix:
        forms.append((_word(prefix[2]), prefix[1]))
    return forms


def _word(text: str) -> str:
    found = _BOX.fullmatch(text)
    word = re.sub(r"[\W_]", "", found[1] if found else text)
    return "bbox id" if found and word == "id" else word
