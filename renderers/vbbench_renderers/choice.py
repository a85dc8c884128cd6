"""Which backend draws: the best that works, with the reason; registered as renderer ``auto``."""

from vbbench.camera import Camera
from vbbench.geometry import FloatArray
from vbbench.pictures.rendering import Picture, Renderer
from vbbench.registry import load
from vbbench.scene import Scene
from vbbench_renderers.opengl.probing import PACKAGE, OpenGLError, find_device


def choose_backend() -> tuple[str, str]:
    """``moderngl`` where OpenGL works, else ``raster``; and why it is that one."""
    try:
        find_device()
        return "moderngl", "the best that works here"
    except OpenGLError as error:
        return "raster", f"OpenGL does not work here: {error.problem}; 'apt-get install {PACKAGE}' would fix that"


class AutoRenderer:
    """The best backend that works on this machine; see `vbbench.pictures.rendering.RendererFactory`."""

    def __init__(self, scene: Scene, *, seed: int = 0, surroundings: bool = True) -> None:
        name, self._reason = choose_backend()
        self._renderer: Renderer = load("renderer", name)(scene, seed=seed, surroundings=surroundings)
        self._name = name

    @property
    def device(self) -> str:
        """The backend, what it draws with, and why it was chosen."""
        return f"{self._renderer.device}; {self._name}: {self._reason}"

    def render(self, frame: int, camera: Camera, pose: FloatArray, *, observer: int | None = None) -> Picture:
        """See `vbbench.pictures.rendering.Renderer.render`."""
        return self._renderer.render(frame, camera, pose, observer=observer)

    def close(self) -> None:
        """See `vbbench.pictures.rendering.Renderer.close`."""
        self._renderer.close()
