"""The fields of an interpretation as numbers, with the names of the training data."""

from __future__ import annotations

from stucksolver_language.intent import intent_decoder

INTENTS = tuple(intent.value for intent in intent_decoder.INTENTS)
SIDES = tuple("none" if side is None else side.value for side in intent_decoder.SIDES)
CLAIMS = tuple(claim.value for claim in intent_decoder.CLAIMS)
INTENT, SIDE, CLAIM = intent_decoder.INTENT, intent_decoder.SIDE, intent_decoder.CLAIM
LOGITS = intent_decoder.LOGITS
