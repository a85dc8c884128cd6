"""The command line that generates a dataset, from its ``dataset.json``."""

import re
from collections.abc import Mapping
from typing import Any

from vbbench.camera import camera_to_dict, make_camera
from vbbench.errors import VbbenchError

LEAST_TRACK = 3
"""Frames of the shortest tracks where ``least_track`` is not given."""
OWN_ENGINE = "numba"
"""What definitions call the crowd engine, after what first ran it: ids of datasets stay as they are."""
FOOTAGE_FILES = {"poses": "poses", "boxes": "boxes", "bag": "bags"}
"""The options that name files of footage which its own folder does not hold, by what they hold."""
_PLACES = {"source", *FOOTAGE_FILES.values()}
"""Options whose values are words for a file or folder of the user's."""
_OWN = ("source", "camera", "tier", "sigma_h", "dt", "sequences", "every", "seed", "limit")
"""Options of every split, which come first on the line, in this order."""
_WORD = re.compile(r"[\w.,:~/+-]{0,200}")


def generate_command(facts: Mapping[str, Any], out: str) -> str:
    """The command line that generates the dataset with these ``facts`` in the folder ``out``.

    Parameters
    ----------
    facts : the values in a ``dataset.json`` of any format; values that cannot be part of a line are dropped.
    """
    if "import" in _object(facts.get("definition")):
        return f"vbbench import mot FOLDER --dataset DATASET --out {out}"
    options = options_of(facts)
    needs_file = any(isinstance(value, (dict, list)) for value in options.values())
    if needs_file:
        options = {name: value for name, value in options.items() if name in _PLACES}
    names = [*_OWN, *(name for name in options if name not in _OWN)]
    said = [option for name in names if (option := _option(name, options.get(name)))]
    said += ["--options dataset.json"] if needs_file else []
    if facts.get("seed", 0) is None:
        said.append("--seed secret --withhold-truth")
    return " ".join(["vbbench generate", _word(facts.get("split")) or "SPLIT", *said, f"--out {out}"])


def options_of(facts: Mapping[str, Any]) -> dict[str, Any]:
    """The options that generate the dataset with these ``facts``, by name, without default values.

    Parameters
    ----------
    facts : the values in a ``dataset.json`` of any format.
    """
    definition = _object(facts.get("definition"))
    is_footage = "every" in definition
    options = _of_footage(facts, definition) if is_footage else _of_trajectories(facts, definition)
    seed = facts.get("seed", 0)
    options |= {"seed": None if is_footage and seed == 0 else seed}
    options |= {"limit": definition.get("limit"), "stride": definition.get("stride")}
    return {name: value for name, value in options.items() if value is not None}


def _of_trajectories(facts: Mapping[str, Any], definition: Mapping[str, Any]) -> dict[str, Any]:
    split, tier, height_std = (facts.get(name) for name in ("split", "tier", "height_std"))
    look, scenario = definition.get("look"), _object(definition.get("scenario"))
    tracking = _object(definition.get("tracking") or definition.get("detector"))
    least_track = _object(tracking.get("tracker")).get("least_boxes")
    undetected = "detector" in definition and definition["detector"] is None
    people, usual = scenario.get("people"), {"sim": "open", "street": "street"}.get(str(split))
    return {
        "source": "FILE" if split == "custom" else None,
        "camera": _camera(_object(facts.get("camera")), tier),
        "tier": tier,
        "observer": definition.get("observer"),
        "detector": False if undetected else None,
        "noise": None if tier != "noisy" or facts.get("pixel_std") == 1.0 else facts.get("pixel_std"),
        "least_track": None if least_track == LEAST_TRACK else least_track,
        "sigma_h": None if height_std == 0.07 or tier == "field" else height_std,
        "look": None if look == "motion" and tier != "field" else look,
        "dt": facts.get("dt") if split == "custom" else None,
        "scenario": None if scenario.get("name") == usual else scenario.get("name"),
        "sequences": scenario.get("sequences"),
        "people": _people(people) if isinstance(people, list) else None,
    }


def _of_footage(facts: Mapping[str, Any], definition: Mapping[str, Any]) -> dict[str, Any]:
    """Options of footage; paths of its files are placeholders, since they are not published."""
    scenes, kinds = facts.get("scenes"), _kinds(definition.get("files"))
    classes, cameras = definition.get("classes"), definition.get("cameras")
    cameras = cameras if isinstance(cameras, list) and cameras != ["panorama"] else []
    if len(cameras) > 1 and isinstance(scenes, list):
        scenes = list(dict.fromkeys(str(scene).partition(".")[0] for scene in scenes))
    cyclists = isinstance(classes, list) and "Cyclist" in classes
    packaged = "detector" in definition  # a definition names it where boxes come with a package
    return {
        "source": None if packaged else "FOLDER",
        "camera": ",".join(map(str, cameras)) or None,
        "sequences": ",".join(map(str, scenes)) if isinstance(scenes, list) else None,
        **{option: "FOLDER" if kind in kinds else None for kind, option in FOOTAGE_FILES.items()},
        "cyclists": cyclists or None,
        "person_class": definition.get("person_class"),
        "interpolated": False if definition.get("interpolated") is False else None,
        "every": definition.get("every"),
        "longest": definition.get("longest"),
    }


def _kinds(files: Any) -> set[str]:
    """Kinds of the files of footage, which are listed by kind and recording, or by recording and kind."""
    if isinstance(files, dict):
        return {str(kind) for sums in files.values() for kind in _object(sums)}
    listed = files if isinstance(files, list) else []
    return {str(one[0]).partition("/")[0] for one in listed if isinstance(one, list) and one}


def _camera(values: Mapping[str, Any], tier: Any) -> str | Mapping[str, Any] | None:
    """The name of a camera that ``--camera`` accepts; ``None`` for a tier's own camera; else its parameters."""
    try:
        usual = camera_to_dict(make_camera(str(values.get("kind", ""))))
    except VbbenchError:
        return None
    return usual["kind"] if usual == values else None if tier == "field" else values


def _people(numbers: list[Any]) -> str | list[int] | None:
    """Numbers of people as the option's range, or the list if they are no range."""
    if not numbers or not all(type(number) is int for number in numbers):
        return None
    first, last, step = numbers[0], numbers[-1], numbers[1] - numbers[0] if len(numbers) > 1 else 1
    if step < 1 or numbers != list(range(first, last + 1, step)):
        return numbers
    return f"{first}" if first == last else f"{first}:{last}" if step == 1 else f"{first}:{last}:{step}"


def _object(value: Any) -> Mapping[str, Any]:
    return value if isinstance(value, dict) else {}


def _option(name: str, value: Any) -> str | None:
    """The option with its value; ``None`` if that cannot be a word of the line."""
    option = name.replace("_", "-")
    if type(value) is bool:
        return f"--{option}" if value else f"--no-{option}"
    word = _word(value)
    return f"--{option} {word}" if word else None


def _word(value: Any) -> str | None:
    """The value as a word of the line; ``None`` if it cannot be one."""
    text = f"{value:g}" if type(value) is float else str(value)
    spoken = value is not None and not isinstance(value, (dict, list))
    return text if spoken and _WORD.fullmatch(text) else None
