"""The grammar that composes training sentences, read from the text files of the folder `grammar`.

A line is text with alternatives `(a|b|)`, entries of lists `{name}`, and labels ` ~label` that its choice sets. `$
name` begins a list, `= intent flags` sentences of one meaning, `& intent` verb phrases `base | -ing form`, and `%
intent flags` frames around the verb phrases of moving intents (`same`: the intent of the phrase itself). Flags: `n`
negated, `@xx` the language.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from random import Random

FOLDER = Path(__file__).with_name("grammar")
SIDES = ("left", "right")
_TOKEN = re.compile(r"\(|\)|\||\{\w+\}|\\.|[^()|{}\\]+")


@dataclass(frozen=True)
class Meaning:
    """Meaning of the sentences of a section."""

    intent: str
    negated: bool = False
    language: str = "en"


@dataclass
class Chosen:
    """Labels from the choices of one sentence."""

    labels: set[str] = field(default_factory=set)

    @property
    def side(self) -> str | None:
        found = [side for side in SIDES if side in self.labels]
        return found[0] if len(found) == 1 else None

    @property
    def claims(self) -> tuple[str, ...]:
        return tuple(sorted(self.labels - {*SIDES, "urgent"}))


Node = str | tuple[str, object]


@dataclass
class Grammar:
    """All sections of all files. `phrases`: pairs of base and -ing form by intent."""

    lists: dict[str, list[list[Node]]] = field(default_factory=dict)
    sentences: dict[Meaning, list[list[Node]]] = field(default_factory=dict)
    phrases: dict[str, list[tuple[list[Node], list[Node]]]] = field(default_factory=dict)
    frames: dict[Meaning, list[list[Node]]] = field(default_factory=dict)

    def expand(self, nodes: list[Node], random: Random, chosen: Chosen, fixed: dict[str, str] | None = None) -> str:
        """Return one text of a line.

        `fixed`: entries that are fixed, by name.

        Raises:
            KeyError: A list is unknown.
        """
        out: list[str] = []
        for node in nodes:
            if isinstance(node, str):
                out.append(node)
                continue
            kind, what = node
            if kind == "label":
                chosen.labels.add(str(what))
            elif kind == "any":
                assert isinstance(what, list)
                out.append(self.expand(random.choice(what), random, chosen, fixed))
            elif fixed is not None and what in fixed:
                out.append(fixed[str(what)])
            else:
                out.append(self.expand(random.choice(self.lists[str(what)]), random, chosen, fixed))
        return "".join(out)


def load(folder: Path = FOLDER) -> Grammar:
    """Read every file of the folder.

    Raises:
        ValueError: A line cannot be read; the message has the file and the line.
    """
    grammar = Grammar()
    for file in sorted(folder.glob("*.txt")):
        _read(file, grammar)
    return grammar


def parse(text: str) -> list[Node]:
    """Return a line as nodes: text, `("any", alternatives)`, `("list", name)`, `("label", name)`.

    Raises:
        ValueError: The line cannot be read.
    """
    tokens = _TOKEN.findall(text)
    nodes, rest = _sequence(tokens, 0)
    if rest != len(tokens):
        raise ValueError(f"unbalanced bracket in {text!r}")
    return nodes


def _read(file: Path, grammar: Grammar) -> None:
    section: list[list[Node]] | None = None
    pairs: list[tuple[list[Node], list[Node]]] | None = None
    for number, raw in enumerate(file.read_text(encoding="utf-8").splitlines(), 1):
        line = raw.rstrip()
        if not line or line.startswith("#"):
            continue
        try:
            if line[:2] in ("$ ", "= ", "& ", "% "):
                section, pairs = _begin(line[0], line[2:].split(), grammar)
            elif pairs is not None:
                base, _, gerund = line.rpartition(" | ")
                pairs.append((parse(base), parse(gerund)))
            elif section is not None:
                section.append(parse(line))
            else:
                raise ValueError("a sentence before the first section")
        except ValueError as error:
            raise ValueError(f"{file.name}:{number}: {error}") from error


def _begin(
    mark: str, words: list[str], grammar: Grammar
) -> tuple[list[list[Node]] | None, list[tuple[list[Node], list[Node]]] | None]:
    if mark == "$":
        return grammar.lists.setdefault(words[0], []), None
    if mark == "&":
        return None, grammar.phrases.setdefault(words[0], [])
    language = next((word[1:] for word in words if word.startswith("@")), "en")
    meaning = Meaning(words[0], "n" in words[1:], language)
    return (grammar.sentences if mark == "=" else grammar.frames).setdefault(meaning, []), None


def _sequence(tokens: list[str], at: int) -> tuple[list[Node], int]:
    nodes: list[Node] = []
    while at < len(tokens) and tokens[at] not in ("|", ")"):
        token = tokens[at]
        if token == "(":
            alternatives, at = _alternatives(tokens, at + 1)
            nodes.append(("any", alternatives))
        elif token.startswith("{"):
            nodes.append(("list", token[1:-1]))
            at += 1
        else:
            nodes += _text(token[1:] if token.startswith("\\") else token)
            at += 1
    return nodes, at


def _alternatives(tokens: list[str], at: int) -> tuple[list[list[Node]], int]:
    found = []
    while True:
        nodes, at = _sequence(tokens, at)
        found.append(nodes)
        if at >= len(tokens):
            raise ValueError("a bracket is not closed")
        at += 1
        if tokens[at - 1] == ")":
            return found, at


def _text(text: str) -> list[Node]:
    """Return text, with its labels cut out."""
    nodes: list[Node] = []
    for part in re.split(r"( ?~\w*)", text):
        if part.strip().startswith("~"):
            if part.strip() != "~":
                nodes.append(("label", part.strip()[1:]))
        elif part:
            nodes.append(part)
    return nodes
