"""The fields of a reading as numbers, by the names that training data use."""

from __future__ import annotations

from stucksolver.words import fields

INTENTS = tuple(intent.value for intent in fields.INTENTS)
SIDES = tuple("none" if side is None else side.value for side in fields.SIDES)
CLAIMS = tuple(claim.value for claim in fields.CLAIMS)
INTENT, SIDE, CLAIM = fields.INTENT, fields.SIDE, fields.CLAIM
LOGITS = fields.LOGITS
