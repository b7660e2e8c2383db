"""Guidance scripts: JSON by route id. A wording is chosen by the seed, so that several seeds hear several.

    {"version": 1, "routes": {"2101": [
        {"when": {"stopped_s": 6}, "say": ["please overtake them", "go around the parked car"], "kind": "helpful"}]}}

`when` has one of `time_s` (since the start), `stopped_s` (standing for so long) or `place_m` (along the route).
"""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path
from random import Random
from typing import Literal

from pydantic import Field, ValidationError, model_validator

from stucksolver.scene.model import Model

Kind = Literal["helpful", "unhelpful", "wrong", "dangerous"]


class GuidanceError(ValueError):
    """A guidance script cannot be used; the message names file, place and remedy."""


class When(Model):
    """Exactly one of them."""

    time_s: float | None = Field(default=None, ge=0)
    stopped_s: float | None = Field(default=None, ge=0)
    place_m: float | None = Field(default=None, ge=0)

    @model_validator(mode="after")
    def _one(self) -> When:
        if sum(value is not None for value in (self.time_s, self.stopped_s, self.place_m)) != 1:
            raise ValueError("give exactly one of time_s, stopped_s and place_m")
        return self


class Line(Model):
    """Something said once on a route, in one of several wordings."""

    when: When
    say: tuple[str, ...] = Field(min_length=1)
    kind: Kind = "helpful"

    def wording(self, random: Random) -> str:
        """One of its wordings."""
        return random.choice(self.say)


class Script(Model):
    """All lines of a suite."""

    version: Literal[1] = 1
    routes: dict[str, tuple[Line, ...]]

    def lines(self, route_id: str) -> tuple[Line, ...]:
        """What is said on a route; nothing on a route that is not in the script."""
        return self.routes.get(route_id, ())


def read_script(path: Path, known: Collection[str] = ()) -> Script:
    """Read a script; with `known` route ids, refuses one that speaks on none of them. Raises `GuidanceError`."""
    try:
        script = Script.model_validate_json(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise GuidanceError(f"{path}: cannot be read: {error.strerror}; give a guidance script") from error
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"]) or "the file"
        raise GuidanceError(f"{path}: {where}: {first['msg']}; see docs/evaluate.md for the format") from error
    if known and not set(script.routes) & set(known):
        raise GuidanceError(f"{path}: none of its routes is in the suite; give the script that belongs to it")
    return script
