"""The physical side of the catalog, read from the CSV tables beside this file.

Boxes of vehicles, walkers and (where the table says `measured`) props are those of CARLA 0.9.15 and 0.9.16, as
published by tools that queried the simulator; masses and powers are those of the real objects. Base and special types,
generations and opening doors follow CARLA's vehicle catalog
(https://carla.readthedocs.io/en/0.9.16/catalogue_vehicles/), which is the same for 0.9.15 and 0.9.16. So do the lights
of the second generation. In the first generation, those vehicles have lights that CARLA's page on actors names. The
catalog says that they have none, but Bench2Drive's background traffic, which uses only cars with lights, includes Audi
TTs, Impalas, Mustangs and 2017 Lincolns in published results.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from importlib import resources
from typing import Any

from carlette.geometry import Box, Vector


@dataclass(frozen=True)
class VehicleSpec:
    """Size, mass and drive train of one kind of vehicle."""

    id: str
    base_type: str
    special_type: str
    generation: int
    wheels: int
    has_lights: bool
    has_doors: bool
    box: Box
    """Bounding box. The actor's origin is on the ground, not always exactly below the box's center."""
    wheelbase_m: float
    mass_kg: float
    power_kw: float
    top_speed_kmh: float
    is_extra: bool = False

    @property
    def is_two_wheeler(self) -> bool:
        """True for bicycles and motorcycles."""
        return self.wheels == 2


@dataclass(frozen=True)
class PropModel:
    """Size and mass of one kind of static prop."""

    id: str
    length_m: float
    width_m: float
    height_m: float
    mass_kg: float
    contact: str
    """`fixed`: stops a car; `loose`: is pushed away; `passable`: visible, but driven over without contact."""
    is_extra: bool = False
    offset_y_m: float = 0.0
    """Lateral offset of the box's center from the origin (m): a gate turns about its end."""
    lift_m: float = 0.0
    """Height of the box's lower side (m)."""

    @property
    def box(self) -> Box:
        """Bounding box. The origin is on the ground."""
        half = Vector(self.length_m / 2, self.width_m / 2, self.height_m / 2)
        return Box(Vector(0.0, self.offset_y_m, self.lift_m + half.z), half)


@dataclass(frozen=True)
class WalkerModel:
    """One kind of pedestrian or animal; the actor's origin is the middle of the body, as in CARLA."""

    id: str
    age: str
    gender: str
    generation: int
    can_use_wheelchair: bool
    box: Box
    walk_mps: float
    run_mps: float
    mass_kg: float
    is_extra: bool = False


def vehicle_models() -> list[VehicleSpec]:
    """Return all vehicles, in the order of their ids, carlette's own at the end."""
    return [
        VehicleSpec(
            row["id"],
            row["base_type"],
            row["special_type"],
            int(row["generation"]),
            int(row["wheels"]),
            row["lights"] == "true",
            row["doors"] == "true",
            Box(
                Vector(*(float(row[f"center_{axis}_m"]) for axis in "xyz")),
                Vector(*(float(row[key]) / 2 for key in ("length_m", "width_m", "height_m"))),
            ),
            float(row["wheelbase_m"]),
            float(row["mass_kg"]),
            float(row["power_kw"]),
            float(row["top_speed_kmh"]),
            row["extra"] == "true",
        )
        for row in _rows("vehicles.csv")
    ]


def prop_models() -> list[PropModel]:
    """Return all static props, carlette's own at the end."""
    usual = [PropModel(**_prop(row)) for row in _rows("props.csv")]
    extra = [
        PropModel(**_prop(row), is_extra=True, offset_y_m=float(row["offset_y_m"]), lift_m=float(row["lift_m"]))
        for row in _rows("extra_props.csv")
    ]
    return usual + extra


def _prop(row: dict[str, str]) -> dict[str, Any]:
    numbers = {key: float(row[key]) for key in ("length_m", "width_m", "height_m", "mass_kg")}
    return {"id": f"static.prop.{row['name']}", **numbers, "contact": row["contact"]}


def walker_models() -> list[WalkerModel]:
    """Return the pedestrians, carlette's own at the end."""
    return [
        WalkerModel(
            row["id"],
            row["age"],
            row["gender"],
            int(row["generation"]),
            row["can_use_wheelchair"] == "true",
            Box(Vector(), Vector(float(row["radius_m"]), float(row["radius_m"]), float(row["half_height_m"]))),
            float(row["walk_mps"]),
            float(row["run_mps"]),
            float(row["mass_kg"]),
            row["extra"] == "true",
        )
        for row in _rows("walkers.csv")
    ]


def animal_models() -> list[WalkerModel]:
    """Return the animals; CARLA has none."""
    return [
        WalkerModel(
            row["id"],
            "adult",
            "other",
            1,
            False,
            Box(Vector(), Vector(*(float(row[key]) / 2 for key in ("length_m", "width_m", "height_m")))),
            float(row["walk_mps"]),
            float(row["run_mps"]),
            float(row["mass_kg"]),
            is_extra=True,
        )
        for row in _rows("animals.csv")
    ]


def _rows(name: str) -> list[dict[str, str]]:
    source = resources.files("carlette.blueprints") / "data" / name
    return list(csv.DictReader(source.read_text("utf-8").splitlines()))
