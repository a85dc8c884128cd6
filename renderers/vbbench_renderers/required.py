"""What every renderer needs to be installed; importing this says so if anything is missing."""

from importlib.util import find_spec

from vbbench.errors import needs_extra

with needs_extra("render", "rendering pictures of people"):
    for _package in ("cv2", "trimesh"):  # not imported before they are used
        if find_spec(_package) is None:
            raise ModuleNotFoundError(f"No module named '{_package}'", name=_package)
