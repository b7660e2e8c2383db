"""The phases of a running plan, and the transitions between them. `docs/states.md` shows both."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from stucksolver.guard import GivingWay, ProvenLeg, ProvenPlan
from stucksolver.plan import Execute
from stucksolver.plan.frenet_path import FrenetPath
from stucksolver.solver.state_machine.execution_steps import ExecutionOutcome, Step
from stucksolver.solver.state_machine.gap_wait import GapWait


class PhaseName(str, Enum):
    """The named phases of a running plan."""

    STOPPED = "stopped"
    """A behavior without a path runs, such as a wait or a call for help."""
    DRIVING_PATH = "driving a path"
    """The stack drives a proven path, and the guard checks it on every tick."""
    DRIVING_LEG = "driving a leg"
    """The stack drives one leg of a turn. The next one is proven where the vehicle has stopped."""
    YIELDING = "yielding"
    """The vehicle brakes for other road users, with its path or leg still in force."""
    STOPPING_BLIND = "stopping blind"
    """Perception has failed past the commit point: the vehicle is led slowly to a stop within what was proven."""
    AWAITING_NEXT = "awaiting the next gap"
    """A step is done, and only traffic prevents the next one. It is proven again on every tick."""
    ENDING = "ending"
    """The plan is aborted, and the vehicle brakes to a stop."""
    RETURNING = "returning"
    """The plan is aborted where the vehicle must not stop, and it drives back into its lane."""


N = PhaseName
TRANSITIONS: dict[tuple[PhaseName, PhaseName], str] = {
    (N.STOPPED, N.DRIVING_PATH): "its time is over, and the guard proves the next path",
    (N.STOPPED, N.DRIVING_LEG): "its time is over, and the guard proves the next leg",
    (N.STOPPED, N.AWAITING_NEXT): "its time is over, and only traffic prevents the next step",
    (N.STOPPED, N.ENDING): "its time is over, and the next step is rejected; or the plan is withdrawn while it moves",
    (N.DRIVING_PATH, N.STOPPED): "the path is driven, and the next behavior has no path",
    (N.DRIVING_PATH, N.DRIVING_LEG): "the path is driven, and the guard proves the next leg",
    (N.DRIVING_PATH, N.YIELDING): "another road user comes first",
    (N.DRIVING_PATH, N.STOPPING_BLIND): "perception has failed past the commit point",
    (N.DRIVING_PATH, N.AWAITING_NEXT): "the path is driven, and only traffic prevents the next step",
    (N.DRIVING_PATH, N.ENDING): "the guard rejects it, it takes too long, or it is withdrawn",
    (N.DRIVING_PATH, N.RETURNING): "the same, where the vehicle must not stop",
    (N.DRIVING_LEG, N.DRIVING_PATH): "the turn is done, and the guard proves the next path",
    (N.DRIVING_LEG, N.STOPPED): "the turn is done, and the next behavior has no path",
    (N.DRIVING_LEG, N.YIELDING): "another road user comes near",
    (N.DRIVING_LEG, N.AWAITING_NEXT): "the turn is done, and only traffic prevents the next step",
    (N.DRIVING_LEG, N.ENDING): "it takes too long, cannot be finished, or is withdrawn",
    (N.DRIVING_LEG, N.RETURNING): "the same, where the vehicle must not stop",
    (N.YIELDING, N.DRIVING_PATH): "the way is clear again",
    (N.YIELDING, N.DRIVING_LEG): "the way is clear again",
    (N.YIELDING, N.STOPPING_BLIND): "perception has failed past the commit point",
    (N.YIELDING, N.ENDING): "the guard rejects the path, or the plan is withdrawn",
    (N.YIELDING, N.RETURNING): "the same, where the vehicle must not stop",
    (N.STOPPING_BLIND, N.DRIVING_PATH): "perception works again",
    (N.STOPPING_BLIND, N.YIELDING): "perception works again, and another road user comes first",
    (N.STOPPING_BLIND, N.ENDING): "perception works again, and the guard rejects the path; or the plan is withdrawn",
    (N.STOPPING_BLIND, N.RETURNING): "the same, where the vehicle must not stop; or it was on the way back",
    (N.AWAITING_NEXT, N.STOPPED): "the guard accepts the next behavior",
    (N.AWAITING_NEXT, N.DRIVING_PATH): "the guard proves the next path",
    (N.AWAITING_NEXT, N.DRIVING_LEG): "the guard proves the next leg",
    (N.AWAITING_NEXT, N.YIELDING): "the nose is out, and the lane change begins by yielding",
    (N.AWAITING_NEXT, N.ENDING): "the time is over, something else prevents the step, or the plan is withdrawn",
    (N.AWAITING_NEXT, N.RETURNING): "the same, where the vehicle must not stop",
    (N.RETURNING, N.STOPPING_BLIND): "perception fails on the way back",
}
"""When a plan that does not end changes its phase. Every phase may also end the plan."""


@dataclass(frozen=True)
class Stopped:
    """A behavior without a path. `shown`: the stack has its directive."""

    shown: bool = False

    name = PhaseName.STOPPED


@dataclass(frozen=True)
class Yielding:
    """What the ego brakes for.

    Attributes:
        to: The road users.
        since_s: Since when (s).
        last_s: The last tick of it (s).
    """

    to: GivingWay
    since_s: float
    last_s: float


@dataclass(frozen=True)
class OnPath:
    """A proven path.

    Attributes:
        proven: What the guard has proven.
        index: Index of the current behavior among those of the path.
        yielding: What the ego brakes for, or None.
        gap_wait: How long the plan has waited for road users without progress. It outlives a short gap in the yielding.
        blind: The stop on which the vehicle is led without sight, or None.
    """

    proven: ProvenPlan
    index: int = 0
    yielding: Yielding | None = None
    gap_wait: GapWait | None = None
    blind: Execute | None = None

    @property
    def name(self) -> PhaseName:
        """Name of the phase."""
        if self.blind is not None:
            return PhaseName.STOPPING_BLIND
        return PhaseName.DRIVING_PATH if self.yielding is None else PhaseName.YIELDING


@dataclass(frozen=True)
class OnLeg:
    """One leg of a turn.

    Attributes:
        leg: What the guard has proven.
        moved_s: When the vehicle last moved (s).
        yields: True if the vehicle brakes for other road users.
    """

    leg: ProvenLeg
    moved_s: float
    yields: bool = False

    @property
    def name(self) -> PhaseName:
        """Name of the phase."""
        return PhaseName.YIELDING if self.yields else PhaseName.DRIVING_LEG


@dataclass(frozen=True)
class AwaitingNext:
    """Between two steps, while only traffic prevents the second one.

    Attributes:
        until_s: The plan is aborted at this time (s).
        traffic_s: When traffic was last all that prevented the step (s).
        still_s: Since when a stationary object has prevented it, too (s); None if none does.
    """

    until_s: float
    traffic_s: float
    still_s: float | None = None

    name = PhaseName.AWAITING_NEXT


@dataclass(frozen=True)
class Ending:
    """An aborted plan that brakes to a stop.

    Attributes:
        outcome: The outcome, once the vehicle has stopped.
        directive: The stop.
        proven: The path that was driven, for a harder stop if somebody comes; None if there was none.
    """

    outcome: ExecutionOutcome
    directive: Step
    proven: ProvenPlan | None

    name = PhaseName.ENDING


@dataclass(frozen=True)
class Returning:
    """An aborted plan that drives back into the lane.

    Attributes:
        outcome: The outcome, once the vehicle is back.
        path: The way back.
        directive: The directive that drives it.
        yields: True if the vehicle brakes for other road users.
        blind: The stop on which the vehicle is led without sight, or None.
    """

    outcome: ExecutionOutcome
    path: FrenetPath
    directive: Step
    yields: bool = False
    blind: Execute | None = None

    @property
    def name(self) -> PhaseName:
        """Name of the phase."""
        return PhaseName.RETURNING if self.blind is None else PhaseName.STOPPING_BLIND


Phase = Stopped | OnPath | OnLeg | AwaitingNext | Ending | Returning
