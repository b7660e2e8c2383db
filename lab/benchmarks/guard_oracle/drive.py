"""Drives one accepted plan in closed loop: the guard rechecks it, the ego obeys, the others act as badly as allowed."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from lab.benchmarks.guard_oracle.contact import Contact, contact_with
from lab.benchmarks.guard_oracle.recording import Recording
from lab.benchmarks.guard_oracle.scene import Drawn
from lab.benchmarks.guard_oracle.vehicle import Manner
from lab.benchmarks.guard_oracle.watch import Watch
from lab.benchmarks.guard_oracle.world import AT_REST_MPS, DT, World
from stucksolver.guard import Guard
from stucksolver.plan import Directive, RecoveryPlan
from stucksolver.plan.directive import CONTINUE
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.solver.state_machine.execution import Execution
from stucksolver.solver.state_machine.execution_steps import ExecutionOutcome

EVERY = 2
"""Number of ticks between two rechecks of the guard."""
MOST_S = 40.0
"""Longest drive (s). Ours."""


@dataclass
class Ended:
    """The end of a drive.

    `missed`: lines crossed, and stops on rails and other forbidden positions, against the rules.
    """

    how: str
    t: float
    contact: Contact | None = None
    recording: Recording | None = None
    """The drive, if it ended in a contact."""
    missed: list[str] = field(default_factory=list)
    nearest: float = math.inf


def manner(draw: Drawn) -> Manner:
    """Draw the manner of driving of the vehicle."""
    drift = 0.0
    if draw.random() < 0.65:
        drift = draw.choice([-1, 1]) * (draw.uniform(0.05, 0.3) if draw.random() < 0.4 else draw.uniform(0.3, 1.0))
    return Manner(
        eager=draw.random(),
        keen=draw.random(),
        lag=draw.uniform(0.0, 0.3),
        drift=drift,
        drift_rate=draw.uniform(0.05, 0.25),
        drifts_from=draw.uniform(0.0, 6.0),
        follows=draw.random() < 0.6,
    )


def silence(draw: Drawn) -> float:
    """Draw the time from which the solver is silent (s)."""
    return draw.uniform(0.5, 8.0) if draw.random() < 0.06 else math.inf


def judged(world: World, plan: RecoveryPlan, guided: bool) -> tuple[Execution, Any]:
    """Submit a plan to the guard; return the execution and the verdict."""
    execution = Execution(plan, Guard(), guided)
    return execution, execution.start(FrenetScene(world.surroundings()), 0.0)


def drive(world: World, execution: Execution, silent_from: float) -> Ended:
    """Drive a started plan to its end."""
    lease = _lease()
    order: Directive = CONTINUE
    watch = Watch(world)
    nearest = math.inf
    recording = Recording(world, silent_from)
    for k in range(round(MOST_S / DT)):
        if k % EVERY == 0 and world.t < silent_from:
            directive = execution.tick(FrenetScene(world.surroundings()), world.t)
            if isinstance(directive, ExecutionOutcome):
                return Ended(
                    "finished" if directive.finished else "given up", world.t, None, None, watch.missed, nearest
                )
            order = directive
            if lease is not None:
                lease.renew(order)
        done, rests = world.ego.path_is_done, abs(world.ego.speed) < AT_REST_MPS
        now = order if lease is None else lease.tick(world.ego.x, world.ego.y, path_is_done=done, at_rest=rests)
        if world.t >= silent_from and (now is CONTINUE or (lease is None and done)):
            return Ended("silent, then handed over", world.t, None, None, watch.missed, nearest)
        recording.orders.append(now)
        world.step(now)
        watch.update()
        hit = world.touched()
        if hit is not None:
            obeyed = "silent" if world.t > silent_from else type(now).__name__ if now is order else "fallback"
            contact = contact_with(world, hit, obeyed)
            return Ended("contact", world.t, contact, recording, watch.missed, 0.0)
        if k % EVERY == 0:
            nearest = min(nearest, world.nearest())
    return Ended("too long", world.t, None, None, watch.missed, nearest)


def _lease() -> Any:
    """Return the lease on the stack's side; None with an older solver without leases."""
    try:
        from stucksolver.plan.lease import Lease
    except ImportError:
        # An older solver has no leases; the oracle also measures old versions.
        return None
    return Lease()
