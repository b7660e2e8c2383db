"""The physical side of the catalogue, read from the CSV tables beside this file.

Sizes of vehicles are the bounding boxes of CARLA 0.9.15; masses and powers those of the real cars; sizes of
props are estimates from their pictures.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from importlib import resources

from carlette.geometry import Box, Vector


@dataclass(frozen=True)
class VehicleModel:
    """Size, mass and drive train of one kind of vehicle."""

    id: str
    base_type: str
    special_type: str
    generation: int
    wheels: int
    has_lights: bool
    has_doors: bool
    length_m: float
    width_m: float
    height_m: float
    wheelbase_m: float
    mass_kg: float
    power_kw: float
    top_speed_kmh: float

    @property
    def box(self) -> Box:
        """Bounding box; the actor's origin lies on the ground below the centre."""
        return standing_box(self.length_m, self.width_m, self.height_m)

    @property
    def is_two_wheeler(self) -> bool:
        """Bicycles and motorcycles."""
        return self.wheels == 2


@dataclass(frozen=True)
class PropModel:
    """Size and mass of one kind of static prop; a movable one is pushed away by a car."""

    id: str
    length_m: float
    width_m: float
    height_m: float
    mass_kg: float
    movable: bool

    @property
    def box(self) -> Box:
        """Bounding box; the origin lies on the ground."""
        return standing_box(self.length_m, self.width_m, self.height_m)


@dataclass(frozen=True)
class WalkerModel:
    """One kind of pedestrian; the actor's origin is the middle of the body, as in CARLA."""

    id: str
    gender: str
    age: str
    half_height_m: float
    radius_m: float
    run_speed_mps: float

    @property
    def box(self) -> Box:
        """Bounding box around the origin."""
        return Box(Vector(), Vector(self.radius_m, self.radius_m, self.half_height_m))


def standing_box(length_m: float, width_m: float, height_m: float) -> Box:
    """A box that stands on its origin."""
    return Box(Vector(z=height_m / 2), Vector(length_m / 2, width_m / 2, height_m / 2))


def vehicle_models() -> list[VehicleModel]:
    """All vehicles, in the order of CARLA's ids."""
    return [
        VehicleModel(
            row["id"],
            row["base_type"],
            row["special_type"],
            int(row["generation"]),
            int(row["wheels"]),
            row["lights"] == "true",
            row["doors"] == "true",
            *(float(row[key]) for key in ("length_m", "width_m", "height_m", "wheelbase_m")),
            *(float(row[key]) for key in ("mass_kg", "power_kw", "top_speed_kmh")),
        )
        for row in _rows("vehicles.csv")
    ]


def prop_models() -> list[PropModel]:
    """All static props."""
    return [
        PropModel(
            f"static.prop.{row['name']}",
            float(row["length_m"]),
            float(row["width_m"]),
            float(row["height_m"]),
            float(row["mass_kg"]),
            row["movable"] == "true",
        )
        for row in _rows("props.csv")
    ]


CHILDREN = frozenset({9, 10, 11, 12, 13, 14, 48, 49})
WOMEN = frozenset({1, 4, 5, 8, 9, 10, 15, 18, 19, 20, 22, 24, 28, 31, 32, 33, 35, 36, 38, 41, 43, 45, 47, 48})


def walker_models() -> list[WalkerModel]:
    """The pedestrians 0001 to 0049."""
    return [_walker(number) for number in range(1, 50)]


def _walker(number: int) -> WalkerModel:
    child = number in CHILDREN
    return WalkerModel(
        f"walker.pedestrian.{number:04d}",
        "female" if number in WOMEN else "male",
        "child" if child else "adult",
        half_height_m=0.55 if child else 0.93,
        radius_m=0.25 if child else 0.19,
        run_speed_mps=2.0 if child else 4.0,
    )


def _rows(name: str) -> list[dict[str, str]]:
    source = resources.files("carlette.blueprints") / "data" / name
    return list(csv.DictReader(source.read_text("utf-8").splitlines()))
