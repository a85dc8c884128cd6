"""What the page's script reads from the player's data is what Python wrote."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from tests.lib.made_sequence import DT, made_sequence
from tests.lib.player_decoding import decode_clip, decode_estimate
from vbbench_leaderboards.site.pages import assets
from vbbench_leaderboards.site.player import encode_clip, encode_estimate, write_data

if TYPE_CHECKING:
    from playwright.sync_api import Browser

READ = """async () => {
  const { decodeClip, decodeEstimate } = vbbench.player;
  const clip = await decodeClip(vbbench.values["player/clip"]);
  const estimate = await decodeEstimate(vbbench.values["player/estimate"], clip);
  const plain = (values) => Array.from(values, (value) => (Number.isNaN(value) ? null : Number(value)));
  const all = (from, names) => Object.fromEntries(names.map((name) => [name, plain(from[name])]));
  return {
    clip: all(clip, ["known", "observed", "given", "x", "y", "yaw", "px", "py", "u", "v", "l"]),
    estimate: all(estimate, ["x", "y", "yaw", "px", "py"]),
  };
}"""


@pytest.mark.parametrize(
    ("people", "frames", "share", "error"), [(60, 99, 0.9, 0.1), (3, 2, 0.4, 30.0), (1, 1, 0.0, 0.0)]
)
def test_the_script_reads_what_python_wrote(
    browser: "Browser", tmp_path: Path, people: int, frames: int, share: float, error: float
) -> None:
    made = made_sequence(people, frames, share=share, far=4321.0)
    clip = encode_clip(made.camera, DT, made.sequence, made.truth)
    answer = made.estimate(np.random.default_rng(0), error)
    estimate = encode_estimate(made.truth, answer)
    got = read_in_browser(browser, tmp_path, {"clip": clip, "estimate": estimate})
    wanted = decode_clip(clip)
    for name in ("known", "observed", "given"):
        assert got["clip"][name] == wanted[name].ravel().tolist()
    for name, values in columns(wanted["poses"], wanted["positions"], wanted["boxes"]):
        assert same(got["clip"][name], values)
    for name, values in columns(*decode_estimate(estimate, wanted)):
        assert same(got["estimate"][name], values)


def columns(poses: Any, positions: Any, boxes: Any = None) -> Any:
    """Name in the script → the values that it stands for."""
    named = {"x": poses[:, 0], "y": poses[:, 1], "yaw": poses[:, 2], "px": positions[..., 0], "py": positions[..., 1]}
    if boxes is not None:
        named |= {"u": boxes[..., 0], "v": boxes[..., 1], "l": boxes[..., 2]}
    return named.items()


def same(got: list[float | None], wanted: Any) -> bool:
    return np.allclose(np.array(got, float), wanted.ravel(), rtol=0.0, atol=1e-9, equal_nan=True)


def read_in_browser(browser: "Browser", folder: Path, files: dict[str, dict[str, Any]]) -> Any:
    """A page with the player's script and these files, read by the script."""
    for name, values in files.items():
        write_data(folder, name, values)
    (folder / "player.js").write_text(assets()["assets/player.js"], encoding="utf-8")
    start = "window.vbbench = { values: {}, provide(key, value) { this.values[key] = value; } }"
    places = ["player.js", *(f"data/player/{name}.js" for name in files)]
    scripts = "".join(f'<script src="{place}"></script>' for place in places)
    (folder / "page.html").write_text(f"<!doctype html><meta charset=utf-8><script>{start}</script>{scripts}", "utf-8")
    page = browser.new_page()
    try:
        page.goto((folder / "page.html").as_uri())
        return page.evaluate(READ)
    finally:
        page.close()
