"""Films of the rendered street, with the boxes that a detector finds in them: the tables of the split `street-film`.

``python -m benchmarks.street_films --detector yolox_nano.onnx`` takes about 20 s a film on one core. Films that are
made already, in ``--work``, are not made again; ``--first N`` makes N films, of which the first are the same.
"""

import argparse
import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from vbbench.boxes import cut_to_picture
from vbbench.camera import PerspectiveCamera
from vbbench.exchange.detection import Detections, Detector, make_detector
from vbbench.exchange.matching import true_rectangles
from vbbench.folders.replacing import write_text_atomically
from vbbench.generation.generator import Observer, Options, Simulation
from vbbench.geometry import FloatArray, IntArray
from vbbench.parallel.parts import progress_bar
from vbbench.pictures.rendering import Picture, bearer
from vbbench.scene import Scene
from vbbench.sequence import SequenceData
from vbbench_generators.footage.street_film import DT, FOLDER, SCALE, TABLES
from vbbench_generators.splits import street
from vbbench_generators.tiers.field import carry, get_field
from vbbench_renderers.meshes import Sky, Surroundings
from vbbench_renderers.people import Walkers
from vbbench_renderers.raster import Drawer
from vbbench_renderers.surroundings import surroundings_of

FILMS, FRAMES, SEED = 50, 80, 52
SIZE = 640, 480
FEWEST = 4
"""People who must be in the picture and not hidden in every frame of a film."""
LEAST_SHOWN = 0.12
"""Share of a box in the picture that its person must fill to be labelled: about a quarter of whom shows."""
TIMES: dict[str, tuple[float, tuple[float, float, float], float]] = {
    "morning": (20.0, (1.25, 0.95, 0.62), 0.9),
    "noon": (58.0, (1.40, 1.30, 1.12), 1.05),
    "evening": (12.0, (1.05, 0.62, 0.34), 0.7),
    "overcast": (55.0, (0.22, 0.22, 0.23), 1.3),
}
"""Elevation of the sun in degrees, its colour, and how bright the sky is."""
CLOUDS = np.array([0.52, 0.55, 0.60], np.float32)


@dataclass(frozen=True)
class Film:
    """A film before it is rendered: who is where, and what camera sees them in each of its frames.

    ``nominal`` is the camera as it is calibrated, ``cameras`` are as they are carried; ``first`` frame of the scene.
    """

    data: SequenceData
    first: int
    nominal: PerspectiveCamera
    cameras: tuple[PerspectiveCamera, ...]
    carrier: str
    time: str

    @property
    def scene(self) -> Scene:
        """Everybody."""
        assert self.data.scene is not None
        return self.data.scene

    @property
    def poses(self) -> FloatArray:
        """[T, 3] of the camera."""
        return self.data.truth.poses[self.first : self.first + FRAMES]


def plan_film(number: int) -> Film:
    """The film of a number; all follows from it."""
    rng = np.random.default_rng([SEED, number])
    observer: Observer = "robot" if number % 2 else "walker"
    mount = rng.uniform(0.6, 1.2) if observer == "robot" else rng.uniform(1.4, 1.75)
    nominal = PerspectiveCamera(
        width=SIZE[0],
        height=SIZE[1],
        cx=SIZE[0] / 2,
        cy=SIZE[1] / 2,
        focal=float(round(rng.uniform(380, 560))),
        mount_height=round(mount, 2),
    )
    people = int(rng.integers(20, 51))
    for seed in rng.integers(2**31, size=20).tolist():
        asked = Options(seed=seed, camera=nominal, observer=observer, simulation=Simulation(people=(people,)), limit=1)
        data = street.plan(asked).build(0)
        counts = data.sequence.observed.sum(axis=1)
        fewest = np.lib.stride_tricks.sliding_window_view(counts, FRAMES).min(axis=1)
        if (fewest >= FEWEST).any():
            break
    first = int(rng.choice(np.flatnonzero(fewest >= min(FEWEST, fewest.max()))))
    poses = data.truth.poses[first : first + FRAMES]
    carried = carry(poses, nominal.mount_height, DT, observer, get_field(), rng)
    moments = zip(carried.pitch, carried.roll, carried.mount, strict=True)
    cameras = tuple(replace(nominal, pitch=p, roll=r, mount_height=h) for p, r, h in moments)
    carrier = "person" if observer == "walker" else "robot"
    return Film(data, first, nominal, cameras, carrier, list(TIMES)[number // 2 % len(TIMES)])


def lit(surroundings: Surroundings, time: str) -> Surroundings:
    """Surroundings at a time of the day."""
    elevation, colour, bright = TIMES[time]
    sky, up = surroundings.sky, np.radians(elevation)
    level = np.asarray(sky.sun_direction[:2]) / np.hypot(*sky.sun_direction[:2])
    sun = np.append(np.cos(up) * level, np.sin(up)).astype(np.float32)
    zenith, horizon = (CLOUDS, CLOUDS) if time == "overcast" else (sky.zenith, sky.horizon)
    light = np.array(colour, np.float32)
    air = Sky(
        sun_direction=sun,
        sun_colour=light,
        zenith=(bright * zenith).astype(np.float32),
        horizon=(bright * horizon * (light / light.max()) ** 0.5).astype(np.float32),
        ground_glow=sky.ground_glow,
        haze_distance=200.0 if time == "overcast" else sky.haze_distance,
    )
    return replace(surroundings, sky=air)


def pictures_of(film: Film, number: int) -> Iterator[Picture]:
    """The film's pictures."""
    scene = film.scene
    drawer = Drawer(scene, Walkers(scene, number), lit(surroundings_of(scene, number, plain=False), film.time))
    for frame, camera in enumerate(film.cameras):
        yield drawer.render(film.first + frame, camera, film.poses[frame], observer=bearer(film.data.sequence))


def whole(values: FloatArray, scale: float) -> IntArray:
    """Whole multiples of 1 / ``scale``."""
    return np.rint(np.asarray(values) * scale).astype(np.int64)


def labels_of(film: Film, shown: list[NDArray[np.int32]]) -> FloatArray:
    """[T, P, 4] boxes (left, top, width, height) in px of the scene's people as a person would draw them, NaN = none.

    Parameters
    ----------
    shown : of each frame the ids [H, W] that its picture shows.
    """
    scene, (width, height) = film.scene, SIZE
    labels = np.full((FRAMES, len(scene.people), 4), np.nan)
    for t, (camera, ids) in enumerate(zip(film.cameras, shown, strict=True)):
        about = camera.cx + width, camera.cy + height
        wide = replace(camera, width=3 * width, height=3 * height, cx=about[0], cy=about[1])
        places = scene.positions[[film.first + t]]
        boxes = true_rectangles(places, scene.heights, film.poses[[t]], wide)[0] - [width, height, 0.0, 0.0]
        inside = cut_to_picture(boxes, camera)[:, 2:].prod(axis=1)
        pixels = np.bincount(ids[ids >= 0], minlength=scene.people.max() + 1)[scene.people]
        labels[t] = np.where((pixels > LEAST_SHOWN * inside)[:, None], boxes, np.nan)
    return labels


def columns_of(film: Film, found: list[Detections], labels: FloatArray) -> dict[str, dict[str, IntArray]]:
    """The rows of a film in each of the `TABLES`; who is labelled has a place from the first label to the last."""
    scene = film.scene
    people = np.flatnonzero(~np.isnan(labels[..., 0]).all(axis=0))
    places, labels = scene.positions[film.first : film.first + FRAMES, people], labels[:, people]
    shown = ~np.isnan(labels[..., 0])
    lasting = np.maximum.accumulate(shown) & np.maximum.accumulate(shown[::-1])[::-1]
    person, frame = np.nonzero(lasting.T)
    counts = [len(one.scores) for one in found]
    boxes, scores = (np.concatenate([getattr(one, name) for one in found]) for name in ("boxes", "scores"))
    sides = ("left", "top", "width", "height")
    return {
        "boxes": {
            "frame": np.repeat(np.arange(FRAMES), counts),
            **dict(zip(sides, whole(boxes, SCALE["px"]).T, strict=True)),
            "score": whole(scores, SCALE["score"]),
        },
        "people": {
            "person": person,
            "frame": frame,
            **dict(zip("xy", whole(places[frame, person], SCALE["m"]).T, strict=True)),
            **dict(zip(sides, whole(np.nan_to_num(labels[frame, person]), SCALE["px"]).T, strict=True)),
        },
        "walks": {
            "frame": np.arange(FRAMES),
            **dict(zip("xy", whole(film.poses[:, :2], SCALE["m"]).T, strict=True)),
            "yaw": whole(film.poses[:, 2], SCALE["rad"]),
        },
        "heights": {"person": np.arange(len(people)), "height": whole(scene.heights[people], SCALE["m"])},
    }


def make_film(number: int, detector: Detector, work: Path) -> None:
    """Render a film, search it, and keep its rows in ``work``."""
    film = plan_film(number)
    found, shown = [], []
    for picture in pictures_of(film, number):
        found.append(detector.detect(picture.rgb))
        shown.append(picture.ids)
    rows = columns_of(film, found, labels_of(film, shown))
    camera = {name: getattr(film.nominal, name) for name in ("width", "height", "focal", "mount_height")}
    facts = {"name": f"film-{number:02d}", "carried_by": film.carrier, "time": film.time, **camera}
    flat: dict[str, Any] = {"facts": json.dumps(facts)}
    for table, columns in rows.items():
        flat |= {f"{table}.{name}": column for name, column in columns.items()}
    kept = work / f"{number:02d}.npz"
    with kept.with_suffix(".part").open("wb") as file:
        np.savez_compressed(file, **flat)
    kept.with_suffix(".part").replace(kept)


def join(films: list[Path], out: Path) -> None:
    """Write the tables of some films."""
    kept = [np.load(path) for path in films]
    out.mkdir(parents=True, exist_ok=True)
    for table, columns in TABLES.items():
        counts = [len(one[f"{table}.{next(iter(columns))}"]) for one in kept]
        arrays = {"film": pa.array(np.repeat(np.arange(len(kept)), counts), pa.uint8())}
        for name, kind in columns.items():
            arrays[name] = pa.array(np.concatenate([one[f"{table}.{name}"] for one in kept]), kind)
        pq.write_table(
            pa.table(arrays), out / f"{table}.parquet", compression="zstd", compression_level=19, use_dictionary=False
        )
    rows = ",\n".join(str(one["facts"]) for one in kept)
    write_text_atomically(out / "films.json", f"[\n{rows}\n]\n")


def main() -> None:
    """Parse, make and write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--detector", required=True, help="an ONNX file")
    parser.add_argument("--first", type=int, default=FILMS, help="so many films (default: %(default)s)")
    parser.add_argument("--work", type=Path, default=Path("out/street-film"))
    parser.add_argument("--out", type=Path, default=FOLDER, help="folder of the tables (default: %(default)s)")
    asked = parser.parse_args()
    asked.work.mkdir(parents=True, exist_ok=True)
    detector = make_detector(asked.detector)
    paths = [asked.work / f"{number:02d}.npz" for number in range(asked.first)]
    with progress_bar(len(paths), "films", unit="film") as bar:
        for number, path in enumerate(paths):
            if not path.is_file():
                make_film(number, detector, asked.work)
            bar.update()
    join(paths, asked.out)


if __name__ == "__main__":
    main()
