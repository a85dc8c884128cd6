"""From a film to a map: people are detected and tracked, and their boxes passed to `birdify`."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from vbbench.birdify.birdify import Birdified, birdify
from vbbench.birdify.report import REPORT
from vbbench.errors import FileError
from vbbench.exchange.axes import Axes
from vbbench.exchange.film_boxes import FilmBoxes, find_boxes
from vbbench.exchange.own.camera_file import OwnCamera, find_camera, read_camera
from vbbench.files.dataset_info import Pictures
from vbbench.folders.work_folder import check_free
from vbbench.pictures.rendering import silent
from vbbench.pictures.video import Film, open_film
from vbbench.registry import load


@dataclass(frozen=True, kw_only=True)
class Detection:
    """Options of detection and tracking; see `vbbench.exchange.film_boxes.find_boxes`."""

    detector: str = "hog"
    tracker: str = "byte"
    every: int = 1


def birdify_film(
    path: Path | str,
    camera: Path | str,
    out: Path | str,
    detection: Detection,
    *,
    odometry: Path | str | None = None,
    odometry_axes: Axes | None = None,
    solver: str = "map-causal",
    film: bool = False,
    mount: Mapping[str, float | str] | None = None,
    overwrite: bool = False,
    announce: Callable[[str], object] = silent,
) -> Birdified:
    """Make a map from a film.

    Boxes are first written to ``OUT.boxes.txt``, which is removed once the map is complete (``OUT/recording/gt.txt``
    has the same). After a failure, `vbbench.birdify.birdify.birdify` can be called on this file.

    Raises VbbenchError if the film cannot be read or has another size than the camera, nobody is found, or `birdify`
    raises it.

    Parameters
    ----------
    path : a video, or a folder of pictures.
    camera : camera file; its ``fps`` or ``dt`` takes precedence over the video's.
    detection : options of detection and tracking.
    out, odometry, odometry_axes, solver, film, mount, overwrite, announce : as in `vbbench.birdify.birdify.birdify`.
    """
    out, shot, own = Path(out), open_film(Path(path)), read_camera(find_camera(Path(camera)), mount)
    load("solver", solver)  # nobody waits for boxes to hear that its name is wrong
    _check_size(shot, own)
    check_free(out, REPORT, "folder that birdify made", overwrite)
    found = _find(shot, own, out, detection, announce)
    made = birdify(
        found.path,
        camera,
        out,
        odometry=odometry,
        odometry_axes=odometry_axes,
        solver=solver,
        film=film,
        mount=mount,
        dt=found.dt,
        name=shot.path.resolve().name if shot.files else shot.path.stem,
        pictures=_pictures(shot, found),
        overwrite=overwrite,
        announce=announce,
    )
    found.path.unlink()
    return made


def _check_size(shot: Film, own: OwnCamera) -> None:
    facts = own.facts
    if (facts.width, facts.height or shot.height) != (shot.width, shot.height):
        said = f"{facts.width} x {facts.height or '?'} px"
        advice = "write the size of the film, with the focal length that belongs to it"
        raise FileError(own.path, f"says {said}, {shot.path} is {shot.width} x {shot.height}: {advice}")


def _find(shot: Film, own: OwnCamera, out: Path, detection: Detection, announce: Callable[[str], object]) -> FilmBoxes:
    """Detect people in the film; writes their boxes to a file next to the folder ``out``."""
    seconds = own.facts.seconds
    fps = None if seconds is None else 1.0 / seconds
    if fps and shot.fps and abs(fps / shot.fps - 1.0) > 0.02:
        announce(f"{own.path} says {fps:.4g} frames a second, the film {shot.fps:.4g}: those of {own.path.name} count")
    boxes = out.with_name(f"{out.name}.boxes.txt")
    boxes.parent.mkdir(parents=True, exist_ok=True)
    announce(f"finding people with {detection.detector} in {shot.frames} frames")
    search = partial(find_boxes, shot, boxes, fps=fps, period=own.camera.period)
    found = search(**vars(detection))
    announce(str(found))
    return found


def _pictures(shot: Film, found: FilmBoxes) -> Pictures | None:
    """The pictures of the frames with boxes, for plots; ``None`` for a video, or pictures without numbers."""
    files = shot.numbered()
    return files and replace(files, first=files.first + found.first, step=found.step)
