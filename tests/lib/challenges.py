"""A small challenge to take part in, for tests: made once, copied where it is changed."""

import json
import os
import shlex
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from vbbench.cli import main
from vbbench.files.dataset import Dataset
from vbbench.generation import generate
from vbbench.generation.generator import Options
from vbbench_leaderboards.challenge import definition
from vbbench_leaderboards.challenge.definition import parse_moment
from vbbench_leaderboards.challenge.organiser import Organiser

SECRET = 0xC0FFEE << 100
"""A seed that nobody guesses, the same in every run."""

TEXT = """
name = "tiny"
title = "A tiny challenge"
organisers = "Somebody"
contact = "somebody@example.org"
licence = "CC BY 4.0"
protocol = "sequential"
baseline = ""
rules = ["Be kind."]
[data]
split = "sim"
tier = "noisy"
options = "--sequences 12 --options people=4:6"
[[phases]]
name = "development"
part = "public"
start = 2026-12-01
end = 2026-12-31
submissions = 3
[[phases]]
name = "final"
part = "hidden"
start = 2027-02-01
end = 2027-02-07
submissions = 2
[[teams]]
name = "honest"
[[teams]]
name = "cheat"
members = "M. Allory"
"""
FACTS = ["--about", "authors=somebody", "trained_on=nothing", "tuned_on=nothing", "delay=0"]


@contextmanager
def on(day: str) -> Iterator[None]:
    """Commands run as if it were this day or moment, in UTC."""
    moment = parse_moment(day)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(definition, "now", lambda: moment)
        yield


def vbbench(*words: object) -> int:
    """``vbbench …`` in this process; its exit status."""
    return main([str(word) for word in words])


def make_challenge(folder: Path) -> Path:
    """The organiser's folder, with its secret set; the answers of cv and sf lie next to it."""
    assert vbbench("challenge", "new", folder) == 0
    (folder / "challenge.toml").write_text(TEXT, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("vbbench.files.withholding.draw_seed", lambda: SECRET)
        assert vbbench("challenge", "generate", folder) == 0
    for solver in ("cv", "sf"):
        words = ["--solver", solver, "--protocol", "sequential", "--out", folder.parent / solver]
        assert vbbench("solve", folder / "data", *words) == 0
    return folder


def withheld_challenge(folder: Path, split: str, options: Options) -> Path:
    """A challenge whose secret set has such options."""
    text = TEXT.replace('"sim"', f'"{split}"').replace('"noisy"', f'"{options.tier}"')
    folder.mkdir()
    (folder / "challenge.toml").write_text(text, encoding="utf-8")
    generate(split, folder / "data", replace(options, seed=SECRET), withhold_truth=True)
    return folder


def memorised(folder: Path, answer: Path, out: Path) -> Path:
    """An answer in which the public part is its truth: what a team would hand in that had got hold of it."""
    organiser = Organiser(folder)
    dataset = Dataset(organiser.data, organiser.truth)
    tables = {name: pd.read_parquet(answer / f"{name}.parquet") for name in ("poses", "positions")}
    for number in organiser.parts["public"].tolist():
        sequence = dataset.sequence(number)
        truth = dataset.truth(sequence)
        for name, columns in (("poses", ["x", "y", "yaw"]), ("positions", ["x", "y"])):
            table = tables[name]
            rows = (table["sequence"] == number).to_numpy()
            frame = table.loc[rows, "frame"].to_numpy()
            if name == "poses":
                table.loc[rows, columns] = truth.poses[frame]
            else:
                track = np.searchsorted(sequence.tracks, table.loc[rows, "track"].to_numpy())
                table.loc[rows, columns] = truth.positions[frame, track]
    out.mkdir()
    for name, table in tables.items():
        table.to_csv(out / f"{name}.csv", index=False)
    (out / "submission.json").write_bytes((answer / "submission.json").read_bytes())
    return out


def declared(answer: Path, **facts: Any) -> Path:
    """An answer whose submission.json says something else."""
    path = answer / "submission.json"
    path.write_text(json.dumps({**json.loads(path.read_text("utf-8")), **facts}), encoding="utf-8")
    return answer


def run_lines(lines: list[str]) -> None:
    """Run command lines as a reader would, from the present folder on."""
    for line in lines:
        program, *words = shlex.split(line)
        if program == "cd":
            os.chdir(words[0])
        elif program == "unzip":
            with zipfile.ZipFile(words[0]) as archive:
                archive.extractall()
        else:
            assert program == "vbbench", line
            assert vbbench(*words) == 0, line
