"""Finds the work zone ahead: a chain of cones and barriers, told in one line instead of one line for each object."""

from __future__ import annotations

from dataclasses import dataclass

from stucksolver.plan import ReportedWorkZone
from stucksolver.scene import ObjectKind, Scene, SceneObject

KINDS = frozenset({ObjectKind.CONE, ObjectKind.BARRIER})
LEAST_OBJECTS = 3
"""Number of cones and barriers in a chain that make a work zone. Ours."""
SPACING_M = 16.0
"""Largest distance between neighbors of a chain (m). MUTCD 2009, section 6F.63: twice the speed limit (mph) in feet, so
50 feet (15.2 m) at 25 mph, and some for the error of a position.
"""


@dataclass(frozen=True)
class WorkZone:
    """Chain of cones and barriers along the route, nearest first."""

    objects: tuple[SceneObject, ...]

    @property
    def start_m(self) -> float:
        """Distance from the ego's front bumper to its near end (m)."""
        return min(o.gap_m or 0.0 for o in self.objects)

    @property
    def end_m(self) -> float:
        """Distance from the ego's front bumper to its far end (m)."""
        return max((o.gap_m or 0.0) + o.length_m for o in self.objects)

    @property
    def edges_m(self) -> tuple[float, float]:
        """Right and left edge from the center of the route's lane (m), left positive."""
        return min(o.right_edge_m for o in self.objects), max(o.left_edge_m for o in self.objects)

    @property
    def middle_ids(self) -> frozenset[str]:
        """Ids of all objects between the first and the last."""
        return frozenset(o.id for o in self.objects[1:-1])


def nearest_work_zone(scene: Scene) -> WorkZone | None:
    """Return the work zone ahead that begins nearest to the ego, or None."""
    found = [o for o in scene.objects if o.kind in KINDS and o.gap_m is not None and o.gap_m > -scene.ego.length_m]
    chain: list[SceneObject] = []
    for obj in sorted(found, key=lambda o: o.gap_m or 0.0):
        if chain and (obj.gap_m or 0.0) - (chain[-1].gap_m or 0.0) > SPACING_M:
            if len(chain) >= LEAST_OBJECTS:
                break
            chain = []
        chain.append(obj)
    return WorkZone(tuple(chain)) if len(chain) >= LEAST_OBJECTS else None


def work_zone_of(scene: Scene) -> ReportedWorkZone:
    """Return a reported work zone with its measured extent."""
    zone = nearest_work_zone(scene)
    return ReportedWorkZone() if zone is None else ReportedWorkZone(start_m=zone.start_m, end_m=zone.end_m)
