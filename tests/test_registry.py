"""Entry points: lazy, with suggestions, and proof against a stranger's broken plugin."""

import subprocess
import sys
from collections.abc import Iterator, Mapping
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import ClassVar

import pytest

from vbbench import registry
from vbbench.errors import UnknownNameError, VbbenchError, VbbenchWarning
from vbbench.solving.submissions import declared_facts
from vbbench_baselines.joint_map import MapCausal


@pytest.fixture
def plugins(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[EntryPoint]]:
    points: list[EntryPoint] = []
    monkeypatch.setattr(registry, "entry_points", lambda group: [p for p in points if p.group == group])
    registry.registered.cache_clear()
    yield points
    registry.registered.cache_clear()


def solver(name: str, value: str) -> EntryPoint:
    return EntryPoint(name, value, "vbbench.solvers")


def test_bundled_names_are_there() -> None:
    assert {"cv", "sf", "vb-cv"} <= set(registry.registered("solver"))
    assert {"hotel", "eth", "students", "custom"} <= set(registry.registered("generator"))


def test_listing_imports_nothing() -> None:
    code = "import sys; from vbbench.registry import registered; registered('solver'); registered('generator');"
    code += "sys.exit(any(m.startswith('vbbench_') for m in sys.modules))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize(("wrong", "near"), [("vb_cv", "vb-cv"), ("CV", "known:"), ("vbcv", "vb-cv")])
def test_wrong_names_get_a_suggestion(wrong: str, near: str) -> None:
    with pytest.raises(UnknownNameError, match=near):
        registry.load("solver", wrong)


@pytest.mark.parametrize("name", ["mine", "mine.py"])
def test_the_name_of_a_module_is_not_that_of_its_class(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UnknownNameError):
        registry.load("solver", name)
    (tmp_path / "mine.py").touch()
    with pytest.raises(VbbenchError, match=r"of a class in mine\.py write mine:CLASS"):
        registry.load("solver", name)


def test_module_and_attribute_need_no_registration() -> None:
    assert registry.load("solver", "collections:OrderedDict.fromkeys")


@pytest.mark.parametrize("value", ["math:pi", "math:sqrt"])
def test_a_solver_must_be_a_class_without_arguments(value: str) -> None:
    with pytest.raises(VbbenchError, match="not a class that can be called without arguments"):
        registry.make_solver(value)


def test_a_broken_plugin_is_a_warning_that_names_it(plugins: list[EntryPoint]) -> None:
    plugins += [solver("good", "math:sqrt"), solver("broken", "no_such_module_at_all:x"), solver("bad", "math:nothing")]
    with pytest.warns(VbbenchWarning, match=r"'(broken|bad)'") as caught:
        assert list(registry.load_all("solver")) == ["good"]
    assert len(caught) == 2
    with pytest.raises(VbbenchError, match="no_such_module_at_all"):
        registry.load("solver", "broken")


def test_of_two_with_one_name_the_first_counts_and_is_named(plugins: list[EntryPoint]) -> None:
    plugins += [solver("same", "math:sqrt"), solver("same", "math:cbrt")]
    with pytest.warns(VbbenchWarning, match="registered twice; math:sqrt is used"):
        assert registry.load("solver", "same").__name__ == "sqrt"


class OfOurs(MapCausal):
    """Made of a bundled solver."""


class Theirs:
    facts: ClassVar[Mapping[str, str]] = {"authors": "we"}


class OfTheirs(Theirs):
    pass


class Odd:
    facts: ClassVar[Mapping[str, str]] = {"colour": "red"}


def test_facts_are_inherited_but_from_a_bundled_solver() -> None:
    assert set(declared_facts("map-causal")) >= {"authors", "tuned_on"}
    assert declared_facts(f"{__name__}:OfOurs") == {}
    assert declared_facts(f"{__name__}:Theirs") == declared_facts(f"{__name__}:OfTheirs") == {"authors": "we"}
    with pytest.raises(VbbenchError, match="facts must map some of authors"):
        declared_facts(f"{__name__}:Odd")
