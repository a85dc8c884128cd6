"""Commands that exchange trajectories with other tools: export tum, import tum."""

from pathlib import Path

from tyro.conf import Positional

from vbbench.cli.evaluation import ProtocolName


def export_tum(
    folder: Positional[Path], /, out: Path, submission: Path | None = None, truth: Path | None = None
) -> None:
    """Write poses as TUM trajectory files, one a sequence.

    Args:
        folder: The dataset.
        out: Folder to write into.
        submission: Write this submission's poses instead of the true ones.
        truth: Folder with the truth tables, where they are kept elsewhere.
    """
    from vbbench.dataset import Dataset
    from vbbench.tum import export_dataset_tum

    print(export_dataset_tum(Dataset(folder, truth), out, submission))


def import_tum(
    files: Positional[Path], /, dataset: Path, out: Path, solver: str, protocol: ProtocolName = "sequential"
) -> None:
    """Make a submission's poses from a folder of TUM trajectory files.

    Args:
        files: Folder with one file a sequence, as 'export tum' names them.
        dataset: The dataset that they answer.
        out: Submission folder to make.
        solver: What the solver is called.
        protocol: What it was given.
    """
    from vbbench.dataset import Dataset
    from vbbench.tum import import_tum_folder

    print(import_tum_folder(files, Dataset(dataset), out, solver=solver, protocol=protocol))
