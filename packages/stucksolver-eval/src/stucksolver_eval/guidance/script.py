"""Guidance scripts: JSON by route id. The seed chooses the wording, so different seeds use different wordings.

```json
{"version": 1, "routes": {"2101": [
  {"when": {"stopped_s": 6}, "say": ["please overtake them", "go around the parked car"], "kind": "helpful"},
  {"when": {"asked": "operator", "after_s": 4}, "answer": "yes", "by": "operator", "help": "broken light"}]}}
```

`when` has one of `time_s` (since the start), `stopped_s` (duration of the stop), `place_m` (along the route) or `asked`
(a question to that person has been open for `after_s`). A line contains an utterance, or a yes or no to a question.
"""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from random import Random
from typing import Literal

from pydantic import Field, ValidationError, model_validator

from stucksolver.ladder import Person
from stucksolver.scene.base_model import FrozenModel

Kind = Literal["helpful", "unhelpful", "wrong", "late", "dangerous"]


class GuidanceError(ValueError):
    """A guidance script cannot be used. The message names the file, the position and the remedy."""


class ScriptTrigger(FrozenModel):
    """Condition under which a line is due: exactly one of the first four fields is set."""

    time_s: float | None = Field(default=None, ge=0)
    stopped_s: float | None = Field(default=None, ge=0)
    place_m: float | None = Field(default=None, ge=0)
    asked: Person | None = None
    after_s: float = Field(default=3.0, ge=0)
    """With `asked`: the person's response time (s)."""

    @model_validator(mode="after")
    def _one(self) -> ScriptTrigger:
        if sum(value is not None for value in (self.time_s, self.stopped_s, self.place_m, self.asked)) != 1:
            raise ValueError("give exactly one of time_s, stopped_s, place_m and asked")
        return self


class ScriptLine(FrozenModel):
    """An utterance, once on a route and in one of several wordings, or a yes or no to a question."""

    when: ScriptTrigger
    say: tuple[str, ...] = ()
    answer: Literal["yes", "no"] | None = None
    kind: Kind = "helpful"
    by: Person = "passenger"
    help: str = ""
    """Kind of help, for the report; empty if it is none."""

    @model_validator(mode="after")
    def _says_or_answers(self) -> ScriptLine:
        if bool(self.say) == (self.answer is not None):
            raise ValueError("give either say, with at least one wording, or answer")
        if self.answer is not None and self.when.asked is None:
            raise ValueError("an answer needs `when` with `asked`: name the person")
        return self

    def wording(self, random: Random) -> str:
        """Return a random wording of the line, or its answer."""
        return random.choice(self.say) if self.say else str(self.answer)


class Script(FrozenModel):
    """All lines of a suite."""

    version: Literal[1] = 1
    routes: dict[str, tuple[ScriptLine, ...]]

    def lines(self, route_id: str) -> tuple[ScriptLine, ...]:
        """Return the lines of a route; none for a route that the script does not contain."""
        return self.routes.get(route_id, ())


def read_script(path: Path, known: Collection[str] = ()) -> Script:
    """Read a script. With `known` route ids, the script must contain at least one. Raises `GuidanceError`."""
    try:
        script = Script.model_validate_json(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise GuidanceError(f"cannot read file: {path}: {error.strerror}. Give a guidance script") from error
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"]) or "the file"
        raise GuidanceError(
            f"invalid guidance script: {path}: {where}: {first['msg']}. See docs/evaluate.md for the format"
        ) from error
    if known and not set(script.routes) & set(known):
        raise GuidanceError(f"no route of the suite in file: {path}. Give the script that belongs to the suite")
    return script
