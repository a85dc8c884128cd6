"""What must hold wherever a command is killed, or the disk is full: checked at each of its steps."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from tests.lib.kill_harness import Command, Likeness, Point, Run, Stage, Tree, below, differences, without_chance


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
