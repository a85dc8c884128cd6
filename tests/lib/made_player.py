"""A page with nothing but the player, and crowds on it that nobody ever solved."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from tests.lib.made_sequence import DT, MadeSequence
from vbbench.estimate import Estimate
from vbbench.pictures.colours import PEOPLE_ON_DARK, PEOPLE_ON_LIGHT
from vbbench_leaderboards.site.pages import assets
from vbbench_leaderboards.site.player import encode_clip, encode_estimate, write_data

BOARD = "made/sequential-noisy"
CAPS = {"dx": 2.0, "dt": 2.0, "dr": 0.5}

MOUNT = """state => {
  const solvers = Object.keys(vbbench.made.boards["sequential-noisy"].solvers);
  const board = { key: "made/sequential-noisy", solvers: solvers.map((name, n) => ({ name, colour: n + 1 })) };
  vbbench.player.mount(document.getElementById("player"), { board, state });
}"""
"""Mounts the player on the page; `state` is what an address would hold."""


def write_crowd(site: Path, made: MadeSequence, answers: Mapping[str, Estimate]) -> None:
    """Write the data of one board with one sequence, 0, and these answers to it, by the names of their solvers."""
    clip = encode_clip(made.camera, DT, made.sequence, made.truth)
    write_data(site, "made/noisy/0", clip)
    for name, answer in answers.items():
        values = encode_estimate(made.truth, answer)
        write_data(site, f"{BOARD}/0/{name}", values)
    figures = {name: {"dx": [0.1 * (n + 1)], "dt": [0.1]} for n, name in enumerate(answers)}
    board = {"tier": "noisy", "given": "arrivals", "caps": CAPS, "solvers": figures}
    frames, people = made.sequence.observed.shape
    index = {"split": "made", "truth": "whole", "sequences": [0], "people": [people], "frames": [frames]}
    palette = {"light": PEOPLE_ON_LIGHT, "dark": PEOPLE_ON_DARK}
    write_data(site, "made", {**index, "palette": palette, "pictures": {}, "boards": {"sequential-noisy": board}})


def write_page(site: Path) -> None:
    """A page with the player's script and styles, and the colours of the site."""
    own = {name.removeprefix("assets/"): text for name, text in assets().items()}
    scripts = [
        own["page.js"],
        own["player.js"],
        'vbbench.load("player/made").then((index) => { vbbench.made = index; });',
    ]
    text = "".join(f"<script>{script}</script>" for script in scripts)
    style = "".join(own[f"{name}.css"] for name in ("page", "colours", "player"))
    head = f"<!doctype html><html lang=en><meta charset=utf-8><title>Player</title><style>{style}</style>"
    width = "<meta name=viewport content='width=device-width'>"
    page = f"{head}{width}<body><main><h1>Player</h1><div id=player></div></main>{text}"
    (site / "index.html").write_text(page, encoding="utf-8")


def with_false_alarm(made: MadeSequence, track: int) -> MadeSequence:
    """The same where nobody is behind a track: its boxes show nobody."""
    positions = np.array(made.truth.positions)
    positions[:, track] = np.nan
    return replace(made, truth=replace(made.truth, positions=positions))


def gone_astray(made: MadeSequence, first: int, offset: tuple[float, float], error: float = 0.02) -> Estimate:
    """An answer that is nearly true, and from frame ``first`` on off by ``offset`` m."""
    answer = made.estimate(np.random.default_rng(1), error)
    poses, positions = np.array(answer.poses), np.array(answer.positions)
    poses[first:, :2] += offset
    positions[first:] += offset
    return Estimate(poses=poses, positions=positions)
