"""The object that an intervention began behind, and whether the ego has got past it."""

from __future__ import annotations

from dataclasses import dataclass

from stucksolver.scene import ObjectKind, Scene
from stucksolver.scene.frenet_scene import FrenetScene

REMEMBERED_M = 200.0
"""Progress after which failed plans are forgotten although the blocker is still ahead (m). Ours: the road and the sight
are different there.
"""


@dataclass(frozen=True)
class Blocker:
    """The nearest object in the path at the beginning of an intervention.

    Attributes:
        id: Id of the object.
        kind: Kind of the object.
        from_m: Progress on the route at that time (m).
    """

    id: str
    kind: ObjectKind
    from_m: float

    def is_same(self, object_id: str, kind: ObjectKind, *, sensed: bool) -> bool:
        """True if this is the object. An object that sensors lose and find again has another id, but the same kind."""
        return self.id == object_id or (sensed and self.kind is kind)

    def is_ahead(self, view: FrenetScene, within_m: float) -> bool:
        """True if the object is still ahead in the path with a gap of less than `within_m` (m)."""
        near = view.in_corridor(view.ego.width_m / 2) & (view.s > view.ego_s) & (view.gap < within_m)
        found = (o for o, is_near in zip(view.objects, near, strict=True) if is_near)
        return any(self.is_same(o.id, o.kind, sensed=o.position_sd_m is not None) for o in found)

    def still_blocks(self, scene: Scene, progress_m: float, within_m: float) -> bool:
        """True if the object still is what the ego stands behind, on the same stretch of road."""
        if progress_m - self.from_m > REMEMBERED_M:
            return False
        ahead = scene.in_path_ahead(within_m)
        return any(self.is_same(o.id, o.kind, sensed=o.position_sd_m is not None) for o in ahead)


def blocker_of(scene: Scene | None, progress_m: float, within_m: float) -> Blocker | None:
    """Return the nearest object in the path ahead; None if there is none within `within_m` (m), or no scene."""
    nearest = None if scene is None else next(iter(scene.in_path_ahead(within_m)), None)
    return None if nearest is None else Blocker(nearest.id, nearest.kind, progress_m)
