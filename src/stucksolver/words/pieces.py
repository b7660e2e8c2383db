"""Words and their situation as word pieces, the same way in training and on the road."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tokenizers import Tokenizer

MAX_TOKENS = 128
"""Longer input is cut: the situation first, then the end of the words."""
FIRST = 101
"""Id of [CLS]."""
LAST = 102
"""Id of [SEP]."""
SITUATION_TOKENS = 44
"""So much of the situation is kept at most, its end: a question of the vehicle's stands there."""


def encoded(tokenizer: Tokenizer, situation: str, text: str) -> tuple[list[int], list[int]]:
    """Ids, and for each whether it belongs to the words (1) or the situation (0): [CLS] situation [SEP] words [SEP]."""
    scene = tokenizer.encode(situation, add_special_tokens=False).ids[-SITUATION_TOKENS:]
    words = tokenizer.encode(text, add_special_tokens=False).ids[: MAX_TOKENS - 3 - len(scene)]
    ids = [FIRST, *scene, LAST, *words, LAST]
    return ids, [0] * (len(scene) + 2) + [1] * (len(words) + 1)
