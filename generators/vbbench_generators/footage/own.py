"""Split ``own``: recordings of the user's own camera; docs/own.md describes their files."""

import warnings
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import ClassVar

from vbbench.errors import FileError, VbbenchError, VbbenchWarning
from vbbench.exchange.own.recording import BOXES, CAMERA, RecordingFiles, as_recordings, files_in, read_recording
from vbbench.generation.footage import FootageOptions, Recordings
from vbbench.generation.generator import Card, Options, bundled_card
from vbbench_generators.footage.split import READ_BY_ALL, FootageSplit, RunRules, named

CARD = bundled_card("vbbench_generators", "own")


@dataclass(frozen=True, kw_only=True)
class OwnSplit(FootageSplit):
    """Recordings in a folder, or in the folders inside it; each is one sequence."""

    reads: ClassVar[frozenset[str]] = READ_BY_ALL | {"poses", "boxes", "person_class", "dt"}

    card: Card = CARD
    rules: RunRules = field(default_factory=lambda: RunRules(fewest=0, longest=None))

    def recordings(self, options: Options) -> Recordings:
        """See `FootageSplit.recordings`; warns of implausible values."""
        asked = options.footage or FootageOptions()
        found = [_files(folder, asked) for folder in _folders(options.source, asked.sequences)]
        read = [read_recording(files, dt=options.dt, person_class=asked.person_class) for files in found]
        for files, one in zip(found, read, strict=True):
            for note in one.notes:
                warnings.warn(VbbenchWarning(f"{files.name}: {note}"), stacklevel=2)
        found_in = as_recordings(read)
        return replace(found_in, definition={**found_in.definition, **asked.classes})


def _folders(source: Path | None, names: tuple[str, ...] | None) -> list[Path]:
    """The folders of the chosen recordings, by name."""
    if source is None:
        raise VbbenchError(f"own: name the folder of your recording with --source; {CARD.caution}")
    if not source.is_dir():
        raise FileError(source, f"is not a folder; name {CARD.caution}")
    if (source / CAMERA).is_file():
        found = {source.resolve().name: source}
    else:
        found = {path.parent.name: path.parent for path in sorted(source.glob(f"*/{CAMERA}"))}
        forgotten = [path.name for path in sorted(source.iterdir()) if path.name not in found and _has_boxes(path)]
        if found and forgotten:
            text = f"{source}: {', '.join(forgotten)} skipped: boxes without {CAMERA}"
            warnings.warn(VbbenchWarning(text), stacklevel=3)
    if not found:
        raise FileError(source, f"holds no {CAMERA}, nor does a folder in it; docs/own.md says what to write")
    return [found[name] for name in named("recording", names, found)]


def _has_boxes(folder: Path) -> bool:
    with suppress(OSError):  # such as a folder that may not be looked into
        return any((folder / name).is_file() for name in BOXES)
    return False


def _files(folder: Path, asked: FootageOptions) -> RecordingFiles:
    """The files of a recording; those that the user names replace its own."""
    name = folder.resolve().name
    return files_in(folder, boxes=_instead(asked.boxes, name), poses=_instead(asked.poses, name))


def _instead(path: Path | None, name: str) -> Path | None:
    """The file that replaces a recording's own: ``path`` itself, or the file called ``name`` in that folder."""
    if path is None or not path.is_dir():
        return path
    found = next((path / f"{name}{end}" for end in (".csv", ".txt") if (path / f"{name}{end}").is_file()), None)
    if found is None:
        raise FileError(path, f"holds neither {name}.csv nor {name}.txt")
    return found


own = OwnSplit()
