"""Duties: what the ego must do or wait for, whatever the guard would accept. The only place that knows situations.

The observation and the analysis are steps 1 and 2 of the chain of Bao and Li 2025 (arXiv:2510.26023).
"""

from __future__ import annotations

from stucksolver.plan import Decision, WaitLimits
from stucksolver.reasoners.duties.analysis import analyse
from stucksolver.reasoners.duties.observation import observe
from stucksolver.scene import Scene

NAME = "duties"
"""Name of these answers in records."""


def decide_wait(scene: Scene, limits: WaitLimits) -> Decision:
    """Return the observation and the analysis of a scene, as a decision without a plan."""
    observation = observe(scene, limits)
    analysis = analyse(scene, observation, limits)
    if analysis.wait is not None:
        why = f"waiting is right: {analysis.reason}"
    elif analysis.immobilized:
        why = f"immobilized: {analysis.reason}"
    else:
        why = f"nothing to do: {analysis.reason}"
    return Decision(observation=observation, analysis=analysis, plan=None, rationale=why)


__all__ = ["NAME", "decide_wait"]
