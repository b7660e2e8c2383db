"""The rule reasoner: the chain of Bao and Li 2025 without a language model. The baseline for every model."""

from __future__ import annotations

from pathlib import Path

from stucksolver.plan import Decision, WaitLimits
from stucksolver.reasoners.reasoner import ReasonerAnswer, ReasonerRequest
from stucksolver.reasoners.registry import ReasonerKind, ReasonerNameError, help_text, register
from stucksolver.reasoners.rules.analyze import analyse
from stucksolver.reasoners.rules.decide import decide
from stucksolver.reasoners.rules.observe import observe
from stucksolver.reasoners.rules.pushed_object import assume_stopped
from stucksolver.scene import Scene


class RuleReasoner:
    """Observes, analyses and decides by fixed rules, after the chain of thought of Bao and Li 2025
    (arXiv:2510.26023).
    """

    name = "rules"

    def __init__(self, limits: WaitLimits | None = None) -> None:
        self._limits = limits or WaitLimits()

    def decide(self, request: ReasonerRequest) -> ReasonerAnswer:
        """Return the decision that follows from the scene. Deterministic."""
        return ReasonerAnswer(assume_stopped(request.scene, self._decide), self.name)

    def _decide(self, scene: Scene) -> Decision:
        observation = observe(scene, self._limits)
        return decide(scene, observation, analyse(scene, observation, self._limits), self._limits)


def _named(rest: str, exchanges: Path | None) -> RuleReasoner:
    if rest:
        raise ReasonerNameError(f"rules takes no {rest!r}: use {help_text()}")
    return RuleReasoner()


register(ReasonerKind("rules", "rules", _named))
__all__ = ["RuleReasoner"]
