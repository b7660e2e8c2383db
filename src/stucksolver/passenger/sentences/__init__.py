"""The car's sentences for people: one table per closed list of codes, and the functions that fill the blanks."""

from stucksolver.passenger.sentences.asking import asked, needed
from stucksolver.passenger.sentences.plans import Phrase, doing, will
from stucksolver.passenger.sentences.reasons import blocked_by, waiting
from stucksolver.passenger.sentences.refusals import can_not
from stucksolver.passenger.sentences.things import noun, noun_of, nouns
from stucksolver.passenger.sentences.wishes import acknowledged

__all__ = [
    "Phrase",
    "acknowledged",
    "asked",
    "blocked_by",
    "can_not",
    "doing",
    "needed",
    "noun",
    "noun_of",
    "nouns",
    "waiting",
    "will",
]
