"""The line that makes a dataset, from what its ``dataset.json`` says."""

import re
from collections.abc import Mapping
from typing import Any

from vbbench.camera import camera_to_dict, make_camera
from vbbench.errors import VbbenchError

LEAST_TRACK = 3
"""Frames of the shortest tracks where ``--least-track`` is left out."""
OWN_ENGINE = "numba"
"""What definitions call vbbench's own crowd engine, after what first ran it: ids of datasets stay as they are."""
FOOTAGE_FILES = {"poses": "poses", "boxes": "boxes", "bag": "bags"}
"""The options that name files of footage which its own folder does not hold, by what they hold."""
_WORD = re.compile(r"[\w.,:~/+-]{0,200}")


def generate_command(facts: Mapping[str, Any], out: str) -> str:
    """The line that makes the dataset with these ``facts`` in the folder ``out``.

    Parameters
    ----------
    facts : the values in a ``dataset.json`` of any format; whatever cannot be part of a line is left out.
    """
    definition = _object(facts.get("definition"))
    if "import" in definition:
        return f"vbbench import mot FOLDER --dataset DATASET --out {out}"
    options = _of_footage(facts, definition) if "every" in definition else _of_trajectories(facts, definition)
    seed = "secret --withhold-truth" if facts.get("seed", 0) is None else facts.get("seed", 0)
    drawn = {} if "every" in definition and seed == 0 else {"--seed": seed}
    part = {"--limit": definition.get("limit"), "--stride": definition.get("stride")}
    words = [(name, _word(value)) for name, value in {**options, **drawn, **part}.items()]
    said = [f"{name} {word}".rstrip() for name, word in words if word is not None]
    return " ".join(["vbbench generate", _word(facts.get("split")) or "SPLIT", *said, f"--out {out}"])


def _of_trajectories(facts: Mapping[str, Any], definition: Mapping[str, Any]) -> dict[str, Any]:
    split, tier, height_std = (facts.get(name) for name in ("split", "tier", "height_std"))
    look, scenario = definition.get("look"), _object(definition.get("scenario"))
    tracking = _object(definition.get("tracking") or definition.get("detector"))
    least_track = _object(tracking.get("tracker")).get("least_boxes")
    undetected = "detector" in definition and definition["detector"] is None
    people, usual = scenario.get("people"), {"sim": "open", "street": "street"}.get(str(split))
    return {
        "--source": "FILE" if split == "custom" else None,
        "--camera": _camera(_object(facts.get("camera"))),
        "--tier": tier,
        "--observer": definition.get("observer"),
        "--no-detector": "" if undetected else None,
        "--noise": None if tier != "noisy" or facts.get("pixel_std") == 1.0 else facts.get("pixel_std"),
        "--least-track": None if least_track == LEAST_TRACK else least_track,
        "--sigma-h": None if height_std == 0.07 or tier == "field" else height_std,
        "--look": None if look == "motion" and tier != "field" else look,
        "--dt": facts.get("dt") if split == "custom" else None,
        "--scenario": None if scenario.get("name") == usual else scenario.get("name"),
        "--sequences": scenario.get("sequences"),
        "--people": _people(people) if isinstance(people, list) else None,
        "--engine": None if definition.get("engine") == OWN_ENGINE else definition.get("engine"),
    }


def _of_footage(facts: Mapping[str, Any], definition: Mapping[str, Any]) -> dict[str, Any]:
    """Of a recording: whoever has it, and what else was read, knows where that lies."""
    scenes, kinds = facts.get("scenes"), _kinds(definition.get("files"))
    classes = definition.get("classes")
    cyclists = isinstance(classes, list) and "Cyclist" in classes
    return {
        "--source": "FOLDER",
        "--sequences": ",".join(map(str, scenes)) if isinstance(scenes, list) else None,
        **{f"--{option}": "FOLDER" if kind in kinds else None for kind, option in FOOTAGE_FILES.items()},
        "--cyclists": "" if cyclists else None,
        "--person-class": definition.get("person_class"),
        "--no-interpolated": "" if definition.get("interpolated") is False else None,
        "--every": definition.get("every"),
        "--longest": definition.get("longest"),
    }


def _kinds(files: Any) -> set[str]:
    """What files of footage held: they are listed by kind and recording, or by recording and kind."""
    if isinstance(files, dict):
        return {str(kind) for sums in files.values() for kind in _object(sums)}
    listed = files if isinstance(files, list) else []
    return {str(one[0]).partition("/")[0] for one in listed if isinstance(one, list) and one}


def _camera(values: Mapping[str, Any]) -> str | None:
    """The kind, of a camera that ``--camera`` makes; ``None`` of a tier's own."""
    try:
        usual = camera_to_dict(make_camera(str(values.get("kind", ""))))
    except VbbenchError:
        return None
    return usual["kind"] if usual == values else None


def _people(numbers: list[Any]) -> str | None:
    """Numbers of people as ``--people`` takes them; ``None`` if it cannot say them."""
    if not numbers or not all(type(number) is int for number in numbers):
        return None
    first, last, step = numbers[0], numbers[-1], numbers[1] - numbers[0] if len(numbers) > 1 else 1
    if step < 1 or numbers != list(range(first, last + 1, step)):
        return None
    return f"{first}" if first == last else f"{first}:{last}" if step == 1 else f"{first}:{last}:{step}"


def _object(value: Any) -> Mapping[str, Any]:
    return value if isinstance(value, dict) else {}


def _word(value: Any) -> str | None:
    """The value as a word of the line; ``None`` if it cannot be one."""
    text = f"{value:g}" if type(value) is float else str(value)
    spoken = value is not None and not isinstance(value, (dict, list, bool))
    return text if spoken and (not text or _WORD.fullmatch(text) or text == "secret --withhold-truth") else None
