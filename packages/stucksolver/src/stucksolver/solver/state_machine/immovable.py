"""Detects a vehicle that does not move although it drives: wheels without grip, a brake that is stuck, a curb."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stucksolver.ladder import CallAssistance
from stucksolver.plan import Directive, Execute
from stucksolver.scene.boxes import separation
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.solver.notices import IMMOVABLE, IN_VAIN_S
from stucksolver.solver.state_machine.human_in_the_loop import call_for_help
from stucksolver.solver.state_machine.pending_transition import PendingTransition

IN_VAIN_MPS = 0.3
"""Speed below which commanded motion has no effect (m/s). Ours: wheels that spin may let the vehicle creep."""
COMMANDED_MPS = 0.5
"""Least speed on a path that commands motion (m/s). Ours."""
LEADS_ON_M = 1.0
"""Least distance to the end of a path that commands motion (m). Ours."""
BESIDE_M, AHEAD_M = 1.0, 8.0
"""An object nearer than this to the body, or in the path, may be the reason why the driver does not go (m). Ours."""


def watch(turn: PendingTransition, directive: Directive) -> None:
    """Note since when motion has been commanded without an effect, and call for help after `IN_VAIN_S`.

    The driver's own report counts if there is one, since a driver may brake for an object by itself. Otherwise the
    directive of this tick counts.
    """
    standstill, status = turn.state.standstill, turn.status
    if standstill is None or standstill.immovable or turn.setup.observe_only:
        return
    still = status.speed_mps < IN_VAIN_MPS and not status.pushes
    commanded = still and (_leads_on(turn, directive) if status.drives is None else status.drives)
    backwards = isinstance(directive, Execute) and directive.reverse
    since_s = standstill.in_vain_s if backwards is standstill.in_vain_backwards else None
    since_s = None if not commanded else turn.now_s if since_s is None else since_s
    in_vain = since_s is not None and turn.now_s - since_s >= IN_VAIN_S
    if in_vain and _is_free(turn.view, backwards=backwards):
        _report(turn)
        return
    after = replace(standstill, in_vain_s=turn.now_s if in_vain else since_s, in_vain_backwards=backwards)
    if after != standstill:
        turn.state = replace(turn.state, standstill=after)


def _report(turn: PendingTransition) -> None:
    """Note that the vehicle is immovable, and call for help if the ladder ever does."""
    assert turn.state.standstill is not None
    turn.begin(turn.state.trigger or turn.inputs.trigger)
    turn.state = replace(turn.state, standstill=replace(turn.state.standstill, immovable=True))
    question, rungs = turn.state.question, turn.state.escalation.on.rungs
    is_asked = question is not None and question.to == "operator"
    if not is_asked and any(isinstance(move, CallAssistance) for _, move in rungs):
        turn.withdraw_question()
        call_for_help(turn, IMMOVABLE.text)


def _leads_on(turn: PendingTransition, directive: Directive) -> bool:
    """True if the directive has a path that leads on from here."""
    if not isinstance(directive, Execute) or not directive.path or turn.view is None:
        return False
    x, y = turn.view.ego.x_m, turn.view.ego.y_m
    away = [np.hypot(p.x_m - x, p.y_m - y) for p in directive.path]
    ahead = directive.path[int(np.argmin(away)) :]
    return max(p.speed_mps for p in ahead) >= COMMANDED_MPS and bool(away[-1] > LEADS_ON_M)


def _is_free(view: FrenetScene | None, *, backwards: bool) -> bool:
    """True if no object is close to the body, or near in the path. False if nothing is known."""
    if view is None:
        return False
    ego = view.ego
    yaw = np.array([o.yaw_rad for o in view.objects])
    gaps = separation(
        (ego.x_m, ego.y_m, ego.yaw_rad),
        (ego.length_m / 2, ego.width_m / 2),
        (view.places[:, 0], view.places[:, 1], yaw),
        (view.half_length, view.half_width),
    )
    along = (view.ego_s - view.s if backwards else view.s - view.ego_s) - view.along - ego.length_m / 2
    near = view.in_corridor(ego.width_m / 2) & (along > -ego.length_m) & (along < AHEAD_M)
    return not bool(((gaps < BESIDE_M) | near).any())
