"""The registry of behaviours. The schema, the prompt, the guard and the documentation are derived from it."""

from __future__ import annotations

from functools import lru_cache
from typing import Annotated, get_args

from pydantic import Field, TypeAdapter

from stucksolver.plan.behaviors.back_up import BackUp
from stucksolver.plan.behaviors.behavior import Behavior
from stucksolver.plan.behaviors.borrow_oncoming_lane import BorrowOncomingLane
from stucksolver.plan.behaviors.change_lane import ChangeLane
from stucksolver.plan.behaviors.creep import Creep
from stucksolver.plan.behaviors.drive_over import DriveOver
from stucksolver.plan.behaviors.follow_vehicle import FollowVehicle
from stucksolver.plan.behaviors.hazard_lights import HazardLights
from stucksolver.plan.behaviors.keep_lane import KeepLane
from stucksolver.plan.behaviors.nose_out import NoseOut
from stucksolver.plan.behaviors.nudge import Nudge
from stucksolver.plan.behaviors.pull_over import PullOver
from stucksolver.plan.behaviors.rejoin_route import RejoinRoute
from stucksolver.plan.behaviors.replan_route import ReplanRoute
from stucksolver.plan.behaviors.request_assistance import RequestAssistance
from stucksolver.plan.behaviors.turn_around import TurnAround
from stucksolver.plan.behaviors.wait import Wait
from stucksolver.scene.scene import AvailableBehavior

AnyBehavior = Annotated[
    Wait
    | KeepLane
    | FollowVehicle
    | ChangeLane
    | BorrowOncomingLane
    | Nudge
    | NoseOut
    | Creep
    | BackUp
    | DriveOver
    | PullOver
    | RejoinRoute
    | TurnAround
    | ReplanRoute
    | HazardLights
    | RequestAssistance,
    Field(discriminator="name"),
]

REGISTRY: dict[str, type[Behavior]] = {
    cls.model_fields["name"].default: cls for cls in get_args(get_args(AnyBehavior)[0])
}

_adapter: TypeAdapter[AnyBehavior] = TypeAdapter(AnyBehavior)


def parse_behavior(data: object) -> Behavior:
    """Parse a behaviour from its JSON form.

    Raises:
        pydantic.ValidationError: It is not in the list, or a parameter is out of bounds.
    """
    return _adapter.validate_python(data)


def unknown_behavior_reason(behavior: object) -> str | None:
    """Return why something is not a behaviour of the closed list within its bounds, or None if it is.

    A subclass could have other checks than the guard knows by that name, and a copy could have invalid parameters.
    """
    known = REGISTRY.get(str(getattr(behavior, "name", "")))
    if known is None or type(behavior) is not known:
        return f"{type(behavior).__name__} is not in the closed list of behaviours"
    try:
        again = known.model_validate(behavior.model_dump())
    except ValueError:
        return f"{known.__name__} with a parameter out of bounds"
    return None if again == behavior else f"{known.__name__} that does not survive validation unchanged"


@lru_cache(maxsize=32)
def describe(names: tuple[str, ...]) -> tuple[AvailableBehavior, ...]:
    """Return the descriptions of behaviours that a reasoner is given.

    Raises:
        KeyError: A name is not in the list.
    """
    found = []
    for name in names:
        if name not in REGISTRY:
            raise KeyError(f"unknown behaviour {name!r}; the closed list is: {', '.join(REGISTRY)}")
        found.append(AvailableBehavior(name=name, parameters=REGISTRY[name].model_json_schema()))
    return tuple(found)
