"""Worlds of `worlds` in which traffic drives on the left, with a stack that mirrors all data for the solver."""

from __future__ import annotations

from dataclasses import dataclass

from stucksolver.plan import Directive
from stucksolver.plan.mirror import mirrored_directive
from stucksolver.scene import RoadGeometry, Scene, Surroundings
from stucksolver.scene.mirror import mirrored_scene, mirrored_surroundings
from worlds import World


@dataclass
class LeftHandWorld(World):
    """A world in which traffic drives on the left, as its own stack sees it, with a stack that mirrors all data."""

    def surroundings(self) -> Surroundings:
        return mirrored_surroundings(super().surroundings())

    def scene(self, surroundings: Surroundings | None = None) -> Scene:
        own = super().surroundings() if surroundings is None else mirrored_surroundings(surroundings)
        return mirrored_scene(super().scene(own))

    def drive(self, directive: Directive) -> None:
        super().drive(mirrored_directive(directive))


def left_hand(road: RoadGeometry) -> RoadGeometry:
    """A road of `worlds` with its lanes on the other side, in its stack's own frame: y to the left, not mirrored."""
    lanes = tuple(s.model_copy(update={"offset_m": tuple(-o for o in s.offset_m)}) for s in road.lanes)
    return road.model_copy(update={"lanes": lanes, "key": f"{road.key} left-hand"})
