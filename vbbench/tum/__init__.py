"""Poses to and from TUM trajectory files, one file a sequence or a whole dataset."""

from vbbench.tum.file import export_tum, import_tum
from vbbench.tum.folder import export_dataset_tum, import_tum_folder

__all__ = ["export_dataset_tum", "export_tum", "import_tum", "import_tum_folder"]
