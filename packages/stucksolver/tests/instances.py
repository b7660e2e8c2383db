"""Valid instances of everything that crosses the boundary, derived from the types themselves."""

from __future__ import annotations

import base64
import types
from enum import Enum
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from hypothesis import strategies as st
from pydantic import BaseModel

from stucksolver.plan.behaviors import REGISTRY, Behavior
from stucksolver.scene import (
    AvailableBehavior,
    LaneDirection,
    LaneKind,
    LaneStrip,
    LineKind,
    RoadGeometry,
)

names = st.text(max_size=8)
json_values = st.none() | st.booleans() | st.integers(-9, 9) | names | st.lists(st.integers(-9, 9), max_size=2)


def of(kind: Any, metadata: tuple[Any, ...] = ()) -> st.SearchStrategy[Any]:
    """Valid values of a type as it stands in a field of a model, bounds included."""
    if kind in SPECIAL:
        return SPECIAL[kind]()
    origin, args = get_origin(kind), get_args(kind)
    if origin is Annotated:
        return of(args[0], tuple(args[1:]))
    if origin in (Union, types.UnionType):
        return st.one_of([of(arg, metadata) for arg in args])
    if origin is Literal:
        return st.sampled_from(args)
    if origin is tuple:
        return _tuples(args, metadata)
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        return model(kind)
    if isinstance(kind, type) and issubclass(kind, Enum):
        return st.sampled_from(kind)
    return _plain(kind, metadata)


def model(kind: type[BaseModel], **given: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    """Instances of a model with every field filled in."""
    fields = {n: of(f.annotation, tuple(f.metadata)) for n, f in kind.model_fields.items() if n not in given}
    return st.builds(kind, **fields, **given)


def _tuples(args: tuple[Any, ...], metadata: tuple[Any, ...]) -> st.SearchStrategy[Any]:
    if args[-1] is not Ellipsis:
        return st.tuples(*(of(arg) for arg in args))
    least = next((m.min_length for m in metadata if hasattr(m, "min_length")), 0)
    return st.lists(of(args[0]), min_size=least, max_size=least + 1).map(tuple)


def _plain(kind: Any, metadata: tuple[Any, ...]) -> st.SearchStrategy[Any]:
    if kind is float:
        low = max([m.ge for m in metadata if hasattr(m, "ge")] + [m.gt for m in metadata if hasattr(m, "gt")] + [-1e6])
        high = min([m.le for m in metadata if hasattr(m, "le")] + [1e6])
        open_end = any(hasattr(m, "gt") for m in metadata)
        return st.floats(low, high, exclude_min=open_end)
    if kind is int:
        least = max([m.ge for m in metadata if hasattr(m, "ge")] + [0])
        return st.integers(least, min([m.le for m in metadata if hasattr(m, "le")] + [10**9]))
    if kind is type(None):
        return st.none()
    if kind is bool:
        return st.booleans()
    if kind is bytes:
        return st.binary(max_size=20).map(base64.b64encode)
    assert kind is str, kind
    return names


def _strips(count: int) -> st.SearchStrategy[LaneStrip]:
    values = st.lists(st.floats(-20, 20), min_size=count, max_size=count).map(tuple)
    lines = st.lists(st.sampled_from(LineKind), min_size=count, max_size=count).map(tuple)
    return st.builds(
        LaneStrip,
        id=names,
        kind=st.sampled_from(LaneKind),
        direction=st.sampled_from(LaneDirection),
        start=st.just(0),
        offset_m=values,
        width_m=values,
        line=lines,
        speed_limit_mps=st.none() | st.floats(0, 40),
    )


def _roads() -> st.SearchStrategy[RoadGeometry]:
    points = st.lists(st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)), min_size=3, max_size=4).map(tuple)
    return model(RoadGeometry, reference=points, lanes=st.lists(_strips(3), max_size=2).map(tuple))


def _offers() -> st.SearchStrategy[AvailableBehavior]:
    parameters = st.dictionaries(names, json_values, max_size=2)
    return st.builds(AvailableBehavior, name=st.sampled_from(sorted(REGISTRY)), parameters=parameters)


def _behaviors() -> st.SearchStrategy[Behavior]:
    return st.one_of([model(behavior) for behavior in REGISTRY.values()])


SPECIAL = {
    LaneStrip: lambda: _strips(2),
    RoadGeometry: _roads,
    AvailableBehavior: _offers,
    Behavior: _behaviors,
}
