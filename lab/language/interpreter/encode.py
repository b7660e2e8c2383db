"""Sentences as arrays of token ids and labels: the input of the training, without the rest of the project.

```
python -m lab.language.interpreter.encode --start MODEL_DIR --count 400000 --seed 1 --out out/words/data
```

It writes `train.npz`, `dev.npz` and `tokenizer.json`. `--start` holds the start model's `tokenizer.json`.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterable, Sequence
from hashlib import sha256
from pathlib import Path
from random import Random

import numpy as np
from tokenizers import Tokenizer

from lab.language.interpreter import labels
from lab.language.interpreter.compose import Composer, Sentence, composed, corpus
from lab.language.interpreter.grammar import load
from lab.language.interpreter.noise import disturb
from stucksolver_language.intent.tokenization import MAX_TOKENS, encoded

COPIES = 10
"""Number of copies of each hand-written sentence, disturbed and in other situations. Ours."""
DEV_SHARE = 0.05
"""Share of the hand-written sentences that is held out to calibrate on. Ours."""


def in_dev(sentence: Sentence) -> bool:
    """True if a hand-written sentence is held out. Its text alone decides, so that no copy of it is trained on."""
    digest = sha256(sentence.text.strip().lower().encode()).digest()
    return digest[0] / 256 < DEV_SHARE


def varied(sentences: Sequence[Sentence], seed: int) -> Iterable[Sentence]:
    """Yield copies of the hand-written sentences.

    Only those without a question of the car's get another situation.
    """
    random = Random(seed)
    composer = Composer(load(), random)
    for sentence in sentences:
        asked = "?" in sentence.situation
        for copy in range(COPIES):
            text = sentence.text if copy == 0 else disturb(sentence.text, random, 0.5)
            situation = sentence.situation
            if not asked and copy % 2:
                situation = composer.situation(asked=False)
            yield Sentence(
                situation,
                text,
                sentence.intent,
                sentence.side,
                sentence.negated,
                sentence.claims,
                sentence.urgent,
                sentence.language,
            )


def fitted(tokenizer_json: str, sentences: Iterable[Sentence]) -> str:
    """Return the tokenizer with the Chinese characters of the sentences in place of unused entries.

    It neither pads nor cuts any more: `encoded` cuts, and padding would be at the position of the situation.
    """
    data = json.loads(tokenizer_json) | {"padding": None, "truncation": None}
    vocabulary: dict[str, int] = data["model"]["vocab"]
    wanted = sorted({c for sentence in sentences for c in sentence.text if "\u3400" <= c <= "\u9fff"} - set(vocabulary))
    unused = sorted((name for name in vocabulary if name.startswith("[unused")), key=lambda name: vocabulary[name])
    for character, name in zip(wanted, unused, strict=False):
        vocabulary[character] = vocabulary.pop(name)
    return json.dumps(data, ensure_ascii=False)


def arrays(sentences: Sequence[Sentence], tokenizer: Tokenizer) -> dict[str, np.ndarray]:
    """Return `ids` and `kinds` (sentences, tokens), `length`, `intent`, `side`, `flags` (negated, urgent), `claims`."""
    n = len(sentences)
    ids = np.zeros((n, MAX_TOKENS), np.uint16)
    kinds = np.zeros((n, MAX_TOKENS), np.uint8)
    length = np.zeros(n, np.uint8)
    claims = np.zeros((n, len(labels.CLAIMS)), np.uint8)
    for i, sentence in enumerate(sentences):
        pieces, kind = encoded(tokenizer, sentence.situation, sentence.text)
        ids[i, : len(pieces)], kinds[i, : len(pieces)], length[i] = pieces, kind, len(pieces)
        for claim in sentence.claims:
            claims[i, labels.CLAIMS.index(claim)] = 1
    return {
        "ids": ids,
        "kinds": kinds,
        "length": length,
        "intent": np.array([labels.INTENTS.index(sentence.intent) for sentence in sentences], np.uint8),
        "side": np.array([labels.SIDES.index(sentence.side or "none") for sentence in sentences], np.uint8),
        "flags": np.array([[sentence.negated, sentence.urgent] for sentence in sentences], np.uint8),
        "claims": claims,
        "logits": np.array(labels.LOGITS),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description="Encode the training sentences.")
    parser.add_argument("--start", type=Path, required=True, help="folder of the start model, with tokenizer.json")
    parser.add_argument("--count", type=int, default=400_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    written = corpus()
    train_sentences, held = [s for s in written if not in_dev(s)], [s for s in written if in_dev(s)]
    train = [*composed(options.count, options.seed), *varied(train_sentences, options.seed)]
    text = fitted((options.start / "tokenizer.json").read_text(encoding="utf-8"), train)
    (options.out / "tokenizer.json").write_text(text, encoding="utf-8")
    tokenizer = Tokenizer.from_str(text)
    Random(options.seed).shuffle(train)
    for name, sentences in (("train", train), ("dev", held)):
        np.savez_compressed(options.out / f"{name}.npz", **arrays(sentences, tokenizer))  # type: ignore[arg-type]
        print(f"{name}: {len(sentences)} sentences")


if __name__ == "__main__":
    main()
