"""Compact surroundings: the road once, and otherwise only the changes since the previous line."""

from __future__ import annotations

from typing import Any

from pydantic_core import to_jsonable_python

from stucksolver.scene import RoadGeometry, Surroundings, TrackedObject
from stucksolver.scene.base_model import FrozenModel

Data = dict[str, Any]


class DeltaEncoder:
    """Encoder of differences. Use one per file, in the order of its lines.

    It runs in the control loop and is fast: unchanged parts are only compared, never converted.
    """

    def __init__(self) -> None:
        self._last: Surroundings | None = None
        self._objects: dict[str, TrackedObject] = {}
        self._roads: set[str] = set()

    def new_road(self, surroundings: Surroundings) -> RoadGeometry | None:
        """Return the road when it appears for the first time."""
        if surroundings.road.key in self._roads:
            return None
        self._roads.add(surroundings.road.key)
        return surroundings.road

    def pack(self, surroundings: Surroundings) -> Data:
        """Return the difference from the surroundings packed before, as JSON values."""
        last, self._last = self._last, surroundings
        packed = _changed(last, surroundings, without=("road", "objects"))
        if last is None or last.road.key != surroundings.road.key:
            packed["road"] = surroundings.road.key
        objects = {o.id: o for o in surroundings.objects}
        before, self._objects = self._objects, objects
        if last is None or objects.keys() != before.keys() or tuple(objects) != tuple(before):
            packed["ids"] = list(objects)
        changes = {}
        for name, o in objects.items():
            change = _changed(before.get(name), o)
            if change:
                changes[name] = change
        packed["objects"] = changes
        return packed


class DeltaDecoder:
    """Inverse of `DeltaEncoder`; floats are restored to the last bit."""

    def __init__(self) -> None:
        self._last: Data = {}
        self._roads: dict[str, RoadGeometry] = {}

    def add_road(self, data: Data) -> None:
        """Add a road, to which later scenes refer by its key."""
        road = RoadGeometry.model_validate(data)
        self._roads[road.key] = road

    def unpack(self, packed: Data) -> Surroundings:
        """Restore the surroundings.

        Raises:
            KeyError: The road was not added.
            ValueError: The data are invalid.
        """
        now = self._last = _applied(self._last, packed)
        objects = [now["objects"][name] for name in now["ids"]]
        rest = {k: v for k, v in now.items() if k not in ("objects", "ids", "road")}
        return Surroundings.model_validate({**rest, "objects": objects, "road": self._roads[now["road"]]})


def _changed(old: FrozenModel | None, new: FrozenModel, without: tuple[str, ...] = ()) -> Data:
    """Return the fields of a model that differ from those of another one, recursively for nested models."""
    if old is new:
        return {}
    before = {} if old is None else vars(old)
    changes: Data = {}
    for name, value in vars(new).items():
        was = before.get(name, _changed)
        if name in without or value is was or value == was:
            continue
        changes[name] = (
            _changed(was, value) if isinstance(value, FrozenModel) and isinstance(was, FrozenModel) else _plain(value)
        )
    return changes


def _plain(value: Any) -> Any:
    return value if type(value) in (float, int, str, bool) or value is None else to_jsonable_python(value)


def _applied(old: Data, change: Data) -> Data:
    new = dict(old)
    for key, value in change.items():
        before = new.get(key)
        new[key] = _applied(before, value) if isinstance(value, dict) and isinstance(before, dict) else value
    return new
