"""The car's sentences for people: one table per closed list of codes, and the functions that fill the blanks."""

from stucksolver_passenger.sentences.acknowledgements import acknowledged
from stucksolver_passenger.sentences.nouns import noun, noun_of, nouns
from stucksolver_passenger.sentences.plans import Phrase, doing, will
from stucksolver_passenger.sentences.questions import asked, needed
from stucksolver_passenger.sentences.reasons import blocked_by, waiting
from stucksolver_passenger.sentences.rejections import can_not

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
