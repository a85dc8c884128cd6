"""Networks of ONNX files, run by ONNX Runtime where it is installed (extra ``onnx``), else by OpenCV."""

from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from vbbench.errors import FileError
from vbbench.geometry import FloatArray
from vbbench_renderers.onnx_header import OnnxHeader

FLOAT32, FLOAT16 = 1, 10
"""Types of numbers in onnx.proto3."""
TARGET_SIZE = "orig_target_sizes"
"""The second input of D-FINE and RT-DETR: [1, 2] width and height in px in which they write boxes."""


class Network(Protocol):
    """A network that is ready to run."""

    def run(self, pictures: NDArray[np.float32]) -> dict[str, FloatArray]:
        """The outputs by name for one picture [1, 3, H, W].

        Raises
        ------
        FileError
            If the network cannot be run on such a picture.
        """


def open_network(path: Path, header: OnnxHeader) -> Network:
    """Load the network of a file.

    Raises
    ------
    FileError
        If the network takes something other than one picture of floats, or cannot be loaded.
    """
    if header.number_type not in (FLOAT32, FLOAT16):
        kind = {2: "uint8", 3: "int8", 11: "float64"}.get(header.number_type, f"type {header.number_type}")
        raise FileError(path, f"its input takes numbers of {kind}; export it with an input of float32 or float16")
    if set(header.inputs[1:]) - {TARGET_SIZE}:
        raise FileError(path, f"it has the inputs {', '.join(header.inputs)}; wanted: one, a picture")
    try:
        import onnxruntime
    except ImportError:
        return _OpenCvNetwork(path)
    return _RuntimeNetwork(path, header, onnxruntime)


class _RuntimeNetwork:
    """A network in ONNX Runtime, on the processor."""

    def __init__(self, path: Path, header: OnnxHeader, onnxruntime: Any) -> None:
        self._path, self._inputs = path, header.inputs
        self._type = np.float16 if header.number_type == FLOAT16 else np.float32
        options = onnxruntime.SessionOptions()
        options.log_severity_level = 4  # what is wrong is raised, too
        try:
            self._session = onnxruntime.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])
        except Exception as error:  # its errors have no public base class
            raise FileError(path, f"ONNX Runtime cannot read this network: {_reason(error)}") from None
        self._outputs = [one.name for one in self._session.get_outputs()]

    def run(self, pictures: NDArray[np.float32]) -> dict[str, FloatArray]:
        height, width = pictures.shape[2:]
        given: dict[str, Any] = {self._inputs[0]: pictures.astype(self._type, copy=False)}
        given |= dict.fromkeys(self._inputs[1:], np.array([[width, height]], np.int64))
        try:
            outputs = self._session.run(self._outputs, given)
        except Exception as error:
            problem = f"ONNX Runtime cannot run this network on {width} x {height} px: {_reason(error)}"
            raise FileError(self._path, problem) from None
        return {name: np.asarray(one, np.float64) for name, one in zip(self._outputs, outputs, strict=True)}


class _OpenCvNetwork:
    """A network in OpenCV's module dnn."""

    def __init__(self, path: Path) -> None:
        import cv2

        self._path = path
        try:
            self._net = cv2.dnn.readNetFromONNX(str(path))
        except cv2.error as error:
            raise FileError(path, f"OpenCV cannot read this network: {_reason(error)}; {_OTHER}") from None

    def run(self, pictures: NDArray[np.float32]) -> dict[str, FloatArray]:
        import cv2

        try:
            self._net.setInput(pictures)
            names = self._net.getUnconnectedOutLayersNames()
            outputs = self._net.forward(names)
        except cv2.error as error:
            size = f"{pictures.shape[3]} x {pictures.shape[2]} px"
            problem = f"OpenCV cannot run this network on {size}: {_reason(error)}; {_OTHER}"
            raise FileError(self._path, problem) from None
        return {name: np.asarray(one, np.float64) for name, one in zip(names, outputs, strict=True)}


_OTHER = "ONNX Runtime may: python -m pip install 'vbbench[onnx]'"


def _reason(error: Exception) -> str:
    """The first line of a library's message."""
    return str(error).strip().splitlines()[0].removeprefix("OpenCV").removeprefix("[ONNXRuntimeError] :").strip()
