"""What participants get: one folder, and one archive, with the same bytes whoever makes them."""

import shutil
import zipfile
from functools import partial
from pathlib import Path

from vbbench.errors import FileError, VbbenchError
from vbbench.files.cards.writing import CROISSANT, README
from vbbench.files.dataset import Dataset
from vbbench.files.dataset_info import INFO_FILE, describe
from vbbench.files.tables import file_sha256
from vbbench.files.verification import verify
from vbbench.folders.replacing import replacing
from vbbench.folders.work_folder import WorkFolder
from vbbench_leaderboards.challenge.definition import read_challenge
from vbbench_leaderboards.challenge.organiser import DATA, Organiser, check_withheld
from vbbench_leaderboards.challenge.submissions import check
from vbbench_leaderboards.results.folder import CHALLENGE_FILE
from vbbench_leaderboards.results.result import NEEDED, NOBODY_YET
from vbbench_leaderboards.site.pages import check_made, render, write_files

BUNDLE = "bundle of 'vbbench challenge bundle'"
SUMS = "SHA256SUMS"

_THEN = (1980, 1, 1, 0, 0, 0)
"""The day that every member of the archive bears: the first that the format has."""


def make_bundle(folder: Path, out: Path, *, archive: bool = False) -> list[Path]:
    """Write the bundle of a challenge into the folder ``out``; return the paths of all that is written.

    Raises VbbenchError if the secret set is missing, damaged or gives anything away, ``challenge.toml`` has texts of
    the template, or ``out`` exists and is not a bundle.

    Parameters
    ----------
    archive : also write it into ``out.zip``.
    """
    organiser = Organiser(folder)
    dataset, challenge = organiser.dataset, organiser.challenge
    if challenge.placeholders:
        problem = f"{', '.join(challenge.placeholders)}: as in the template; say who holds the challenge"
        raise FileError(folder / CHALLENGE_FILE, problem)
    verify(dataset.folder, organiser.truth)
    with WorkFolder(out, partial(check_made, out, BUNDLE, SUMS, CHALLENGE_FILE)) as work:
        work.begin()
        (work.new / DATA).mkdir(parents=True)
        tables = [f"{name}.parquet" for name in dataset.info.tables if not name.startswith("truth/")]
        for name in [INFO_FILE, *sorted(tables), README, CROISSANT]:
            if (dataset.folder / name).is_file():
                shutil.copyfile(dataset.folder / name, work.new / DATA / name)
        shutil.copyfile(folder / CHALLENGE_FILE, work.new / CHALLENGE_FILE)
        licence = f"{challenge.title}: the data in the folder data.\n\n{challenge.licence}\n"
        facts = {"challenge": challenge, "description": describe(dataset.info)}
        texts = {name: render(text, **facts) for name, text in ((README, "bundle.md"), ("RULES.md", "rules.md"))}
        write_files(work.new, texts | {"LICENCE.txt": licence})
        check_withheld(work.new / DATA)
        sums = "".join(f"{file_sha256(work.new / name)}  {name}\n" for name in _names(work.new))
        write_files(work.new, {SUMS: sums})
        work.publish()
    return [out, _pack(out, out.with_name(f"{out.name}.zip"), challenge.name)] if archive else [out]


def check_for_participant(submission: Path, folder: Path) -> str:
    """Check a submission against a participants' bundle, without truth; return what was found, for people.

    Raises VbbenchError with every fault, if there is any.
    """
    challenge = read_challenge(folder)
    checked = check(challenge, submission, Dataset(folder / DATA))
    missing = [name for name in NEEDED if not getattr(checked.info, name).strip()]
    missing += ["delay"] * (checked.info.delay is None)
    if missing:
        raise VbbenchError(f"{submission}/submission.json lacks {', '.join(missing)}; add it there")
    ready, send = f"{checked.table()}\nready for {challenge.name}", f"send the folder to {challenge.contact}"
    if checked.info.authors.strip() == NOBODY_YET:
        return f"{ready} but for its authors: say who you are in place of '{NOBODY_YET}', then {send}"
    return f"{ready}; {send}"


def _names(folder: Path) -> list[str]:
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file())


def _pack(folder: Path, path: Path, name: str) -> Path:
    """The archive of a folder: stored members in the order of their names, of one day, so that its bytes are fixed."""
    with replacing(path) as temporary, zipfile.ZipFile(temporary, "w", zipfile.ZIP_STORED) as archive:
        for member in _names(folder):
            facts = zipfile.ZipInfo(f"{name}/{member}", _THEN)
            facts.external_attr, facts.create_system = 0o644 << 16, 3
            archive.writestr(facts, (folder / member).read_bytes())
    return path
