"""Options of a generator as a file or a command line writes them, and the `Options` that they make."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, get_args, get_type_hints

import msgspec

from vbbench.camera import camera_from_dict, make_camera
from vbbench.errors import FileError, VbbenchError, quoted
from vbbench.files.dataset_info import INFO_FILE
from vbbench.files.generate_command import options_of
from vbbench.generation.footage import FootageOptions
from vbbench.generation.generator import MOST_PEOPLE, FootageGenerator, Look, Observer, Options, Simulation
from vbbench.parsing.json_text import read_object
from vbbench.parsing.toml_text import from_table, read_toml
from vbbench.registry import load

AS_THEY_ARE = ("tier", "look", "observer", "detector", "noise", "least_track", "seed", "limit", "stride", "dt")
"""Options that `Options` has under the same names."""
SIMULATED = ("scenario", "sequences", "people")
"""Options of a simulated crowd."""
OF_FOOTAGE = ("sequences", "every", "longest", "person_class", "cyclists", "interpolated")
"""Options of footage."""
PLACES = ("poses", "boxes", "bags")
"""Options of footage that are files or folders."""


@dataclass(frozen=True, kw_only=True)
class WrittenOptions:
    """Options by the names that a command line and a file in TOML give them; ``None`` leaves one to split and tier.

    All but these are as in `Options`, `Simulation` and `FootageOptions`.

    Parameters
    ----------
    camera : name of a registered model, or a table of its ``kind`` and parameters; of a car's recordings, names of its
        cameras with commas between.
    sigma_h : standard deviation in m of people's heights.
    sequences : number of simulated sequences, or names of recordings, in one text with commas between or as a list.
    people : a number of people, a list of them, or a text such as ``10:50:10``.
    poses, boxes, bags : files or folders, from the folder of the file.
    """

    camera: str | Mapping[str, Any] | None = None
    tier: str | None = None
    sigma_h: float | None = None
    look: Look | None = None
    observer: Observer | None = None
    detector: bool | None = None
    noise: float | None = None
    least_track: int | None = None
    seed: int | None = None
    limit: int | None = None
    stride: int | None = None
    dt: float | None = None
    scenario: str | None = None
    sequences: int | str | tuple[str, ...] | None = None
    people: int | str | tuple[int, ...] | None = None
    every: int | None = None
    longest: int | None = None
    person_class: str | None = None
    cyclists: bool | None = None
    interpolated: bool | None = None
    poses: str | None = None
    boxes: str | None = None
    bags: str | None = None

    def with_given(self, **given: Any) -> "WrittenOptions":
        """These options, with those of a command line that are not ``None`` in place of the file's."""
        return replace(self, **{name: value for name, value in given.items() if value is not None})

    def options(self, split: str, *, source: Path | None, homography: Path | None) -> Options:
        """The options of a generator.

        Raises VbbenchError if the split is unknown, or a value is none of its option.

        Parameters
        ----------
        split : what the options are for.
        source, homography : as in `Options`.
        """
        generator = load("generator", split)
        is_footage = isinstance(generator, FootageGenerator)
        named = self.camera if "cameras" in getattr(generator, "reads", ()) else None
        cameras = tuple(named.split(",")) if isinstance(named, str) else None
        return Options(
            camera=None if cameras else self._camera(),
            source=source,
            homography=homography,
            height_std=self.sigma_h,
            simulation=self._simulation(is_footage),
            footage=self._footage(is_footage, cameras),
            **self.chosen(*AS_THEY_ARE),
        )

    def chosen(self, *names: str) -> dict[str, Any]:
        """Those of the options that are not ``None``."""
        return {name: value for name in names if (value := getattr(self, name)) is not None}

    def _camera(self) -> Any:
        if isinstance(self.camera, Mapping):
            return camera_from_dict(dict(self.camera))
        return None if self.camera is None else make_camera(self.camera)

    def _simulation(self, is_footage: bool) -> Simulation | None:
        asked = self.chosen(*SIMULATED)
        if is_footage:
            asked.pop("sequences", None)
        if "sequences" in asked:
            asked["sequences"] = parse_count(str(self.sequences))
        if "people" in asked:
            asked["people"] = self.people if isinstance(self.people, tuple) else parse_people(str(self.people))
        return Simulation(**asked) if asked else None

    def _footage(self, is_footage: bool, cameras: tuple[str, ...] | None) -> FootageOptions | None:
        asked = self.chosen(*OF_FOOTAGE)
        asked |= {name: Path(place).expanduser() for name, place in self.chosen(*PLACES).items()}
        if cameras is not None:
            asked["cameras"] = cameras
        if not is_footage:
            asked.pop("sequences", None)
        if "sequences" in asked and not isinstance(self.sequences, tuple):
            asked["sequences"] = tuple(name.strip() for name in str(self.sequences).split(",") if name.strip())
            if not asked["sequences"]:
                raise VbbenchError(f"no recording is named in '{self.sequences}'; name some, with commas between")
        return FootageOptions(**asked) if asked else None


def read_options(words: Sequence[str], split: str, *, seed: int | None = None) -> WrittenOptions:
    """The options of words ``NAME=VALUE``, and of a file in their midst, before which they come.

    Raises VbbenchError if there is a second file, one is not valid or of another split, its seed is withheld and none
    is given, or a word names no option or has another type.

    Parameters
    ----------
    words : the file is in TOML, or a dataset's folder or ``dataset.json``, whose options are taken.
    split : what they are for.
    seed : in place of the file's; that of a dataset may be withheld.
    """
    places = [word for word in words if not re.match(r"[\w-]+=", word)]
    if len(places) > 1:
        raise VbbenchError(f"`options` takes one file, not {' and '.join(places)}; write single ones NAME=VALUE")
    table, hints = dict[str, Any](), get_type_hints(WrittenOptions)
    for word in words:
        if word not in places:
            name, _, text = word.partition("=")
            name = name.replace("-", "_")
            table[name] = _typed(text, hints.get(name, str))
    given = from_table(table, WrittenOptions, Path("--options"), "options of generate")
    return _read_file(Path(places[0]), split, seed).with_given(**vars(given)) if places else given


def _typed(text: str, hint: Any) -> Any:
    """The text as a number or truth value where an option takes no text."""
    if str in get_args(hint):
        return text
    try:
        return msgspec.convert(text, hint, strict=False)
    except msgspec.ValidationError:
        return text  # the reader of files says what is wrong with it


def _read_file(path: Path, split: str, seed: int | None) -> WrittenOptions:
    folder = path if path.is_dir() else path.parent
    if not path.is_dir() and path.name != INFO_FILE:
        read = read_toml(path, WrittenOptions, "options of generate")
        return read.with_given(**{name: str(folder / place) for name, place in read.chosen(*PLACES).items()})
    facts = read_object(folder / INFO_FILE, "generate the dataset again")
    if facts.get("split") != split:
        raise FileError(folder / INFO_FILE, f"is of the split {quoted(facts.get('split'))}, not of {split}")
    if facts.get("seed") is None and seed is None:
        raise FileError(folder / INFO_FILE, "its seed is withheld; add --seed")
    known = {field.name for field in fields(WrittenOptions)}
    made = {name: value for name, value in options_of(facts).items() if name in known}
    return from_table(made, WrittenOptions, folder / INFO_FILE, "definition")


def parse_count(text: str) -> int:
    """A number of sequences; raises VbbenchError if it is none."""
    if not re.fullmatch(r"-?[0-9]{1,9}", text):
        raise VbbenchError(
            f"a number of sequences is a whole number, not '{text}'; only footage has recordings with names"
        )
    return int(text)


def parse_people(text: str) -> tuple[int, ...]:
    """Numbers of people from ``K``, ``A:B`` (both ends included) or ``A:B:STEP``.

    Raises VbbenchError if it is none of these, or no crowd.
    """
    form = re.fullmatch(r"([0-9]{1,9})(?::([0-9]{1,9})(?::([0-9]{1,9}))?)?", text)
    first, last, step = (int(form[1]), int(form[2] or form[1]), int(form[3] or 1)) if form else (0, 0, 1)
    if not 2 <= first <= last <= MOST_PEOPLE or step < 1:
        wanted = f"a number from 2 to {MOST_PEOPLE:,}, A:B, or A:B:STEP such as 10:50:10"
        raise VbbenchError(f"numbers of people are {wanted}, not '{text}'")
    return tuple(range(first, last + 1, step))
