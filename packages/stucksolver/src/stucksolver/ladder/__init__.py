"""The escalation policy as data."""

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
from stucksolver.ladder.rung_actions import AskPerson, AskReasoner, Assist, Move, Person, Resume, Screen
from stucksolver.ladder.waits import Patience, Waits

__all__ = [
    "PROFILES",
    "Approval",
    "AskPerson",
    "AskReasoner",
    "Assist",
    "Ladder",
    "LadderError",
    "Move",
    "Patience",
    "Person",
    "Resume",
    "Screen",
    "Waits",
    "find_ladder",
    "load_ladder",
    "parse_ladder",
    "profile",
    "profile_text",
]
