"""Networks of ONNX files, run by ONNX Runtime (extra ``onnx``) on the processor."""

import ast
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vbbench.errors import FileError, needs_extra
from vbbench.geometry import FloatArray

NUMBERS = {"tensor(float)": np.float32, "tensor(float16)": np.float16}
"""Numbers that a network may take, by ONNX Runtime's names."""
TARGET_SIZE = "orig_target_sizes"
"""The second input of D-FINE and RT-DETR: [1, 2] width and height in px in which they write boxes."""


class OnnxNetwork:
    """The network of a file, which takes one picture of floats.

    Parameters
    ----------
    path : the ONNX file.

    Raises
    ------
    VbbenchError
        If ONNX Runtime is not installed, the file is missing or no network, or it takes something else.
    """

    def __init__(self, path: Path) -> None:
        with needs_extra("onnx", "a detector from an ONNX file"):
            import onnxruntime
        self._path = path
        options = onnxruntime.SessionOptions()
        options.log_severity_level = 4  # what is wrong is raised, too
        try:
            data = path.read_bytes()
            self._session = onnxruntime.InferenceSession(data, options, providers=["CPUExecutionProvider"])
        except OSError as error:
            raise FileError(path, f"cannot be read ({error.strerror}); name an ONNX file") from None
        except Exception as error:  # its errors have no public base class
            problem = f"ONNX Runtime cannot read this network: {_reason(error)}"
            raise FileError(path, f"{problem}; export yours again with format=onnx") from None
        first, *others = self._session.get_inputs()
        if first.type not in NUMBERS:
            raise FileError(path, f"its input takes {first.type}; export it with an input of float32 or float16")
        if {other.name for other in others} - {TARGET_SIZE}:
            names = ", ".join(one.name for one in (first, *others))
            raise FileError(path, f"it has the inputs {names}; wanted: one, a picture")
        self._name, self._type, self._others = first.name, NUMBERS[first.type], [other.name for other in others]
        self._outputs = [one.name for one in self._session.get_outputs()]
        self.shape = tuple(size if isinstance(size, int) and size > 0 else None for size in first.shape)
        """Of the input; ``None`` for a dimension that may be anything."""
        self.metadata: dict[str, str] = self._session.get_modelmeta().custom_metadata_map
        """Such as ``names``, the classes."""

    def class_names(self) -> dict[int, str]:
        """The names of the classes by number, as Ultralytics' exporter writes them; none if there are none."""
        try:
            return {int(number): str(name) for number, name in dict(self.value("names")).items()}
        except (ValueError, TypeError):
            return {}

    def value(self, name: str) -> Any:
        """An entry of the metadata that is written as Python has it; ``None`` if there is none."""
        try:
            return ast.literal_eval(self.metadata.get(name, "None"))
        except (ValueError, TypeError, SyntaxError, RecursionError, MemoryError):
            return None

    def run(self, pictures: NDArray[np.float32]) -> dict[str, FloatArray]:
        """The outputs by name for one picture [1, 3, H, W].

        Raises
        ------
        FileError
            If the network cannot be run on such a picture.
        """
        height, width = pictures.shape[2:]
        given: dict[str, Any] = {self._name: pictures.astype(self._type, copy=False)}
        given |= dict.fromkeys(self._others, np.array([[width, height]], np.int64))
        try:
            outputs = self._session.run(self._outputs, given)
        except Exception as error:
            problem = f"ONNX Runtime cannot run this network on {width} x {height} px: {_reason(error)}"
            raise FileError(self._path, problem) from None
        return {name: np.asarray(one, np.float64) for name, one in zip(self._outputs, outputs, strict=True)}


def _reason(error: Exception) -> str:
    """The first line of a library's message."""
    return str(error).strip().splitlines()[0].removeprefix("[ONNXRuntimeError] :").strip()
