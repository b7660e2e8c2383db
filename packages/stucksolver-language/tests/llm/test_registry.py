"""Reasoners by their words: what there is, one's own, and what is said of those that are not."""

from __future__ import annotations

import pytest

from stucksolver.reasoners import ReasonerAnswer, ReasonerRequest, SearchReasoner
from stucksolver.reasoners.factory import HELP, make_reasoner, sees
from stucksolver.reasoners.registry import KINDS, ReasonerKind, ReasonerNameError, register
from worlds import World, straight_road, thing


class Mine:
    """One as a user would write it."""

    name = "mine"

    def decide(self, request: ReasonerRequest) -> ReasonerAnswer:
        return ReasonerAnswer(SearchReasoner().decide(request).decision, self.name)


class Odd:
    """A class that is no reasoner."""


class Raises:
    def __init__(self) -> None:
        raise RuntimeError("no weights")


def test_ones_own_is_named_by_module_and_class():
    scene = World(straight_road(), [thing("car", 60.0)]).scene()
    answer = make_reasoner(f"own:{__name__}:Mine").decide(ReasonerRequest(scene))
    assert answer.reasoner == "mine"
    assert answer.decision == SearchReasoner().decide(ReasonerRequest(scene)).decision


@pytest.mark.parametrize(
    ("words", "why"),
    [
        ("own:", "name a module and a class"),
        ("own:no_such_module_here:Mine", "ModuleNotFoundError: No module named 'no_such_module_here'"),
        (f"own:{__name__}:Nobody", "AttributeError"),
        (f"own:{__name__}:Raises", "RuntimeError: no weights"),
        (f"own:{__name__}:Odd", "has no name and no decide"),
        ("search:fast", "search takes no 'fast'"),
        ("recorded:", "no folder in name"),
        ("serach", "unknown reasoner 'serach': use search, "),
    ],
)
def test_what_cannot_be_made_is_said_with_the_reason(words, why):
    with pytest.raises(ReasonerNameError, match=why):
        make_reasoner(words)


def test_reasoner_help_is_complete_and_duplicate_name_rejected():
    """The help names every kind of reasoner, and a name cannot be registered twice."""
    assert all(kind.form in HELP for kind in KINDS.values())
    with pytest.raises(ValueError, match="already a kind of reasoner named 'search'"):
        register(ReasonerKind("search", "search", lambda rest, exchanges: SearchReasoner()))


@pytest.mark.parametrize(
    ("words", "looks"),
    [
        ("search", False),
        ("rules, openai:m", True),
        ("openai:m#pictures=off", False),
        ("driver", False),
        ("own:a:B", True),
    ],
)
def test_pictures_are_rendered_only_for_who_looks_at_them(words, looks):
    assert sees(words) is looks
