"""Composes labeled sentences from the grammar and from the hand-written ones, each with a situation.

```
python -m lab.language.interpreter.compose --count 200000 --seed 1 --out out/words/train.jsonl
```
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from random import Random

from lab.language.interpreter.grammar import Chosen, Grammar, Meaning, load
from lab.language.interpreter.noise import disturb

CORPUS = Path(__file__).with_name("corpus")
JOINS = (
    " - no, ", "... no, ", ", actually no, ", ", wait, no, ", ", I mean, ", ", sorry, ", ", scrap that, ", ". No, ",
    " oh no, ", ", on second thoughts ", "... or rather, ", " no wait ", " no ", ", forget that, ", "— hang on, ",
    ", correction, ", ". Actually, ", " uh no ",
)  # fmt: skip
"""Phrases between an abandoned request and the corrected one."""
SHARES = {
    "phrase": 26,
    "sentence": 16,
    "frame": 20,
    "correction": 6,
    "none": 12,
    "unclear": 4,
    "unlawful": 7,
    "answer": 7,
    "language": 8,
}
"""Parts of the composed sentences, in percent of their sum. Ours."""
SEPARATE_INTENTS = frozenset({"none", "unclear", "unlawful", "yes", "no"})
"""Intents whose sentences have a part of their own."""
WAITING = frozenset({"wait", "no", "cancel", "follow"})


@dataclass(frozen=True)
class Sentence:
    """An utterance with its situation and its interpretation."""

    situation: str
    text: str
    intent: str
    side: str | None = None
    negated: bool = False
    claims: tuple[str, ...] = ()
    urgent: bool = False
    language: str = "en"


class Composer:
    """Endless sentences from one seed."""

    def __init__(self, grammar: Grammar, random: Random) -> None:
        self._grammar, self._random = grammar, random
        by_intent: dict[tuple[str, str], list[Meaning]] = {}
        for meaning in grammar.sentences:
            by_intent.setdefault((meaning.language, meaning.intent), []).append(meaning)
        self._by_intent = by_intent

    def sentences(self) -> Iterator[Sentence]:
        kinds, weights = list(SHARES), list(SHARES.values())
        while True:
            kind = self._random.choices(kinds, weights)[0]
            made: Sentence = getattr(self, f"_{kind}")()
            yield replace(made, text=disturb(" ".join(made.text.split(" ")), self._random))

    def situation(self, asked: bool) -> str:
        """Return a situation, with or without a question of the car's in it."""
        scene = self._line("scene", Chosen())
        question = self._line("q", Chosen())
        if asked:
            return question if self._random.random() < 0.25 else f"{scene} {question}"
        return "" if self._random.random() < 0.1 else scene

    # ---- kinds of sentences

    def _phrase(self) -> Sentence:
        """Return a verb phrase as a request, with politeness, hedges and reasons around it."""
        chosen, random = Chosen(), self._random
        intent = random.choice(list(self._grammar.phrases))
        base, _ = random.choice(self._grammar.phrases[intent])
        text = self._grammar.expand(base, random, chosen)
        if intent in ("overtake", "go", "pull_over", "reroute") and random.random() < 0.25:
            text += " " + self._line("sd" if intent == "overtake" else "maybesd", chosen)
        if random.random() < 0.45:
            text = self._line("hedge", chosen) + " " + text
        return self._meant(self._dressed(text, intent, chosen), intent, chosen)

    def _sentence(self) -> Sentence:
        """Return a sentence that has one meaning as it is."""
        random = self._random
        intents = [
            i for lang, i in self._by_intent if lang == "en" and i not in ("none", "unclear", "unlawful", "yes", "no")
        ]
        meaning = random.choice(self._by_intent["en", random.choice(intents)])
        chosen = Chosen()
        text = self._of(meaning, chosen)
        if random.random() < 0.5:
            text = self._dressed(text, meaning.intent, chosen)
        return self._meant(text, meaning.intent, chosen, meaning.negated)

    def _frame(self) -> Sentence:
        """Return a frame that forbids, or requests with a double negation."""
        random, chosen = self._random, Chosen()
        meaning = random.choices(
            list(self._grammar.frames), [3 if m.intent == "wait" else 1 for m in self._grammar.frames]
        )[0]
        intent = random.choice([i for i in self._grammar.phrases if i not in ("follow",)])
        if random.random() < 0.4:
            intent = "overtake"
        base, gerund = random.choice(self._grammar.phrases[intent])
        aside = Chosen()
        fixed = {"vp": self._grammar.expand(base, random, aside), "ving": self._grammar.expand(gerund, random, aside)}
        text = self._grammar.expand(random.choice(self._grammar.frames[meaning]), random, chosen, fixed)
        if random.random() < 0.3:
            text = self._opened(text, chosen)
        if meaning.intent == "wait" and random.random() < 0.3:
            text += self._because("why_wait", chosen)
        if meaning.intent == "same":
            chosen.labels |= aside.labels
            return self._meant(text, intent, chosen, True)
        if random.random() < 0.08:
            return replace(self._meant(text, "no", chosen, True), situation=self.situation(asked=True))
        return self._meant(text, "wait", chosen, True)

    def _correction(self) -> Sentence:
        """Return a sentence in which the passenger corrects the request."""
        random = self._random
        first = random.choice((self._phrase, self._phrase, self._sentence))()
        then = random.choice((self._phrase, self._sentence, self._stop, self._stop, self._frame))()
        if then.intent == "no" or (first.intent in WAITING and then.intent in WAITING):
            then = self._phrase()
        joined = f"{first.text}{random.choice(JOINS)}{then.text}"
        claims = tuple(sorted({*first.claims, *then.claims}))
        return replace(then, text=joined, negated=True, claims=claims)

    def _stop(self) -> Sentence:
        meaning, chosen = Meaning("wait"), Chosen()
        return self._meant(self._of(meaning, chosen), "wait", chosen)

    def _none(self) -> Sentence:
        return self._plain("none")

    def _unclear(self) -> Sentence:
        return self._plain("unclear")

    def _unlawful(self) -> Sentence:
        return self._plain("unlawful")

    def _answer(self) -> Sentence:
        """Return yes or no to a question of the car's; the same words without a question mean less."""
        random = self._random
        intent = random.choice(("yes", "no"))
        chosen = Chosen()
        text = self._of(Meaning(intent), chosen)
        if random.random() < 0.35:
            text += self._because("why_on" if intent == "yes" else "why_wait", chosen)
        if random.random() < 0.3:
            text = f"{text} {self._line('closer', chosen)}"
        return replace(self._meant(text, intent, chosen, intent == "no"), situation=self.situation(asked=True))

    def _language(self) -> Sentence:
        random = self._random
        language, intent = random.choice([key for key in self._by_intent if key[0] != "en"])
        meaning, chosen = random.choice(self._by_intent[language, intent]), Chosen()
        return replace(self._meant(self._of(meaning, chosen), intent, chosen, meaning.negated), language=language)

    # ---- helpers

    def _plain(self, intent: str) -> Sentence:
        chosen = Chosen()
        text = self._of(Meaning(intent), chosen)
        return self._meant(text, intent, chosen)

    def _meant(self, text: str, intent: str, chosen: Chosen, negated: bool = False) -> Sentence:
        side = chosen.side if intent in ("overtake", "go", "pull_over", "follow", "yes", "reroute") else None
        claims = () if intent == "unlawful" else chosen.claims
        situation = self.situation(asked=False)
        return Sentence(situation, text, intent, side, negated, claims, "urgent" in chosen.labels)

    def _of(self, meaning: Meaning, chosen: Chosen) -> str:
        return self._grammar.expand(self._random.choice(self._grammar.sentences[meaning]), self._random, chosen)

    def _line(self, name: str, chosen: Chosen) -> str:
        return self._grammar.expand([("list", name)], self._random, chosen)

    def _dressed(self, text: str, intent: str, chosen: Chosen) -> str:
        random = self._random
        if random.random() < 0.35:
            text = self._opened(text, chosen)
        if random.random() < 0.25:
            text += random.choice((", ", " ")) + self._line("closer", chosen)
        if random.random() < 0.25:
            reason = "why_wait" if intent in WAITING or (intent == "back_up" and random.random() < 0.5) else "why_on"
            if random.random() < 0.5:
                return self._line(reason, chosen) + random.choice((", so ", ", ", ". ", " so ")) + text
            text += self._because(reason, chosen)
        return text

    def _opened(self, text: str, chosen: Chosen) -> str:
        return self._line("opener", chosen) + self._random.choice((", ", " ", ", ", "... ")) + text

    def _because(self, name: str, chosen: Chosen) -> str:
        return self._random.choice((", ", ". ", " because ", " - ", ", since ", " ")) + self._line(name, chosen)


def corpus(folder: Path = CORPUS) -> list[Sentence]:
    """Return the hand-written sentences.

    Raises:
        ValueError: A line cannot be read.
    """
    return [
        _written(line, f"{file.name}:{number}")
        for file in sorted(folder.glob("*.jsonl"))
        for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1)
    ]


def _written(line: str, where: str) -> Sentence:
    """Return a line of the corpus: s situation, t text, i intent, d side, n negated, c claims, u urgent, l language."""
    try:
        d = json.loads(line)
        side = d["d"] if d["d"] in ("left", "right") else None
        claims, language = tuple(sorted(d["c"])), d.get("l", "en")
        return Sentence(d["s"], d["t"], d["i"], side, bool(d["n"]), claims, bool(d["u"]), language)
    except (ValueError, KeyError, TypeError) as error:
        raise ValueError(f"{where}: {error!r}") from error


def composed(count: int, seed: int) -> Iterator[Sentence]:
    """Yield `count` sentences of the grammar, the same for the same seed."""
    made = Composer(load(), Random(seed)).sentences()
    for _ in range(count):
        yield next(made)


def main() -> None:
    parser = argparse.ArgumentParser(description="Compose labelled sentences from the grammar.")
    parser.add_argument("--count", type=int, default=200_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    options.out.parent.mkdir(parents=True, exist_ok=True)
    with options.out.open("w", encoding="utf-8") as out:
        for sentence in composed(options.count, options.seed):
            out.write(json.dumps(asdict(sentence), ensure_ascii=False) + "\n")


if __name__ == "__main__":
    main()
