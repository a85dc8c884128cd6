"""The split ``motsynth``: videos of a game, with the game's own people, joints and camera."""

import re
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vbbench.camera import PerspectiveCamera
from vbbench.errors import FileError, SourceMissingError, VbbenchError, VbbenchWarning
from vbbench.files.dataset_info import Pictures
from vbbench.files.tables import file_sha256
from vbbench.generation.footage import Footage, FootageOptions, Recordings
from vbbench.generation.generator import Card, Options, bundled_card
from vbbench.scene import Scene
from vbbench_generators.footage.motsynth_video import CameraPath, find_camera_path, read_annotations
from vbbench_generators.footage.split import FootageSplit, laid_out, medians, named, pictures_in

WHERE = (
    "unpack MOTSynth_coco_annotations.zip (motchallenge.net/data/MOTSynth-MOT-CVPR22) and name its folder, "
    "'annotations' with 000.json and so on"
)
CARD = bundled_card("vbbench_generators", "motsynth")
CAUTION = "the people and cameras of a game; how its camera's angles are read is recognised, not published"
"""Of a dataset that was made."""
_NAME = re.compile(r"[0-9]{3}")


@dataclass(frozen=True, kw_only=True)
class MotsynthSplit(FootageSplit):
    """Videos at 20 frames a second, of which every eighth frame is kept: 0.4 s."""

    card: Card = CARD
    every: int = 8

    def recordings(self, options: Options) -> Recordings:
        """Read the chosen annotation files; an unusable video is skipped, unless the user names it."""
        asked = options.footage or FootageOptions()
        files = _annotation_files(options.source, asked.sequences)
        footage, reports, digests = [], {}, {}
        for path in files:
            try:
                camera_path = find_camera_path(read_annotations(path))
            except FileError as error:
                if asked.sequences is not None or len(files) == 1:
                    raise
                warnings.warn(f"skipped: {error}", VbbenchWarning, stacklevel=2)
                continue
            footage.append(_footage(path, camera_path))
            reports[path.stem] = camera_path.report
            digests[path.stem] = file_sha256(path)
        if not footage:
            raise VbbenchError(f"{options.source}: none of the {len(files)} videos can be used; see the warnings")
        return Recordings(
            footage=tuple(footage),
            definition={"files": digests},
            calibration={"summary": _summary(reports), "recordings": reports},
            caution=CAUTION,
        )


def _annotation_files(source: Path | None, names: tuple[str, ...] | None) -> list[Path]:
    """The annotation files of the videos called ``names``; all of them by default."""
    if source is None:
        raise SourceMissingError(f"motsynth needs --source: {WHERE}")
    folder = source / "annotations" if (source / "annotations").is_dir() else source
    if source.is_file():
        files = {source.stem: source}
    else:
        files = {path.stem: path for path in sorted(folder.glob("*.json")) if _NAME.fullmatch(path.stem)}
    if not files:
        raise SourceMissingError(f"{source}: no annotation files of MOTSynth here; {WHERE}")
    return [files[name] for name in named(f"video of {folder}", names, files)]


def _footage(path: Path, camera_path: CameraPath) -> Footage:
    """The footage of one video, without boxes whose centre is outside the picture."""
    found = camera_path.annotations
    tracks = np.unique(found.person)
    column = np.searchsorted(tracks, found.person)
    middle = found.boxes[:, :2] + 0.5 * found.boxes[:, 2:]
    inside = ((middle >= 0.0) & (middle < [found.width, found.height])).all(axis=1)
    shape, at, dt = (found.frames, len(tracks)), (found.frame[inside], column[inside]), 1.0 / found.fps
    values = np.column_stack([middle, found.boxes[:, 3]]), found.visible, camera_path.people
    boxes, visible, positions = (laid_out(shape, at, one[inside]) for one in values)
    return Footage(
        name=path.stem,
        camera=PerspectiveCamera(
            width=found.width,
            height=found.height,
            focal=found.focal,
            cx=found.cx,
            cy=found.cy,
            mount_height=camera_path.mount_height,
            pitch=camera_path.pitch,
            roll=camera_path.roll,
        ),
        dt=dt,
        tracks=tracks,
        boxes=boxes,
        visible=visible,
        poses=camera_path.poses,
        scene=Scene(
            name=path.stem,
            dt=dt,
            people=tracks,
            positions=positions,
            heights=medians(camera_path.statures, column, len(tracks)),
        ),
        pictures=_pictures(path, found.first),
    )


def _pictures(path: Path, first: int) -> Pictures | None:
    """The pictures next to the annotations, in the layout of the data set's own tool; ``None`` without any."""
    folder = path.parent.parent / "frames" / path.stem / "rgb"
    return pictures_in(folder, "{:04d}.jpg", first)


def _summary(reports: dict[str, Any]) -> str:
    """A line with the worst value over all videos of each check."""
    values = list(reports.values())
    worst = {
        name: max(report[name] for report in values) for name in ("joint_px", "pose_error", "box_error", "pitch_spread")
    }
    mended = [name for name, report in reports.items() if report["pose_shift"]]
    text = (
        f"{len(values)} videos; at worst joints reproject to {worst['joint_px']:.1f} px, people move on as predicted "
        f"to {worst['pose_error']:.1%} of their height, boxes lie {worst['box_error']:.1%} of it from their joints, "
        f"the pitch changes by {worst['pitch_spread']:.3f} rad"
    )
    return f"{text}; shifted frames mended in {', '.join(mended)}" if mended else text


motsynth = MotsynthSplit()
