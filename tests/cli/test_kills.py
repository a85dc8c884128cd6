"""Killed anywhere, or on a full disk: nothing is lost, nothing is half, and the same command makes the same bytes.

One command of every way of writing is rehearsed (`SCENARIOS`): stopped at all its moments, and at all at which the disk
can fill up.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import pytest

from tests.lib.challenges import withheld_challenge
from tests.lib.kill_harness import Command, Point, Rehearsal, Scenario, Stage
from tests.lib.system_calls import why_not

pytestmark = [pytest.mark.slow, pytest.mark.skipif(why_not() is not None, reason=str(why_not()))]

SEED = 0xC0FFEE << 100
"""Of the withheld datasets: one that nobody guesses."""

WALK = Path(__file__).parents[1] / "lib" / "short_walk.toml"
SIM = f"generate sim --options scenario={WALK} --camera panorama"
SECRET = f"{SIM} --withhold-truth --seed"


def make_tiny() -> int:
    """A challenge with its secret set."""
    from vbbench.generation.generator import Options

    withheld_challenge(Path("tiny"), "sim", Options(limit=3))
    return 0


def accept_tiny() -> int:
    """Take a submission into it, at a time that is the same in every run."""
    from vbbench.cli import main
    from vbbench_leaderboards.challenge import submissions

    submissions.parse_moment = lambda _text: datetime(2026, 12, 2, tzinfo=UTC)
    words = "challenge accept tiny-answer --challenge tiny --team honest --date 2026-12-02"
    return main(words.split())


ADD = "leaderboard add plaza-answers --dataset plaza"
RENDER = "render data --sequence 0 --backend tests.lib.flat_renderer:FlatRenderer"

SCENERY = {
    "data": f"{SIM} --out data",
    "other": f"{SIM} --seed 7 --out other",
    "secret": f"{SECRET} {SEED} --out secret",
    "plaza": "generate demo --limit 1 --out plaza",
    "others": "solve data --solver vb-cv --protocol sequential --out others",
    "plaza-answers": "solve plaza --solver cv --out plaza-answers",
    "board": f"{ADD} --results board --name first",
    "old-board": f"{ADD} --results old-board --reference old",
    "site": "leaderboard build --results old-board --out site",
    "tiny": make_tiny,
    "tiny-answer": "solve tiny/data --solver cv --protocol sequential --out tiny-answer",
}
"""What the rehearsed commands find: commands by the name of what they make."""


def finding(*names: str, **others: str) -> dict[str, str]:
    return {name: name for name in names} | {name.replace("_", "."): other for name, other in others.items()}


def making_data(command: Command, **found: str) -> Scenario:
    return Scenario(command=command, found=finding(**found), whole=("out",), read="verify out")


def making_secrets(command: Command, **found: str) -> Scenario:
    return Scenario(
        command=command, found=finding(**found), whole=("out", "out.truth"), read="verify out --truth out.truth"
    )


def making_answers(command: Command, **found: str) -> Scenario:
    return Scenario(command=command, found=finding("data", **found), whole=("out",), read="score out --dataset data")


SCENARIOS: dict[str, Scenario] = {
    "generate --overwrite": making_data(f"{SIM} --out out --overwrite", out="other"),
    "generate --withhold-truth --overwrite": making_secrets(
        f"{SECRET} {SEED + 1} --out out --overwrite", out="secret", out_truth="secret.truth"
    ),
    "generate --scheduler": making_data(f"{SIM} --out out --scheduler here"),
    "solve --overwrite": making_answers("solve data --solver cv --out out --overwrite", out="others"),
    "card": Scenario(command="card data --creator Somebody --overwrite", found=finding("data")),
    "leaderboard add --overwrite": Scenario(
        command=f"{ADD} --results board --overwrite", found=finding("plaza", "plaza-answers", board="old-board")
    ),
    "leaderboard build": Scenario(
        command="leaderboard build --results board --out site", found=finding("board", "site"), whole=("site",)
    ),
    "challenge bundle": Scenario(
        command="challenge bundle tiny --out out --archive", found=finding("tiny"), whole=("out",)
    ),
    "challenge accept": Scenario(command=accept_tiny, found={"tiny": "tiny", "tiny-answer": "tiny-answer"}),
    "export mot": Scenario(command="export mot data --out out", found=finding("data")),
    "render": Scenario(command=f"{RENDER} --out film", found=finding("data")),
}
"""One command of every way of writing."""


@pytest.fixture(scope="module")
def stage() -> Iterator[Stage]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("VBBENCH_DATA", "cache")
        patch.setenv("XDG_CACHE_HOME", "cache")
        made = Stage(SCENERY)
        yield made
        made.close()


def spread(points: Sequence[Point], count: int) -> list[Point]:
    """So many of them: the last, at which most is replaced and removed, and others evenly over the run."""
    last, others = points[-2:], points[:-2]
    step = max(len(others) // max(count - 2, 1), 1)
    return [*others[step // 2 :: step][: count - 2], *last]


@pytest.mark.parametrize("name", SCENARIOS)
def test_killed_at_every_moment(stage: Stage, name: str) -> None:
    rehearsal = Rehearsal.of(stage, SCENARIOS[name])
    assert stage.run(rehearsal.scenario.command, rehearsal.found).left == rehearsal.run.left, "two runs differ"
    check(rehearsal.faults_when_killed(rehearsal.moments))
    check(rehearsal.faults_on_a_full_disk(rehearsal.steps_that_take_space))


@pytest.mark.parametrize("name", ["generate --withhold-truth --overwrite", "generate --scheduler", "export mot"])
def test_killed_and_killed_again(stage: Stage, name: str) -> None:
    first = Rehearsal.of(stage, SCENARIOS[name])
    for point in spread(first.moments, 4):
        second = replace(first, run=replace(stage.record(first.scenario.command, point.left), left=first.run.left))
        check([f"{point.what}, then {fault}" for fault in second.faults_when_killed(spread(second.moments, 6))])


def check(faults: list[str]) -> None:
    if faults:
        pytest.fail("\n".join(faults), pytrace=False)
