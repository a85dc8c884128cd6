"""A command is stopped at every step at which it changes files, and made again: what is then on the disk?

A killed process leaves on the disk what was there when it died. So one run, stopped ahead of every system call that
changes files (`tests.lib.system_calls`), shows what a kill at each of them leaves behind; nothing needs to be run to be
killed again. Calls that write one after the other to one file are one step, and half of what they write is one more
point: a file that ends in its middle.

Everything runs in forks of one warm process (`Stage`), so that a run costs some hundredths of a second. A `Rehearsal`
checks at each step what must hold wherever a command is killed, or the disk is full.
"""

import gc
import io
import os
import re
import shlex
import shutil
import stat
import sys
import tempfile
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import redirect_stderr, redirect_stdout, suppress
from dataclasses import dataclass, field
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from tests.lib.system_calls import TAKE_SPACE, WRITES, Answer, Call, run_alone, run_watched

Tree = dict[str, tuple[int, bytes]]
"""All below a folder, by relative path: mode, and the file's bytes or the link's target."""

Likeness = set[tuple[str, tuple[int, bytes]]]
"""The entries of a tree, but for what differs from run to run."""

Command = str | Callable[[], int]
"""A command line of vbbench, or a function that runs one in its own way and returns the exit status."""

SHARED_MEMORY = Path("/dev/shm")  # noqa: S108  a file system without a disk: flushing to it takes no time


@dataclass(frozen=True)
class Point:
    """A moment at which a run can be killed.

    Parameters
    ----------
    what : what the run was about to do, or was in the middle of.
    number : of the system call, from 0.
    takes_space : whether a full disk would refuse the call.
    begins_file : whether the call writes the first bytes of a file, half of which are a moment of their own.
    left : what a kill leaves on the disk.
    """

    what: str
    number: int
    takes_space: bool = False
    begins_file: bool = False
    left: Tree = field(repr=False, default_factory=dict)


@dataclass(frozen=True)
class Run:
    """How a command ended, what it said, and what it left; with ``points``, every moment of it."""

    status: int
    output: str
    errors: str
    left: Tree = field(repr=False)
    points: tuple[Point, ...] = ()


def read_tree(root: Path) -> Tree:
    """All below a folder."""
    tree: Tree = {}
    for folder, folders, files in os.walk(root):
        for name in [*folders, *files]:
            path = Path(folder, name)
            with suppress(FileNotFoundError):  # another process of the same command may have removed it
                mode = path.lstat().st_mode
                tree[str(path.relative_to(root))] = (mode, _content(path, mode))
    return dict(sorted(tree.items()))


def _content(path: Path, mode: int) -> bytes:
    if stat.S_ISLNK(mode):
        return os.fsencode(path.readlink())
    return path.read_bytes() if stat.S_ISREG(mode) else b""


def write_tree(tree: Tree, root: Path) -> None:
    """Make all of ``tree`` below a folder."""
    for name, (mode, content) in tree.items():
        path = root / name
        if stat.S_ISDIR(mode):
            path.mkdir()
        elif stat.S_ISLNK(mode):
            path.symlink_to(os.fsdecode(content))
        else:
            path.write_bytes(content)
        if not stat.S_ISLNK(mode):
            path.chmod(stat.S_IMODE(mode))


def below(tree: Tree, *names: str) -> Tree:
    """Those parts of a tree: the named files and folders, with all in them."""
    return {path: entry for path, entry in tree.items() if path.split("/")[0] in names}


def differences(tree: Tree, wanted: Tree) -> list[str]:
    """What of a tree is not as wanted."""
    missing = [f"{name} is missing" for name in wanted.keys() - tree.keys()]
    stray = [f"{name} is left over" for name in tree.keys() - wanted.keys()]
    other = [f"{name} differs" for name in wanted.keys() & tree.keys() if tree[name] != wanted[name]]
    return sorted(missing + stray + other)


def without_chance(tree: Tree) -> Likeness:
    """What is in a tree, its temporary names all alike, without what locks say of processes and times."""
    names = {name: re.sub(r"\.vbbench-(done-)?[0-9a-f]+", ".vbbench-", name) for name in tree}
    return {(names[name], entry) for name, entry in tree.items() if not name.endswith(".vbbench-lock")}


class Stage:
    """Runs commands, each in a fork of one warm process, in a folder that holds what it is to find.

    Parameters
    ----------
    scenery : command by the name of the folder or file that it makes, which the rehearsed commands then find.
    """

    def __init__(self, scenery: dict[str, str]) -> None:
        self._worker = ProcessPoolExecutor(1, mp_context=get_context("spawn"), initializer=_steady_clock)
        self.scenery: dict[str, Tree] = self._worker.submit(_make_scenery, scenery).result()

    def run(self, command: Command, found: Tree) -> Run:
        """Run a command undisturbed."""
        return self._worker.submit(_run, command, found).result()

    def record(self, command: Command, found: Tree) -> Run:
        """Run a command undisturbed, and say what a kill at every step of it would leave."""
        return self._worker.submit(_record, command, found).result()

    def fill_disk(self, command: Command, found: Tree, number: int) -> Run:
        """Have the disk be full from the system call of that number on."""
        return self._worker.submit(_fill_disk, command, found, number).result()

    def close(self) -> None:
        """End the warm process."""
        self._worker.shutdown()


def _steady_clock() -> None:
    """In the worker, before vbbench is imported: time goes on by 1/1024 s whenever one looks.

    The seconds that a submission declares are then the same in every run, and so are all its bytes.
    """
    import itertools
    import time

    assert "vbbench" not in sys.modules
    ticks = itertools.count()
    time.perf_counter = lambda: next(ticks) / 1024


def _make_scenery(scenery: dict[str, str]) -> dict[str, Tree]:
    """Run here, in the process that is forked later: what is imported now is so in every fork."""
    _keep_every_part()
    _be_the_cluster()
    _understand_each_command_once()
    with _folder({}, "scenery") as root:
        os.chdir(root)
        for command in scenery.values():
            status = _perform(command)
            if status != 0:
                raise RuntimeError(f"{command} ended with status {status}")
        whole = read_tree(root)
        os.chdir("/")
    return {name: below(whole, name) for name in {path.split("/")[0] for path in whole}}


def _keep_every_part() -> None:
    """A part a sequence, each kept in a file at once, so that a kill loses and leaves as much as it ever can."""
    from vbbench.files import sequence_tables
    from vbbench.parallel import parts

    assert sequence_tables.PART_SIZE >= 1
    assert parts.PATIENCE >= 0
    sequence_tables.PART_SIZE, parts.PATIENCE = 1, 0.0


def _be_the_cluster() -> None:
    """This process does what ``--scheduler`` has a cluster do, one part after the other."""
    from vbbench.parallel import cluster
    from vbbench.parallel.parts import Work, packed

    def one_by_one(work: Work, ranges: Sequence[tuple[int, int]], *_: object) -> Iterator[tuple[int, int, bytes]]:
        return ((first, last, packed(work(first, last))) for first, last in ranges)

    cluster.on_cluster = one_by_one


def _understand_each_command_once() -> None:
    """A command line that was read here is not read again in forks, where that is a third of the work."""
    from vbbench import cli

    read, calls = cli.parse, {}

    def parse(commands: Mapping[str, Callable[..., Any]], arguments: Sequence[str]) -> Callable[[], Any]:
        words = tuple(arguments)
        if words not in calls:
            calls[words] = read(commands, arguments)
        return calls[words]

    cli.parse = parse


_rehearsed: set[str] = set()


def _rehearse(command: Command, found: Tree) -> None:
    """Run a command line here, once, in a folder of its own: what is imported then is so in every fork."""
    if isinstance(command, str) and command not in _rehearsed:
        _rehearsed.add(command)
        with _folder(found, "rehearsal") as root, redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()):
            os.chdir(root)
            _perform(command)
            os.chdir("/")
        gc.collect()
        gc.freeze()  # a fork whose collector looks at what is here copies all of it


def _run(command: Command, found: Tree) -> Run:
    _rehearse(command, found)
    with _folder(found) as root:
        return _heard(command, root, run_alone)


def _record(command: Command, found: Tree) -> Run:
    _rehearse(command, found)
    with _folder(found) as root:
        recorder = _Recorder(root)
        run = _heard(command, root, lambda work: run_watched(work, root, recorder))
        recorder.finish()
    return Run(run.status, run.output, run.errors, run.left, tuple(recorder.points))


def _fill_disk(command: Command, found: Tree, number: int) -> Run:
    def before(call: Call) -> Answer:
        calls.append(call)
        return "refuse" if len(calls) > number and call.name in TAKE_SPACE else "do"

    calls: list[Call] = []
    with _folder(found) as root:
        return _heard(command, root, lambda work: run_watched(work, root, before))


@dataclass
class _Recorder:
    """Keeps what is on the disk ahead of every step of a run."""

    root: Path
    points: list[Point] = field(default_factory=list)
    _calls: int = 0
    _written: str = ""
    _before: Tree = field(default_factory=dict)

    def __call__(self, call: Call) -> Answer:
        number, self._calls = self._calls, self._calls + 1
        if call.name in WRITES and call.paths[0] == self._written:
            return "do"
        left = self._look()
        self._written = call.paths[0] if call.name in WRITES else ""
        begins_file = self._written in left and not left[self._written][1]
        self.points.append(Point(f"before {call}", number, call.name in TAKE_SPACE, begins_file, left))
        return "do"

    def finish(self) -> None:
        """The run has ended."""
        self.points.append(Point("after the last step", self._calls, left=self._look()))

    def _look(self) -> Tree:
        """What is there now; if something was written since the last step, half of that is a point of its own."""
        now = read_tree(self.root)
        if self._written in now:
            mode, content = now[self._written]
            start = len(self._before.get(self._written, (0, b""))[1])
            half = start + max(len(content) - start, 0) // 2
            cut = now | {self._written: (mode, content[:half])}
            number = self.points[-1].number
            self.points.append(Point(f"half-way in {self._written}", number, left=cut))
        self._before = now
        return now


def _heard(command: Command, root: Path, run: Callable[[Callable[[], int]], int]) -> Run:
    """Run a command in a fork, in ``root``, and keep what it says."""
    with tempfile.TemporaryFile() as output, tempfile.TemporaryFile() as errors:

        def work() -> int:
            os.chdir(root)
            os.dup2(output.fileno(), 1)
            os.dup2(errors.fileno(), 2)
            return _perform(command)

        status = run(work)
        said = [os.pread(file.fileno(), 1 << 24, 0).decode(errors="replace") for file in (output, errors)]
    return Run(status, *said, read_tree(root))


def _perform(command: Command) -> int:
    from vbbench.cli import main

    try:
        status: Any = main(shlex.split(command)) if isinstance(command, str) else command()
    except BaseException:
        traceback.print_exc()
        return 1
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
    return int(status)


class _folder:  # noqa: N801  used like a function
    """A folder for a block, with that in it; always of the same path, because a command that is made again is."""

    def __init__(self, tree: Tree, name: str = "stage") -> None:
        place = SHARED_MEMORY if os.access(SHARED_MEMORY, os.W_OK) else Path(tempfile.gettempdir())
        self.root = place.resolve() / f"vbbench-kills-{os.getpid()}-{name}"
        self.root.mkdir()
        write_tree(tree, self.root)

    def __enter__(self) -> Path:
        return self.root

    def __exit__(self, *_: object) -> None:
        shutil.rmtree(self.root)


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """A command, what it finds, and what must be whole at any moment.

    Parameters
    ----------
    command : what is run.
    found : what of the scenery it finds, by the name that it has for the command.
    whole : files and folders that change together, or not at all.
    read : the command by which a user opens them; ``None`` where they are read as files.
    """

    command: Command
    found: dict[str, str]
    whole: tuple[str, ...] = ()
    read: str | None = None


@dataclass(frozen=True)
class Rehearsal:
    """A scenario that has been played once to its end."""

    stage: Stage
    scenario: Scenario
    found: Tree
    run: Run
    _judged: list[tuple[Likeness, list[str]]] = field(default_factory=list, init=False, repr=False)
    """What was left on the disk, and what is wrong with it: many moments leave the same."""

    @classmethod
    def of(cls, stage: Stage, scenario: Scenario) -> "Rehearsal":
        found: Tree = {}
        for name, made in scenario.found.items():
            found |= {name + path[len(made) :]: entry for path, entry in stage.scenery[made].items()}
        run = stage.record(scenario.command, found)
        assert run.status == 0, run.errors
        return cls(stage, scenario, found, run)

    @property
    def moments(self) -> list[Point]:
        """The moments that leave something of their own on the disk."""
        seen: list[Tree] = [self.found]
        own = []
        for point in self.run.points:
            if not point.begins_file and point.left not in seen:
                seen.append(point.left)
                own.append(point)
        return own

    @property
    def steps_that_take_space(self) -> list[Point]:
        """The steps that a full disk refuses."""
        return [point for point in self.run.points if point.takes_space]

    def faults_when_killed(self, points: Sequence[Point]) -> list[str]:
        """What is wrong at these moments, and after the same command."""
        return [f"{point.what}: {fault}" for point in points for fault in self._faults_after(point.left)]

    def _faults_after(self, left: Tree) -> list[str]:
        """What is wrong with what is on the disk, and after the same command."""
        found = without_chance(left)
        for known, faults in self._judged:
            if known == found:
                return faults
        faults = [*self._faults_left(left), *self._faults_of_another_try(left)]
        self._judged.append((found, faults))
        return faults

    def faults_on_a_full_disk(self, points: Sequence[Point]) -> list[str]:
        """What is wrong when the disk is full from these moments on, and after the same command with space again."""
        return [f"full {point.what}: {fault}" for point in points for fault in self._faults_when_full(point)]

    def _faults_when_full(self, point: Point) -> list[str]:
        stopped = self.stage.fill_disk(self.scenario.command, self.found, point.number)
        if stopped.status == 0:
            return differences(stopped.left, self.run.left)
        return [*_faults_of_words(stopped), *self._faults_after(stopped.left)]

    def _faults_left(self, left: Tree) -> list[str]:
        found = self._faults_of_the_whole(left) if self.scenario.whole else self._faults_of_single_files(left)
        return [*found, *differences(below(left, *self._bystanders), below(self.found, *self._bystanders))]

    @property
    def _bystanders(self) -> list[str]:
        """What the command finds and leaves as it is."""
        names = {path.split("/")[0] for path in self.found}
        return [name for name in sorted(names) if below(self.found, name) == below(self.run.left, name)]

    def _faults_of_the_whole(self, left: Tree) -> list[str]:
        """It is as before or as afterwards; in between, who reads it finds either, or is refused and loses none."""
        if below(left, *self.scenario.whole) in self._versions:
            return []
        if self.scenario.read is not None:
            said = self.stage.run(self.scenario.read, left)
            if said.status == 0:
                return [] if self._holds_either(said.left) else [f"'{self.scenario.read}' takes a mixture"]
            if said.status != 2 or "Traceback" in said.errors:
                return [f"'{self.scenario.read}' ends with {said.status}: {said.errors}"]
        return [] if self._loses_nothing(left) else ["neither all of the old nor all of the new is on the disk"]

    def _holds_either(self, left: Tree) -> bool:
        """Whether all of the old or all of the new is in its place."""
        return any(version and version.items() <= left.items() for version in self._versions)

    def _loses_nothing(self, left: Tree) -> bool:
        """Whether all files of the old or of the new are on the disk, wherever that is."""
        kept = {content for _, content in left.values()}
        return any(kept.issuperset(content for _, content in version.values()) for version in self._versions)

    @property
    def _versions(self) -> tuple[Tree, Tree]:
        """The old and the new."""
        return below(self.found, *self.scenario.whole), below(self.run.left, *self.scenario.whole)

    def _faults_of_single_files(self, left: Tree) -> list[str]:
        """Every file is as before or as afterwards; what has another name is a draft."""
        return [
            f"{name} is neither old nor new"
            for name, after in below(self.run.left, *self._changing).items()
            if left.get(name) not in (self.found.get(name), after)
        ]

    @property
    def _changing(self) -> list[str]:
        """What the command makes or changes."""
        return sorted({path.split("/")[0] for path in self.run.left} - set(self._bystanders))

    def _faults_of_another_try(self, left: Tree) -> list[str]:
        again = self.stage.run(self.scenario.command, left)
        faults = differences(again.left, self.run.left)
        if again.status != 0 and below(left, *self._changing) == below(self.run.left, *self._changing):
            faults += _faults_of_words(again)
        elif again.status != 0:
            faults.append(f"the same command ends with {again.status}: {again.errors}")
        return faults


def _faults_of_words(run: Run) -> list[str]:
    """A refusal is one line and status 2; what draws, `render` says before."""
    said = [line for line in run.errors.splitlines() if not line.startswith("vbbench: rendering with ")]
    if run.status == 2 and len(said) == 1 and said[0].startswith("vbbench: "):
        return []
    return [f"ends with {run.status}: {run.errors}"]
