"""Describes the situation of an utterance in one or two short sentences for the interpreter.

The interpreter was trained with sentences of this kind, so another wording may change its results.
"""

from __future__ import annotations

from stucksolver.scene import ControlKind, LightState, Scene

AHEAD_M = 45.0
"""Greatest distance of a lead in the text (m). Ours."""
LIGHT_M = 40.0
"""Greatest distance of a traffic light in the text (m). Ours."""


def situation_text(scene: Scene | None, question: str | None = None) -> str:
    """Return the ego's motion, its lead, the traffic light ahead, and the open yes-or-no question."""
    parts = [] if scene is None else [_doing(scene), *_light(scene)]
    if question is not None:
        parts.append(f"The car asks: {question}")
    return " ".join(parts)


def _doing(scene: Scene) -> str:
    lead = next(iter(scene.in_path_ahead(AHEAD_M)), None)
    doing = "Standing" if scene.ego.is_slow else "Driving"
    if lead is None:
        return f"{doing}, nothing in the way."
    lead_kind = lead.kind.value.replace("_", " ")
    how = "slow" if lead.speed_along_mps > 0.5 else "stopped"
    return f"{doing} behind a {how} {lead_kind}{', hazard lights on' if lead.hazard_lights else ''}."


def _light(scene: Scene) -> list[str]:
    for control in scene.controls:
        near = control.applies is not False and -1.0 < control.distance_m < LIGHT_M
        if near and control.kind is ControlKind.TRAFFIC_LIGHT and control.state is not None:
            dark = control.state is LightState.OFF
            return ["The light is out of order." if dark else f"The light is {control.state.value}."]
    return []
