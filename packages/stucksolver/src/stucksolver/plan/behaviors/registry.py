"""The registry of behaviors. The schema, the prompt, the guard and the documentation are derived from it.

A behavior is added by one file and its entry in `SHIPPED`, or by `register` from another distribution.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from functools import lru_cache, reduce
from types import MappingProxyType
from typing import Annotated, Any

from pydantic import Field, GetCoreSchemaHandler, GetJsonSchemaHandler, TypeAdapter
from pydantic_core import CoreSchema, core_schema, to_json

from stucksolver.plan.behaviors.back_up import BackUp
from stucksolver.plan.behaviors.behavior import Behavior, Check
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
from stucksolver.scene.base_model import RegisteredModels
from stucksolver.scene.scene import AvailableBehavior

SHIPPED: tuple[type[Behavior], ...] = (
    Wait,
    KeepLane,
    FollowVehicle,
    ChangeLane,
    BorrowOncomingLane,
    Nudge,
    NoseOut,
    Creep,
    BackUp,
    DriveOver,
    PullOver,
    RejoinRoute,
    TurnAround,
    ReplanRoute,
    HazardLights,
    RequestAssistance,
)
"""The behaviors of this distribution, in the order of prompts and schemas."""
STATED = ("summary", "phrase")
"""Facts without a default, which each behavior must state."""

_registered: dict[str, type[Behavior]] = {}
REGISTRY: Mapping[str, type[Behavior]] = MappingProxyType(_registered)
"""The closed list of behaviors by name."""


def register(behavior: type[Behavior]) -> None:
    """Add a behavior to the closed list. Call it before the first solver of the process is created.

    Raises:
        ValueError: The behavior has no name, its name is taken, or it does not state a required fact.
    """
    name = behavior.model_fields["name"].default
    if not isinstance(name, str):
        raise ValueError(f"behavior without a default name: {behavior.__name__}. Expected `name: Literal[...] = ...`")
    if name in _registered:
        raise ValueError(f"behavior name is taken: {name!r}. Use another name")
    missing = [fact for fact in STATED if not hasattr(behavior, fact)]
    if behavior.solution_rank is not None and not behavior.intents:
        missing.append("intents")  # a plan is remembered by the main intent
    if missing:
        raise ValueError(f"behavior {name!r} does not state: {', '.join(missing)}. Add them to {behavior.__name__}")
    _registered[name] = behavior
    _forget_derived()


def unregister(name: str) -> None:
    """Remove a behavior from the closed list.

    Raises:
        KeyError: The name is not in the list.
    """
    del _registered[name]
    _forget_derived()


def _forget_derived() -> None:
    _adapter.cache_clear()
    describe.cache_clear()


@lru_cache(maxsize=1)
def _adapter() -> TypeAdapter[Any]:
    """Return the validator of the union of all registered behaviors."""
    form: Any = reduce(operator.or_, _registered.values())
    if len(_registered) > 1:
        form = Annotated[form, Field(discriminator="name")]
    return TypeAdapter(form)


class _RegistryUnion(RegisteredModels):
    """Annotation of a field for any registered behavior: it validates like the union of all that are registered now.

    A union in the annotation would be compiled into each model that has such a field and stay the same for good.
    """

    def models(self) -> tuple[type[Behavior], ...]:
        return tuple(_registered.values())

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Return a schema that passes the mode (Python or JSON, lax or strict) on to the union."""
        return core_schema.lax_or_strict_schema(_by_input(strict=None), _by_input(strict=True))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """Return the JSON schema of the union."""
        return handler(_adapter().core_schema)


def _by_input(strict: bool | None) -> CoreSchema:
    def of_python(value: object) -> Behavior:
        parsed: Behavior = _adapter().validate_python(value, strict=strict)
        return parsed

    def of_json(value: object) -> Behavior:
        parsed: Behavior = _adapter().validate_json(to_json(value), strict=strict)
        return parsed

    def plain(function: Callable[[object], Behavior]) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(function)

    return core_schema.json_or_python_schema(json_schema=plain(of_json), python_schema=plain(of_python))


AnyBehavior = Annotated[Behavior, _RegistryUnion()]


def parse_behavior(data: object) -> Behavior:
    """Parse a behavior from its JSON form.

    Raises:
        pydantic.ValidationError: It is not in the list, or a parameter is out of bounds.
    """
    parsed: Behavior = _adapter().validate_python(data)
    return parsed


def unknown_behavior_reason(behavior: object) -> str | None:
    """Return why something is not a behavior of the closed list within its bounds, or None if it is.

    A subclass could have other checks than the guard knows by that name, and a copy could have invalid parameters.
    """
    known = REGISTRY.get(str(getattr(behavior, "name", "")))
    if known is None or type(behavior) is not known:
        return f"{type(behavior).__name__} is not in the closed list of behaviors"
    try:
        again = known.model_validate(behavior.model_dump())
    except ValueError:
        return f"{known.__name__} with a parameter out of bounds"
    return None if again == behavior else f"{known.__name__} that does not survive validation unchanged"


def names_with(check: Check) -> frozenset[str]:
    """Return the names of the behaviors that must pass a check."""
    return frozenset(name for name, behavior in REGISTRY.items() if check in behavior.checks)


@lru_cache(maxsize=32)
def describe(names: tuple[str, ...]) -> tuple[AvailableBehavior, ...]:
    """Return the descriptions of behaviors that a reasoner is given.

    Raises:
        KeyError: A name is not in the list.
    """
    found = []
    for name in names:
        if name not in REGISTRY:
            raise KeyError(f"unknown behavior {name!r}; the closed list is: {', '.join(REGISTRY)}")
        found.append(AvailableBehavior(name=name, parameters=REGISTRY[name].model_json_schema()))
    return tuple(found)


for _behavior in SHIPPED:
    register(_behavior)
