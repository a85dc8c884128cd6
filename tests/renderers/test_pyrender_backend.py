"""The pyrender backend: its faults stay where they are mended, and it draws what it should."""

import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from tests.lib.standing_people import AHEAD, AROUND, ORIGIN, standing
from vbbench.camera import Camera
from vbbench.errors import VbbenchError
from vbbench.scene import Scene
from vbbench.sequence import NOBODY
from vbbench_renderers.pyrender_backend import PyrenderRenderer
from vbbench_renderers.raster import RasterRenderer

pytestmark = pytest.mark.extra("pyrender")
PLACES = [(3.0, 0.0), (4.0, 1.0), (-3.0, 0.05), (1.0, -4.0)]
EMPTY = 2
"""The frame in which nobody is."""


def crowd() -> Scene:
    scene = standing(PLACES, EMPTY + 1)
    there = np.arange(EMPTY + 1)[:, None, None] < EMPTY
    return replace(scene, people=[3, 10, 300, 70000], positions=np.where(there, scene.positions, np.nan))


@pytest.fixture(scope="module")
def renderer() -> Iterator[PyrenderRenderer]:
    try:
        made = PyrenderRenderer(crowd())
    except VbbenchError as error:
        pytest.skip(str(error))
    yield made
    made.close()


def run_python(code: str, **environment: str) -> str:
    result = subprocess.run(
        [sys.executable, "-c", code], env={**os.environ, **environment}, capture_output=True, text=True, check=False
    )
    return result.stdout + result.stderr


@pytest.mark.parametrize("camera", [AHEAD, AROUND], ids=["perspective", "panorama"])
def test_it_shows_whom_the_raster_backend_shows(renderer: PyrenderRenderer, camera: Camera) -> None:
    theirs = RasterRenderer(crowd()).render(0, camera, ORIGIN, observer=10)
    ours = renderer.render(0, camera, ORIGIN, observer=10)
    assert set(np.unique(ours.ids)) == set(np.unique(theirs.ids)) == {NOBODY, 3, *([300, 70000] * (camera is AROUND))}
    assert (ours.ids == theirs.ids).mean() > 0.99
    assert (np.isinf(ours.depth) == np.isinf(theirs.depth)).mean() > 0.99
    apart = np.abs(ours.rgb.astype(float) - theirs.rgb.astype(float)).mean()
    assert apart < 40.0


def test_pictures_come_out_the_same_again(renderer: PyrenderRenderer) -> None:
    first = renderer.render(0, AHEAD, ORIGIN)
    renderer.render(1, AROUND, np.array([1.0, 0.5, 2.0]))
    second = renderer.render(0, AHEAD, ORIGIN)
    for name in ("rgb", "depth", "ids"):
        assert np.array_equal(getattr(first, name), getattr(second, name))


def test_nobody_at_all(renderer: PyrenderRenderer) -> None:
    picture = renderer.render(EMPTY, AHEAD, ORIGIN)
    assert (picture.ids == NOBODY).all()
    assert np.isfinite(picture.depth[-1]).all()


def test_unknown_observers_and_closed_renderers_are_refused(renderer: PyrenderRenderer) -> None:
    with pytest.raises(VbbenchError, match="no person 4"):
        renderer.render(0, AHEAD, ORIGIN, observer=4)
    assert "pyrender" in renderer.device


def test_the_viewer_is_never_imported_and_nothing_stays_patched(renderer: PyrenderRenderer) -> None:
    output = run_python(
        "import os, sys, numpy\n"
        "from vbbench_renderers.pyrender_backend import load_pyrender, open_off_screen\n"
        "screen = open_off_screen(8, 8)\n"
        "print('pyglet' in sys.modules, 'pyrender.viewer' in sys.modules, hasattr(numpy, 'infty'),\n"
        "      os.environ.get('PYOPENGL_PLATFORM'), hasattr(load_pyrender(), 'Viewer'))\n"
        "screen.delete()",
        DISPLAY="",
    )
    assert "False False False None False" in output


def test_a_platform_that_does_not_work_is_one_clear_message() -> None:
    output = run_python(
        "from vbbench.errors import VbbenchError\n"
        "from vbbench_renderers.pyrender_backend import open_off_screen\n"
        "try:\n"
        "    open_off_screen(8, 8)\n"
        "except VbbenchError as error:\n"
        "    print('refused:', error)",
        PYOPENGL_PLATFORM="egl",
        EGL_DEVICE_ID="77",
    )
    assert "refused: pyrender" in output
    assert "mesa-utils-bin" in output
