"""Which backend draws when OpenGL works, is missing, crashes or hangs."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from vbbench.camera import PerspectiveCamera
from vbbench.errors import VbbenchError
from vbbench.registry import registered
from vbbench.scene import Scene
from vbbench_renderers.choice import AutoRenderer, choose_backend
from vbbench_renderers.opengl import probing

BREAKAGES = ("__EGL_VENDOR_LIBRARY_DIRS", "LIBGL_DRIVERS_PATH")


@pytest.fixture(autouse=True)
def fresh() -> Iterator[None]:
    probing._ask.cache_clear()
    yield
    probing._ask.cache_clear()


def broken_module(folder: Path, monkeypatch: pytest.MonkeyPatch, body: str) -> None:
    (folder / "moderngl.py").write_text(body, "utf-8")
    monkeypatch.setenv("PYTHONPATH", str(folder))


def test_all_backends_are_registered() -> None:
    assert {"auto", "moderngl", "pyrender", "raster"} <= set(registered("renderer"))


@pytest.mark.parametrize("variable", BREAKAGES)
def test_without_a_driver_raster_draws_and_the_package_is_named(
    variable: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in BREAKAGES:
        monkeypatch.setenv(name, str(tmp_path))
    name, reason = choose_backend()
    assert name == "raster"
    assert "mesa-utils-bin" in reason
    assert "\n" not in reason


@pytest.mark.parametrize(
    ("body", "problem"),
    [
        ("import os, signal\nos.kill(os.getpid(), signal.SIGSEGV)", "crashed (SIGSEGV)"),
        ("raise ImportError('libGL.so.1 is not there.')", "libGL.so.1 is not there"),
        ("import os\nos._exit(3)", "status 3"),
    ],
)
def test_a_driver_that_crashes_takes_only_the_child_down(
    body: str, problem: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken_module(tmp_path, monkeypatch, body)
    name, reason = choose_backend()
    assert (name, problem in reason) == ("raster", True), reason


def test_a_driver_that_hangs_is_given_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    broken_module(tmp_path, monkeypatch, "import time\ntime.sleep(60)")
    monkeypatch.setattr(probing, "PATIENCE", 1.0)
    name, reason = choose_backend()
    assert name == "raster"
    assert "did not answer within 1 s" in reason


def test_asked_for_by_name_without_opengl_is_an_error_that_says_what_to_do(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken_module(tmp_path, monkeypatch, "raise OSError('no EGL')")
    with pytest.raises(VbbenchError, match=r"no EGL\. Install EGL.*mesa-utils-bin.*raster"):
        probing.find_device()


def test_the_question_is_asked_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    broken_module(tmp_path, monkeypatch, "raise OSError('no EGL')")
    first = choose_backend()
    monkeypatch.delenv("PYTHONPATH")
    assert choose_backend() == first


@pytest.mark.slow
def test_auto_draws_and_says_with_what_and_why(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    broken_module(tmp_path, monkeypatch, "raise OSError('no EGL')")
    scene = Scene(name="one", dt=0.1, people=[3], positions=np.array([[[0.0, 3.0]]]), heights=[1.7])
    renderer = AutoRenderer(scene, surroundings=False)
    assert "raster: OpenGL does not work here: no EGL" in renderer.device
    camera = PerspectiveCamera(width=64, height=48, focal=32.0, cx=32.0, cy=24.0)
    assert 3 in renderer.render(0, camera, np.array((0.0, 0.0, np.pi / 2))).ids
    renderer.close()
