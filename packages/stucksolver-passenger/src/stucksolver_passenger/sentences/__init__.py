"""The car's sentences for people: one table per closed list of codes, and the functions that fill in the details."""

from stucksolver_passenger.sentences.acknowledgements import acknowledged
from stucksolver_passenger.sentences.nouns import noun, noun_of, nouns
from stucksolver_passenger.sentences.plans import future_phrase, present_phrase
from stucksolver_passenger.sentences.questions import needed, question_text
from stucksolver_passenger.sentences.reasons import blocked_by, standstill_sentence, waiting
from stucksolver_passenger.sentences.rejections import rejection_sentence

__all__ = [
    "acknowledged",
    "blocked_by",
    "future_phrase",
    "needed",
    "noun",
    "noun_of",
    "nouns",
    "present_phrase",
    "question_text",
    "rejection_sentence",
    "standstill_sentence",
    "waiting",
]
