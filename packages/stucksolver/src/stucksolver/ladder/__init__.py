"""Escalation policy as data."""

from stucksolver.ladder.ladder import Approval, Ladder
from stucksolver.ladder.ladder_file import (
    PROFILES,
    LadderError,
    find_ladder,
    load_ladder,
    parse_ladder,
    profile,
    profile_text,
)
from stucksolver.ladder.rung_actions import (
    FIRST_REASONER,
    AskPerson,
    AskReasoner,
    CallAssistance,
    CheckForWait,
    Move,
    Person,
    Resume,
)
from stucksolver.ladder.waits import WaitLimit, WaitPolicy

__all__ = [
    "FIRST_REASONER",
    "PROFILES",
    "Approval",
    "AskPerson",
    "AskReasoner",
    "CallAssistance",
    "CheckForWait",
    "Ladder",
    "LadderError",
    "Move",
    "Person",
    "Resume",
    "WaitLimit",
    "WaitPolicy",
    "find_ladder",
    "load_ladder",
    "parse_ladder",
    "profile",
    "profile_text",
]
