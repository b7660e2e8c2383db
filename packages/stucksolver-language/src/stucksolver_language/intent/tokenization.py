"""Encodes words and their situation as word pieces, the same way in training and in the vehicle."""

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
"""At most this much of the situation is kept, from its end, where the vehicle's question is."""


def encoded(tokenizer: Tokenizer, situation: str, text: str) -> tuple[list[int], list[int]]:
    """Return the ids, and for each 1 if it belongs to the words or 0 if to the situation.

    The order is [CLS] situation [SEP] words [SEP].
    """
    scene = tokenizer.encode(situation, add_special_tokens=False).ids[-SITUATION_TOKENS:]
    words = tokenizer.encode(text, add_special_tokens=False).ids[: MAX_TOKENS - 3 - len(scene)]
    ids = [FIRST, *scene, LAST, *words, LAST]
    return ids, [0] * (len(scene) + 2) + [1] * (len(words) + 1)
