"""Surroundings in few bytes: the road once, and of the rest what changed since the line before."""

from __future__ import annotations

from typing import Any

from stucksolver.scene import RoadGeometry, Surroundings

Data = dict[str, Any]


class Packer:
    """Makes differences. Use one for one file, in the order of its lines."""

    def __init__(self) -> None:
        self._last: Data | None = None
        self._roads: set[str] = set()

    def new_road(self, seen: Surroundings) -> Data | None:
        """The road's JSON form, the first time that it is met."""
        if seen.road.key in self._roads:
            return None
        self._roads.add(seen.road.key)
        return seen.road.model_dump(mode="json")

    def pack(self, seen: Surroundings) -> Data:
        """What differs from the surroundings packed before."""
        now = _plain(seen)
        packed = now if self._last is None else _difference(self._last, now)
        self._last = now
        return packed


class Unpacker:
    """The way back; floats come back to the last bit."""

    def __init__(self) -> None:
        self._last: Data = {}
        self._roads: dict[str, RoadGeometry] = {}

    def add_road(self, data: Data) -> None:
        road = RoadGeometry.model_validate(data)
        self._roads[road.key] = road

    def unpack(self, packed: Data) -> Surroundings:
        """The surroundings as they were. Raises `KeyError` for a road that was not added, `ValueError` for nonsense."""
        now = self._last = _applied(self._last, packed)
        objects = [now["objects"][name] for name in now["ids"]]
        rest = {k: v for k, v in now.items() if k not in ("objects", "ids", "road")}
        return Surroundings.model_validate({**rest, "objects": objects, "road": self._roads[now["road"]]})


def _plain(seen: Surroundings) -> Data:
    data = seen.model_dump(mode="json", exclude={"road", "objects"})
    data["road"] = seen.road.key
    data["ids"] = [o.id for o in seen.objects]
    data["objects"] = {o.id: o.model_dump(mode="json") for o in seen.objects}
    return data


def _difference(old: Data, new: Data) -> Data:
    """Keys whose values changed; tables are compared within. What is gone is told by `ids` alone."""
    found: Data = {}
    for key, value in new.items():
        before = old.get(key)
        if isinstance(value, dict) and isinstance(before, dict):
            inside = _difference(before, value)
            if inside:
                found[key] = inside
        elif key not in old or value != before:
            found[key] = value
    return found


def _applied(old: Data, change: Data) -> Data:
    new = dict(old)
    for key, value in change.items():
        before = new.get(key)
        new[key] = _applied(before, value) if isinstance(value, dict) and isinstance(before, dict) else value
    return new
