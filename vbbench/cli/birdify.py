"""The command that makes a map of a user's own boxes, a film or a bag."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from vbbench.cli.views import announce


@dataclass(frozen=True, kw_only=True)
class Reading:
    """Parameters of reading a recording.

    Args:
        camera: TOML file with the picture's size, focal length, mount height and frame rate, or a folder with a
            camera.toml; or a calibration of ROS, Kalibr, OpenCV or COLMAP; see docs/own.md. For a bag also its topic.
        odometry: Trajectory by odometry: TUM, EuRoC, KITTI, or CSV with a header. For a bag also its topic.
        odometry_axes: Axes of the odometry's body, if its file does not show them: body (x forward, z up), camera
            (x right, y down, z forward), opengl, ned, imu, unity, unreal.
        boxes: For a bag: topic of its detections, such as /detections, if it has several.
        dt: For boxes: seconds per frame, if neither camera file nor time stamps state it.
        mount_height: The camera's height over the ground in m, if its file does not state it.
        pitch: Angle of the optical axis above the horizon in rad, if the camera file does not state it.
        carried_by: Carrier of the camera, if the camera file does not state it.
        person_class: For boxes: class of people, by number or name, if the file does not show it.
    """

    camera: Path | None = None
    odometry: Path | None = None
    odometry_axes: Literal["body", "camera", "opengl", "ned", "imu", "unity", "unreal"] | None = None
    boxes: str | None = None
    dt: float | None = None
    mount_height: float | None = None
    pitch: float | None = None
    carried_by: Literal["unknown", "person", "vehicle", "robot"] | None = None
    person_class: str | None = None

    @property
    def mount(self) -> dict[str, float | str]:
        """The stated values of the mount, by the keys of a camera file."""
        stated = {"mount_height": self.mount_height, "pitch": self.pitch, "carried_by": self.carried_by}
        return {name: value for name, value in stated.items() if value is not None}

    def check(self, recording: Path, bag: bool) -> None:
        """Refuse missing options, and those for another kind of recording."""
        from vbbench.errors import VbbenchError

        if self.camera is None and not bag:
            raise VbbenchError("name the file of the camera with --camera; docs/own.md says what to write")
        if self.boxes is not None and not bag:
            raise VbbenchError(f"--boxes is for bags, and {recording} is none; write bag:{recording} if it is")
        if self.dt is not None and self.camera is not None and not bag:
            _check_dt(self.dt, self.camera, self.mount)


def birdify(
    recording: Path | None = None,
    /,
    out: Path = Path("vbbench-map"),
    reading: Reading = Reading(),
    solver: str = "map-causal",
    detector: str | None = None,
    tracker: str | None = None,
    every: int | None = None,
    film: bool = False,
    example: bool = False,
    overwrite: bool = False,
) -> None:
    """Make a map of where a camera and the people around it were, from their boxes alone, a film, or a ROS bag.

    Args:
        recording: Text, CSV, JSON or an archive of a detector, tracker or annotation tool, or a folder of YOLO's labels
            (docs/own.md); a tracker links boxes without ids. Or a film: a video, or a folder of pictures, in which
            people are detected and tracked first. Or a ROS bag, as bag:DIR if its name does not show it.
        out: Folder to make: report.md, map.png, poses, positions.
        solver: A registered name or module:attribute of your own.
        detector: For a film: hog (default), an ONNX file (YOLO, YOLOX, RT-DETR …), or module:attribute of your own.
        tracker: For a film: byte (default), or module:attribute of your own.
        every: For a film: use only every n-th frame for the map; all are tracked.
        film: Make film.mp4 of the map next to the boxes, too.
        example: Use no recording, but 20 s of a simulated robot, whose truth is compared with the map.
        overwrite: Replace a folder that birdify made.
    """
    from vbbench.birdify.birdify import birdify as make
    from vbbench.birdify.birdify import is_film
    from vbbench.errors import VbbenchError
    from vbbench.exchange.box_tables import holds_pictures

    if example or recording is None:
        _example(recording, example, out, solver=solver, film=film, overwrite=overwrite, announce=announce)
        return
    recording, bag = _file_or_bag(recording)
    filmed = not bag and is_film(recording)
    asked = {"detector": detector, "tracker": tracker, "every": every}
    given: dict[str, Any] = {name: value for name, value in asked.items() if value is not None}
    if given and not filmed:
        raise VbbenchError(f"--{next(iter(given))} is for films, and {recording} is a file of boxes; remove it")
    for name in ("dt", "person_class"):
        if filmed and (recording.is_file() or holds_pictures(recording)) and getattr(reading, name) is not None:
            advice = f"write dt or fps in {reading.camera} if its own is wrong" if name == "dt" else "remove it"
            raise VbbenchError(f"--{name.replace('_', '-')} is for boxes, and {recording} is a film; {advice}")
    reading.check(recording, bag)
    camera = reading.camera
    of_boxes: dict[str, Any] = {"dt": reading.dt, "person_class": reading.person_class}
    options: dict[str, Any] = {
        "odometry": reading.odometry,
        "mount": reading.mount,
        "odometry_axes": reading.odometry_axes,
        "solver": solver,
        "film": film,
        "overwrite": overwrite,
        "announce": announce,
    }
    if bag:
        from vbbench.birdify.bags import BagTopics, birdify_bag

        topics = BagTopics(boxes=reading.boxes, odometry=options.pop("odometry"), camera=camera)
        made = birdify_bag(recording, out, topics, **of_boxes, **options)
    elif filmed:
        from vbbench.birdify.films import Detection, birdify_film  # reads films, which boxes alone do not need

        made = birdify_film(recording, Path(camera or ""), out, Detection(**given), **options)
    else:
        made = make(recording, Path(camera or ""), out, **of_boxes, **options)
    print(f"{made.folder}: {made.report.summary()}")


def _file_or_bag(source: Path) -> tuple[Path, bool]:
    """The path without ``bag:``, and whether it is a ROS bag."""
    from vbbench.exchange.bags import is_bag

    return Path(str(source).removeprefix("bag:")), str(source).startswith("bag:") or is_bag(source)


def _example(recording: Path | None, example: bool, out: Path, **options: Any) -> None:
    """Make the map of the example, where it and no recording is named."""
    from vbbench.errors import VbbenchError

    if not example:
        raise VbbenchError("name a file of boxes, a film or a bag; or try --example")
    if recording is not None:
        raise VbbenchError(f"--example has its own boxes; remove {recording} or --example")
    from vbbench.birdify.example import birdify_example

    print(birdify_example(out, **options))


def _check_dt(dt: float, camera: Path, mount: dict[str, float | str]) -> None:
    """Refuse a ``dt`` that contradicts the camera file."""
    from vbbench.errors import VbbenchError
    from vbbench.exchange.own.camera_file import find_camera, read_camera

    seconds = read_camera(find_camera(camera), mount).facts.seconds
    if seconds is not None and abs(dt / seconds - 1.0) > 1e-6:
        raise VbbenchError(f"--dt says that a frame lasts {dt:g} s, and {camera} {seconds:g} s; keep one of them")
