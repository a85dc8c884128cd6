"""What a forge reads: the citation agrees with package and paper, forms are valid, contributors find their way."""

import json
import re
from importlib.metadata import metadata
from importlib.resources import files
from pathlib import Path

import pytest
import yaml
from jsonschema import Draft7Validator

ROOT = Path(__file__).parents[2]
CITATION = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
CODEMETA = json.loads((ROOT / "codemeta.json").read_text("utf-8"))


def test_the_citation_file_is_valid() -> None:
    schema = files("check_jsonschema") / "builtin_schemas" / "vendor" / "citation-file-format.json"
    faults = [error.message for error in Draft7Validator(json.loads(schema.read_text("utf-8"))).iter_errors(CITATION)]
    assert not faults


@pytest.mark.parametrize("form", sorted((ROOT / ".github" / "ISSUE_TEMPLATE").iterdir()), ids=lambda path: path.stem)
def test_issue_forms_are_valid(form: Path) -> None:
    kind = "config" if form.stem == "config" else "forms"
    schema = files("check_jsonschema") / "builtin_schemas" / "vendor" / f"github-issue-{kind}.json"
    filled = yaml.safe_load(form.read_text("utf-8"))
    assert not [error.message for error in Draft7Validator(json.loads(schema.read_text("utf-8"))).iter_errors(filled)]


def test_name_licence_and_words_are_the_packages() -> None:
    package = metadata("vbbench")
    assert CITATION["title"] == CODEMETA["name"] == package["Name"]
    assert CITATION["license"] == CODEMETA["license"].rpartition("/")[2] == package["License-Expression"]
    assert CITATION["keywords"] == CODEMETA["keywords"]
    assert sorted(CITATION["keywords"]) == sorted(package["Keywords"].split(","))
    assert CODEMETA["description"] == package["Summary"]
    assert CITATION["abstract"].rstrip(".") == package["Summary"]


def test_the_version_is_the_last_that_was_released() -> None:
    """What is installed is that one, or comes after it: between releases it has a later number, or a suffix."""
    released = re.findall(r"^## \[(\d+\.\d+\.\d+)\]", (ROOT / "CHANGELOG.md").read_text("utf-8"), flags=re.M)[0]
    assert CITATION["version"] == CODEMETA["version"] == released
    installed = tuple(map(int, re.findall(r"\d+", metadata("vbbench")["Version"])[:3]))
    assert installed >= tuple(map(int, released.split(".")))
