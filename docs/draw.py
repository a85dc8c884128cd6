"""Draws the pictures of README and docs: ``python docs/draw.py [NAME ...]``; without names, those that are out of date.

``docs/pictures.toml`` says how each is made and which files it shows; ``docs/images/shown.json`` has the SHA-256 of
these files, and of the command, from when it was drawn. Folders that pictures are made from are kept in ``--work``.
"""

import argparse
import hashlib
import json
import os
import shlex
import subprocess
import sys
import tomllib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
IMAGES = ROOT / "docs" / "images"
LISTED, SHOWN = ROOT / "docs" / "pictures.toml", IMAGES / "shown.json"
HOW = ("run", "page", "frames", "part", "by_hand")
FILM_FRAMES, FILM_SIZE, FILM_STEP = 30, (720, 294), 3
"""Of the film: pictures, px, and frames of the film from one to the next."""

LARGEST, MARGIN, PART_HEIGHT = 390_000, 12, 460
"""Bytes of a picture, px above and below a part of a page, and the height in px of a part of a frame."""

Picture = dict[str, Any]


def pictures() -> tuple[dict[str, str], dict[str, Picture]]:
    """Commands of folders, and every picture by its name."""
    listed = tomllib.loads(LISTED.read_text("utf-8"))
    return listed.pop("made"), listed


def digest(picture: Picture, made: dict[str, str]) -> str:
    """SHA-256 of how a picture is made, and of the files that it shows, by name."""
    how = {key: picture[key] for key in HOW if key in picture}
    found = hashlib.sha256(json.dumps([how, [made[name] for name in picture.get("from", ())]]).encode())
    for pattern in picture["shows"]:
        for path in sorted(ROOT.glob(pattern)):
            found.update(f"{path.relative_to(ROOT).as_posix()}\n".encode() + path.read_bytes().replace(b"\r\n", b"\n"))
    return found.hexdigest()


def drawn() -> dict[str, str]:
    """The digest of each picture when it was drawn."""
    return json.loads(SHOWN.read_text("utf-8")) if SHOWN.is_file() else {}


def stale() -> list[str]:
    """The names of pictures whose files have changed since they were drawn, or that were never drawn."""
    (made, listed), known = pictures(), drawn()
    return [name for name, picture in listed.items() if known.get(name) != digest(picture, made)]


def record(names: list[str]) -> None:
    """Note what these pictures show now."""
    made, listed = pictures()
    known = drawn() | {name: digest(listed[name], made) for name in names}
    SHOWN.write_text(json.dumps({name: known[name] for name in sorted(known) if name in listed}, indent=1) + "\n")


def draw(name: str, work: Path) -> None:
    """Make the folders that are missing, then the picture."""
    made, listed = pictures()
    picture = listed[name]
    out = IMAGES / picture["file"]
    for folder in picture.get("from", ()):
        if not (work / folder).exists():
            run(made[folder], work)
    if "frames" in picture:
        frames = sorted((work / picture["frames"]).glob("*.png"))
        from_frames(frames, out, picture.get("at", 0), picture.get("part"))
    elif "page" in picture:
        site, address, *parts = picture["page"]
        take(work / site, address, out, parts)
    else:
        run(picture["run"].replace("PICTURE", str(out)), work)
        if "PICTURE" not in picture["run"]:  # a study's, named after it
            made_there = [*(work / "reproduced").rglob(f"*{out.name}")]
            if not made_there:
                raise FileNotFoundError(f"{picture['run']} made no picture {out.name}")
            out.write_bytes(made_there[0].read_bytes())
    small(out)


def run(command: str, work: Path) -> None:
    """Run a command of vbbench or Python in the work folder."""
    program, *words = shlex.split(command)
    start = [sys.executable, "-m", "vbbench"] if program == "vbbench" else [sys.executable]
    sys.stderr.write(f"{command}\n")
    path = os.pathsep.join([str(ROOT), *filter(None, sys.path[1:])])
    subprocess.run([*start, *words], cwd=work, check=True, env={**os.environ, "PYTHONPATH": path})


def from_frames(frames: list[Path], out: Path, at: int, part: Sequence[int] | None = None) -> None:
    """The frame ``at`` of a film, or a part (left, top, right, bottom) of it, or a short film from there."""
    from PIL import Image

    if out.suffix == ".png":
        frame = Image.open(frames[at])
        if part is not None:
            frame = frame.crop((part[0], part[1], part[2], part[3]))
            frame = frame.resize((round(frame.width * PART_HEIGHT / frame.height), PART_HEIGHT))
        frame.save(out)
        return
    shown = [Image.open(frame).resize(FILM_SIZE) for frame in frames[at:][: FILM_FRAMES * FILM_STEP : FILM_STEP]]
    shown[0].save(out, save_all=True, append_images=shown[1:], duration=40 * FILM_STEP, loop=0, quality=42, method=6)


def take(site: Path, address: str, out: Path, parts: Sequence[str]) -> None:
    """A built page as a browser shows it: the window, or what reaches from one part to another."""
    sys.path.insert(0, str(ROOT))
    from playwright.sync_api import sync_playwright

    from tests.lib.browsing import launch, visit

    with sync_playwright() as playwright:
        browser = launch(playwright)
        with visit(browser, site, viewport={"width": 1184, "height": 986}) as visitor:
            page = visitor.open(address)
            page.wait_for_timeout(600)
            page.evaluate("window.scrollTo(0, 0)")
            clip = None
            if parts:
                first, last = (page.locator(part).first.bounding_box() or {} for part in parts)
                top, bottom = first["y"] - MARGIN, last["y"] + last["height"] + MARGIN
                clip = {"x": 0, "y": top, "width": 1184, "height": bottom - top}
            page.screenshot(path=out, full_page=bool(parts), clip=clip)
        browser.close()


def small(out: Path) -> None:
    """Make a picture that is too large smaller: fewer colours, then fewer px."""
    from PIL import Image

    with Image.open(out) as picture:
        picture.load()
    while out.suffix == ".png" and out.stat().st_size > LARGEST:
        full = picture.convert("RGB")
        palette = full.quantize(method=Image.Quantize.FASTOCTREE)
        full.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG).save(out, optimize=True)
        picture = picture.resize((int(0.85 * picture.width), int(0.85 * picture.height)), Image.Resampling.LANCZOS)


def main() -> int:
    """Draw or record; the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument(
        "names", nargs="*", choices=[*pictures()[1], []], metavar="NAME", help="default: those out of date"
    )
    parser.add_argument("--work", type=Path, default=ROOT / "out" / "pictures", help="folder to work in; it is kept")
    parser.add_argument("--record", action="store_true", help="draw nothing: these were looked at, and show what is")
    asked = parser.parse_args()
    names = asked.names or stale()
    asked.work.mkdir(parents=True, exist_ok=True)
    for name in names:
        by_hand = pictures()[1][name].get("by_hand")
        if by_hand and not asked.record:
            sys.stderr.write(f"{name} is drawn by hand: {by_hand}; then run 'python docs/draw.py --record {name}'\n")
            continue
        if not asked.record:
            draw(name, asked.work)
        record([name])
    return 0


if __name__ == "__main__":
    sys.exit(main())
