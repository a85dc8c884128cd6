"""A simulated crowd as a recording of MOTChallenge Head Tracking 21, and the truth that it was made from."""

import io
import json
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from vbbench.errors import VbbenchError
from vbbench.exchange.heads.annotating import PEDESTRIAN, Others, draw_boxes, draw_others
from vbbench.exchange.heads.camera import SurveillanceCamera, camera_of
from vbbench.exchange.heads.settings import HeadOptions
from vbbench.exchange.heads.sighting import BELOW_TOP, HEAD, Heads, draw_screens, see_heads, visible_fractions
from vbbench.exchange.sequence_files import sequence_info
from vbbench.files.dataset import Dataset
from vbbench.folders.locks import loose_files
from vbbench.folders.replacing import write_bytes_atomically, write_text_atomically
from vbbench.geometry import FloatArray
from vbbench.scene import Scene

TRUTH_TABLE, TRUTH_FACTS = "truth.parquet", "truth.json"
"""The true place of each head in every frame; the camera, the options and figures of the recording."""


def export_heads(
    dataset: Dataset, out: Path | str, options: HeadOptions, *, sequence: int | None = None, seed: int = 0
) -> Path:
    """Photograph the crowd of a sequence from above and write the boxes of its heads as a folder of Head Tracking 21.

    The folder holds ``seqinfo.ini`` and ``gt/gt.txt`` (9 columns, frames and boxes counted from 1), and beside them
    `TRUTH_TABLE` (frame from 0, track, person, right, forward, x, y in m, u, v, size in px, visible) and `TRUTH_FACTS`.
    Everybody in the scene is photographed, including the observer. The same options and seed give the same bytes.

    Parameters
    ----------
    dataset : with its truth.
    out : folder to write; its name is the recording's.
    options : camera and annotation.
    sequence : whose frames; may be omitted if there is only one.
    seed : of the annotators' errors, and of what is annotated besides people.

    Raises
    ------
    VbbenchError
        If an option is out of range, the truth is withheld, or the camera sees nobody.
    """
    out, camera = Path(out), camera_of(options)
    if seed < 0:
        raise VbbenchError(f"seed must be at least 0, not {seed}")
    if options.key_every < 1:
        raise VbbenchError(f"key_every must be at least 1 frame, not {options.key_every}")
    if not 0.0 <= options.box_noise < 0.5:
        raise VbbenchError(f"box_noise must be at least 0 and below 0.5, not {options.box_noise:g}")
    with loose_files(out):
        number, scene = _photographed(dataset, sequence)
        station = _station(scene, camera, options)
        heads = see_heads(scene.positions, scene.heights, camera, station, dt=scene.dt, round_heads=options.round_heads)
        if not len(heads):
            raise VbbenchError("the camera sees nobody; by default it stands and looks so that the crowd is in view")
        rng = np.random.default_rng(np.random.SeedSequence([seed, number]))
        boxes = draw_boxes(heads, options.box_noise, options.key_every, rng)
        screens = draw_screens(camera, rng)
        visible = visible_fractions(heads, scene.heights[heads.person] - BELOW_TOP, camera, screens)
        others = draw_others(camera, scene.frames, scene.dt, rng)
        write_text_atomically(out / "gt" / "gt.txt", _truth_text(heads, boxes, visible, others))
        info = sequence_info(out.name, scene.dt, scene.frames, (camera.width, camera.height), ".jpg")
        write_text_atomically(out / "seqinfo.ini", info)
        write_bytes_atomically(out / TRUTH_TABLE, _truth_table(heads, visible, scene))
        facts = {
            "dataset": dataset.info.id,
            "sequence": number,
            "seed": seed,
            "options": asdict(options),
            "camera": {**asdict(camera), "horizon": camera.horizon},
            "station": dict(zip(("x", "y", "yaw"), station.tolist(), strict=True)),
            "screens": screens.tolist(),
            "head": {"diameter": HEAD, "below_top": BELOW_TOP},
            **_counts(heads, boxes, visible, scene),
        }
        write_text_atomically(out / TRUTH_FACTS, json.dumps(facts, indent=2) + "\n")
    return out


def _photographed(dataset: Dataset, sequence: int | None) -> tuple[int, Scene]:
    """The number of the sequence, and its scene in its frames."""
    if sequence is None and len(dataset) > 1:
        raise VbbenchError(f"{dataset.folder} has {len(dataset)} sequences; choose the one to record")
    one = dataset.sequence(sequence or 0)
    people, positions, heights = dataset.scene(one.scene)
    frames = slice(one.first_frame, one.first_frame + one.frames)
    return one.index, Scene(
        name=dataset.info.split, dt=dataset.info.dt, people=people, positions=positions[frames], heights=heights
    )


def _station(scene: Scene, camera: SurveillanceCamera, options: HeadOptions) -> FloatArray:
    """The camera's place, [3] (x, y, yaw): as chosen, or so that the crowd is in the middle of its view."""
    yaw = float(np.radians(options.facing))
    if options.at is not None:
        return np.array([*options.at, yaw])
    ahead = camera.middle_of_view() * np.array([np.cos(yaw), np.sin(yaw)])
    return np.append(scene.positions[scene.present].mean(axis=0) - ahead, yaw)


def _truth_text(heads: Heads, boxes: FloatArray, visible: FloatArray, others: Others) -> str:
    """The lines of ``gt.txt``, by track and frame; boxes that do not count follow with ids of their own."""
    ids = np.concatenate([heads.track, heads.track.max() + 1 + others.number])
    frames = np.concatenate([heads.frame, others.frame]) + 1
    drawn = np.concatenate([boxes, others.boxes]) + np.array([1.0, 1.0, 0.0, 0.0])
    confidence = np.concatenate([np.ones(len(heads), np.int64), others.confidence])
    kinds = np.concatenate([np.full(len(heads), PEDESTRIAN), others.kind])
    shares = np.concatenate([visible, np.ones(len(others.frame))])
    columns = (frames, ids, *drawn.T, confidence, kinds, shares)
    line = "{},{},{:.2f},{:.2f},{:.2f},{:.2f},{},{},{:.2f}\n"
    return "".join(line.format(*row) for row in zip(*(column.tolist() for column in columns), strict=True))


def _truth_table(heads: Heads, visible: FloatArray, scene: Scene) -> bytes:
    world = scene.positions[heads.frame, heads.person]
    columns = {
        "frame": heads.frame.astype(np.int32),
        "track": heads.track.astype(np.int32),
        "person": scene.people[heads.person].astype(np.int32),
        "right": heads.ground[:, 0],
        "forward": heads.ground[:, 1],
        "x": world[:, 0],
        "y": world[:, 1],
        "u": heads.places[:, 0],
        "v": heads.places[:, 1],
        "size": heads.sizes[:, 1],
        "visible": visible,
    }
    sink = io.BytesIO()
    pq.write_table(pa.table(columns), sink, compression="zstd")
    return sink.getvalue()


def _counts(heads: Heads, boxes: FloatArray, visible: FloatArray, scene: Scene) -> dict[str, float]:
    """The size of the recording, and the error of its boxes."""
    errors = boxes[:, 2:] / heads.sizes - 1.0
    return {
        "tracks": int(heads.track.max()),
        "people": len(np.unique(heads.person)),
        "boxes": len(heads),
        "hidden": int(np.sum(visible == 0.0)),
        "frames": scene.frames,
        "dt": scene.dt,
        "box_error": float(np.sqrt(np.mean(errors**2))),
    }
