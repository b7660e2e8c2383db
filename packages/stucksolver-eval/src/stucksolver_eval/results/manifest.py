"""The settings of an evaluation, stored in its folder so that results of other settings are not mixed with it."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Literal

from pydantic import Field

from stucksolver.scene.base_model import FrozenModel
from stucksolver_eval.routes import Route
from stucksolver_eval.routes.writer import routes_text


class EvaluationManifest(FrozenModel):
    """`suite_digest` covers the routes as written, `guidance_digest` and `ladder_digest` the files' bytes."""

    version: Literal[1] = 1
    suite: str
    suite_digest: str
    routes: int
    seeds: tuple[int, ...]
    driver: str
    recovery: str
    reasoner: str = ""
    prompt: str = ""
    """Version and digest of the prompt, if a model is queried."""
    clock: str
    perception: str
    detector: dict[str, float] = Field(default_factory=dict)
    guarded: bool = True
    heedless: bool = False
    guidance: str = ""
    guidance_digest: str = ""
    ladder: str = ""
    ladder_digest: str = ""
    memory: str = ""
    """Name of the memory file, if there was one. It changes with every run."""
    simulator: str = "carlette"
    command: str = ""

    @property
    def title(self) -> str:
        """One line that identifies the run."""
        return f"{self.suite} ({self.suite_digest[:8]}), {self.driver}, recovery {self.recovery}"

    def differs_from(self, other: EvaluationManifest) -> str:
        """Return the first field in which they differ, in words; empty if they agree."""
        if routes := self.routes_differ(other):
            return routes
        if self.guidance_digest != other.guidance_digest:
            return f"the guidance differs: {other.guidance or 'none'} there, {self.guidance or 'none'} here"
        if self.ladder_digest != other.ladder_digest:
            return f"the ladder differs: {other.ladder or 'the usual'} there, {self.ladder or 'the usual'} here"
        for name in type(self).model_fields:
            ours, theirs = getattr(self, name), getattr(other, name)
            if name not in ("command", "suite", "guidance", "ladder") and ours != theirs:
                return f"its {name.replace('_', ' ')} is {theirs!r}, not {ours!r}"
        return ""

    def routes_differ(self, other: EvaluationManifest) -> str:
        """Return how the routes differ, in words; empty if they are the same."""
        if self.suite_digest == other.suite_digest:
            return ""
        if (self.routes, self.suite) == (other.routes, other.suite):
            return f"the routes differ: {self.routes} of {self.suite} on both sides, but not the same ones"
        return f"the routes differ: {other.routes} of {other.suite} there, {self.routes} of {self.suite} here"


def suite_digest(routes: tuple[Route, ...]) -> str:
    """Return the SHA-256 of the routes in a normalized XML form, so that white space and comments do not matter."""
    return hashlib.sha256(routes_text(routes).encode()).hexdigest()


def file_digest(path: Path | None) -> str:
    """Return the SHA-256 of a file in hex; empty without a file."""
    return "" if path is None else hashlib.sha256(path.read_bytes()).hexdigest()
