"""Commands that exchange boxes and trajectories with other tools: export csv, export and import mot and tum."""

from pathlib import Path

from vbbench.cli.evaluation import ProtocolName
from vbbench.cli.views import announce


def export_csv(folder: Path, /, out: Path) -> None:
    """Write a dataset's boxes and given positions as CSV, for programs that cannot read Parquet; truth is not written.

    Args:
        folder: The dataset.
        out: Folder to write into.
    """
    from vbbench.exchange.csv_export import export_csv as export
    from vbbench.files.dataset import Dataset

    print(export(Dataset(folder), out))


def export_tum(folder: Path, /, out: Path, submission: Path | None = None) -> None:
    """Write poses as TUM trajectory files, one per sequence.

    Args:
        folder: The dataset.
        out: Folder to write into.
        submission: Write this submission's poses instead of the true ones.
    """
    from vbbench.exchange.tum import export_dataset_tum
    from vbbench.files.dataset import Dataset

    print(export_dataset_tum(Dataset(folder), out, submission))


def import_tum(files: Path, /, dataset: Path, out: Path, solver: str, protocol: ProtocolName = "sequential") -> None:
    """Make a submission's poses from a folder of TUM trajectory files.

    Args:
        files: Folder with one file per sequence, as 'export tum' names them.
        dataset: The dataset that they answer.
        out: Submission folder to make.
        solver: Name of the solver.
        protocol: Protocol under which it ran.
    """
    from vbbench.exchange.tum import import_tum_folder
    from vbbench.files.dataset import Dataset

    print(import_tum_folder(files, Dataset(dataset), out, solver=solver, protocol=protocol))


def export_mot(
    folder: Path,
    /,
    out: Path,
    sequence: int | None = None,
    backend: str | None = None,
) -> None:
    """Write boxes, and rendered pictures, as one MOTChallenge folder per sequence.

    Args:
        folder: The dataset.
        out: Folder to write into.
        sequence: Number of the only sequence to write.
        backend: Also render the pictures, without marks, for your own detector and tracker: auto, or a renderer as of
            'vbbench render'. Default: no pictures.
    """
    from vbbench.exchange.mot import export_mot as export
    from vbbench.files.dataset import Dataset
    from vbbench.pictures.rendering import Backend

    drawn_by = None if backend is None else Backend(name=backend)
    print(export(Dataset(folder), out, sequence=sequence, backend=drawn_by, announce=announce))


def import_mot(
    files: Path,
    /,
    dataset: Path,
    out: Path,
    least_matched: float = 0.5,
    least_track: int = 3,
    person_class: str | None = None,
    overwrite: bool = False,
) -> None:
    """Make a dataset of tier tracked from a tracker's files: MOTChallenge text, or any form that birdify reads.

    Args:
        files: Folder with sequence-000012.txt for sequence 12, and so on; or what 'export mot' makes.
        dataset: The dataset whose pictures were tracked.
        out: Dataset folder to make.
        least_matched: Share of the boxes that must match people; fewer are refused.
        least_track: Fewest frames in which a track that counts matches a person.
        person_class: Class of people in the files, by number or name, where they do not show it.
        overwrite: Replace an existing dataset.
    """
    from vbbench.exchange.mot import import_mot as make
    from vbbench.files.dataset import Dataset

    made = make(
        files,
        Dataset(dataset),
        out,
        least_matched=least_matched,
        least_track=least_track,
        person_class=person_class,
        overwrite=overwrite,
        announce=announce,
    )
    print(made.folder)
