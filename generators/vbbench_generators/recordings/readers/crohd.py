"""Recordings of people's heads by a surveillance camera, in the layout of CroHD (MOTChallenge Head Tracking 21).

A recording is a folder with ``seqinfo.ini`` (name, length, size of pictures) and ``gt/gt.txt`` (boxes). It may be given
as that folder, as a folder above it, or in the published zip archive.
"""

import os
import re
from collections.abc import Iterable
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path, PurePosixPath

import numpy as np

from vbbench.errors import FileError, VbbenchError
from vbbench.exchange.box_rows import linked_rows
from vbbench.exchange.box_tables import MOT, read_box_text
from vbbench.exchange.mot import PEDESTRIAN
from vbbench.exchange.sequence_files import SEQUENCE_INFO, parse_seqinfo
from vbbench.files.tables import file_sha256
from vbbench.generation.archives import open_archive
from vbbench.generation.generator import Options
from vbbench.generation.sources import Source, find_source, locate
from vbbench_generators.lifting import lift
from vbbench_generators.lifting.heads import HeadBoxes
from vbbench_generators.recordings.loading import Loaded, Reader, every_frame
from vbbench_generators.recordings.readers.tracks import check_size, check_speed, read_homography
from vbbench_generators.recordings.recipe import Recipe

NINE = MOT.replace("[", "").replace(" last]", "")
"""Columns of ground truth."""
SEQINFO, BOXES = SEQUENCE_INFO, "gt/gt.txt"
_PUBLISHED = re.compile(r"HT21-\d\d")
_LEAST_TRACKS, _LEAST_FRAMES = 2, 2


@dataclass(frozen=True)
class TextFile:
    """Content of a file from a folder or an archive, with equal bytes; ``path`` names both for messages."""

    path: Path
    content: bytes


RecordingFiles = dict[str, TextFile]
"""`SEQINFO` and `BOXES` of a recording."""


def find_recording(name: str, archive: Source, explicit: Path | None, *, split: str) -> RecordingFiles:
    """Read the files of the recording ``name``.

    Raises SourceMissingError if ``explicit`` is ``None`` and the archive is not in the data folders; VbbenchError if
    there is no such recording, more than one, or its files cannot be read.

    Parameters
    ----------
    name : name of its folder, such as ``HT21-03``.
    archive : the published archive, used if ``explicit`` is ``None``; its checksum must match.
    explicit : the user's path: the recording's folder; a folder with one called ``name`` anywhere below, or with the
        published archive; or an archive, with any checksum.
    split : name of the split, for messages.
    """
    if explicit is None:
        (path,) = locate([archive], split=split)
        return _from_archive(path, name)
    if explicit.is_file():
        return _from_archive(explicit, name)
    if not explicit.is_dir():
        raise VbbenchError(f"{explicit}: there is no such file or folder")
    if (explicit / SEQINFO).is_file():
        called = explicit.resolve().name
        if _PUBLISHED.fullmatch(called) and called != name:
            raise FileError(explicit, f"is another recording: {split} is made from {name}")
        return _from_folder(explicit)
    below = [Path(at) for at, _, files in os.walk(explicit) if SEQINFO in files]  # links are not followed
    folders = [folder.relative_to(explicit).as_posix() for folder in below if folder.name == name]
    if folders:
        return _from_folder(explicit / _the_one(explicit, folders, name))
    packed = find_source(archive, explicit)
    if packed is not None and packed.is_relative_to(explicit):
        (path,) = locate([archive], packed, split=split)
        return _from_archive(path, name)
    raise FileError(explicit, f"holds neither {name} (a folder with {SEQINFO} and {BOXES}) nor {archive.file_name}")


def _from_folder(folder: Path) -> RecordingFiles:
    def read(name: str) -> TextFile:
        path = folder / name
        try:
            return TextFile(path, path.read_bytes())
        except OSError as error:
            raise FileError(path, f"cannot be read: {error.strerror}") from error

    return {name: read(name) for name in (SEQINFO, BOXES)}


def _from_archive(path: Path, name: str) -> RecordingFiles:
    with open_archive(path) as archive:
        members = {member.replace("\\", "/"): member for member in archive.names}
        infos = [PurePosixPath(member) for member in members if PurePosixPath(member).name == SEQINFO]
        folders = [str(info.parent) for info in infos if info.parent.name == name]
        if not folders:
            raise FileError(path, f"holds no {name}: no folder of that name with {SEQINFO} and {BOXES}")
        folder = _the_one(path, folders, name)
        if f"{folder}/{BOXES}" not in members:
            raise FileError(path / folder / BOXES, "is missing in the archive")
        content = {name: archive.read(members[f"{folder}/{name}"]) for name in (SEQINFO, BOXES)}
    return {name: TextFile(path / folder / name, text) for name, text in content.items()}


def _the_one(place: Path, folders: Iterable[str], name: str) -> str:
    found = sorted(folders)
    if len(found) > 1:
        raise FileError(place, f"holds {name} more than once: {', '.join(found)}; name one of them with --source")
    return found[0]


def read_heads(files: RecordingFiles) -> HeadBoxes:
    """The visible heads of walking people: class 1, a conf other than 0, a visible fraction above 0.

    Frame rate, length and size are those of ``seqinfo.ini``. Other rows (statues, ignored regions, people on vehicles,
    hidden heads) are skipped once they parse as numbers.

    Raises FileError with file and line, if a row has not 9 numbers; if a head has an invalid frame or id, an empty box,
    or a second box in a frame. Also if there are too few heads, or too many.
    """
    info = parse_seqinfo(files[SEQINFO].path, files[SEQINFO].content)
    table = read_box_text(files[BOXES].path, files[BOXES].content, layout=NINE)
    counted = (table.classes == PEDESTRIAN) & (table.scores != 0.0) & (table.visible > 0.0)
    table = table.select(counted)
    wanted = f"no frame of the sequence: its frames are 1 to {info.frames}"
    rows = linked_rows(table, table.whole("frame", 1, info.frames, wanted) - 1)
    frame, track = rows.frame, rows.track
    if len(rows) and not rows.linked:
        raise rows.fault(0, "id is -1: these are detections; tracks of heads are wanted")
    tracks, frames = len(np.unique(track)), int(frame.max(initial=-1)) + 1
    if tracks < _LEAST_TRACKS or len(np.unique(frame)) < _LEAST_FRAMES:
        problem = "holds no crowd: two tracks and two frames at least of class 1, conf not 0 and visibility above 0"
        raise FileError(table.path, problem)
    check_size(table.path, frames, tracks, len(frame))
    order = np.lexsort((frame, track))
    return HeadBoxes(
        name=info.name,
        dt=1.0 / info.rate,
        size=info.size,
        frame=frame[order],
        track=track[order],
        boxes=rows.boxes[order],
        visible=rows.visible[order],
    )


class HeadTracking(Reader):
    """Recordings of heads, lifted to the ground by the recipe's table ``[lifting]``."""

    def load(self, recipe: Recipe, options: Options) -> Loaded:
        """Find the recording, read its heads and lift them; the user's homography replaces the calibration."""
        if options.dt is not None:
            raise VbbenchError(f"{recipe.name}: `dt` is for the split 'custom'; here seqinfo.ini has the frame rate")
        if recipe.recording is None or recipe.lifting is None:
            problem = "a recipe of format crohd needs the key 'recording' and a table [lifting]"
            raise VbbenchError(f"{recipe.name}: {problem}")
        files = find_recording(recipe.recording, recipe.source[0], options.source, split=recipe.name)
        matrix = None if options.homography is None else read_homography(options.homography)
        lifted = lift(read_heads(files), recipe.lifting, matrix)
        scene = every_frame(lifted.tracks, recipe.frame_step or 1)
        check_speed(files[BOXES].path, scene)
        sums = [(f"{recipe.recording}/{name}", sha256(file.content).hexdigest()) for name, file in files.items()]
        if options.homography is not None:
            sums.append(("homography", file_sha256(options.homography)))
        return Loaded(scenes=[scene], files=sums, calibration=lifted.calibration)


crohd = HeadTracking()
