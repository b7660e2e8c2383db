"""The safety case: every id, file and test that it names exists, and no hazard or requirement stands alone."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[3]
TEXT = (ROOT / "docs" / "SAFETY.md").read_text(encoding="utf-8")
NAMED = sorted(set(re.findall(r"`([\w/]+\.py)(?:: (\w+))?`", TEXT)))
LINKS = sorted(set(re.findall(r"\]\(([^)#]+)\)", TEXT)))


def rows(letter: str) -> dict[str, str]:
    """The rows of a table by their ids."""
    found = re.findall(rf"^\| ({letter}\d+)(?: \||:)(.*)\|$", TEXT, re.MULTILINE)
    assert len({name for name, _ in found}) == len(found), "an id is there twice"
    return dict(found)


@cache
def sources() -> tuple[Path, ...]:
    return tuple(path for folder in ("packages", "lab") for path in (ROOT / folder).rglob("*.py"))


def missing(file: str, name: str) -> str | None:
    """Return what is wrong with a file that is named, or with a test or class in it."""
    found = [path for path in sources() if path.as_posix().endswith(f"/{file}")]
    if len(found) != 1:
        return f"{file}: {found}"
    if name and not re.search(rf"(?:def|class) {name}\b", found[0].read_text(encoding="utf-8")):
        return f"{name} is not in {file}"
    return None


def test_what_is_named_is_there():
    assert len(NAMED) > 100
    assert [wrong for file, name in NAMED if (wrong := missing(file, name))] == []


def test_each_link_leads_somewhere():
    assert LINKS and [link for link in LINKS if not (ROOT / "docs" / link).exists()] == []


def test_each_hazard_has_requirements_and_each_requirement_a_hazard():
    hazards, requirements = rows("H"), rows("R")
    asked = {name: set(re.findall(r"\bR\d+\b", row)) for name, row in hazards.items()}
    assert all(asked.values())
    assert set().union(*asked.values()) == set(requirements)


def test_each_requirement_names_its_code_and_its_test():
    for name, row in rows("R").items():
        _, enforced, shown = row.strip(" |").rsplit(" | ", 2)
        assert ".py" in enforced and "test_" not in enforced, name
        assert "test_" in shown, name


def test_each_hazard_that_is_mentioned_is_defined():
    mentioned = set(re.findall(r"\bH\d+\b", TEXT)) | set(re.findall(r"\bC\d+\b", TEXT))
    assert mentioned <= rows("H").keys() | rows("C").keys()
