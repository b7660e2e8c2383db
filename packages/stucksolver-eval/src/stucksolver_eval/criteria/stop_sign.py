"""Running a stop sign (RunningStopTest)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from stucksolver_eval.criteria.criterion import STANDING_MPS, Criterion, EgoTick, place_text

if TYPE_CHECKING:
    import carla

NEAR_M = 4.0
"""Distance within which a sign is checked (m). As in RunningStopTest."""
STEP_M = 0.5
"""Step along the lane ahead (m). As in RunningStopTest."""
STEPS = int(NEAR_M / STEP_M)
BOX_FACTOR = 1.2
"""Enlargement of the trigger box. As in RunningStopTest."""
AGAINST = -0.17
"""Cosine of about 100 degrees. Beyond it the ego drives backwards, or against its lane. As in RunningStopTest."""


class StopSign(NamedTuple):
    """A sign's trigger box: center, and half sizes along the world's axes."""

    actor: carla.Actor
    center: Any
    half_x: float
    half_y: float


class StopSigns(Criterion):
    """Reports a sign if the ego leaves its box without a stop."""

    kind = "stop_infraction"

    def __init__(self, world: carla.World, carla_map: carla.Map) -> None:
        super().__init__()
        self._map = carla_map
        signs = sorted(world.get_actors().filter("*traffic.stop*"), key=lambda a: a.id)
        self._signs = [_sign(actor) for actor in signs]
        self._target: StopSign | None = None
        self._stopped = False
        self._last_failed: int | None = None

    def update(self, moment: EgoTick) -> None:
        if self._target is None and not self._any_near(moment.location):
            return
        lane = self._lane_ahead(moment.location)
        if self._target is None:
            self._target = self._affecting(moment, lane)
            return
        self._stopped = self._stopped or moment.speed_mps < STANDING_MPS
        if not affects(self._target, lane):
            self._left(self._target, moment)

    def _left(self, sign: StopSign, moment: EgoTick) -> None:
        if not self._stopped and self._last_failed != sign.actor.id:
            where = place_text(sign.actor.get_location())
            self.note(moment.time_s, f"ran stop sign {sign.actor.id} at {where}")
            self._last_failed = sign.actor.id
        self._target, self._stopped = None, False

    def _any_near(self, place: Any) -> bool:
        # The distance of the lane's point from the ego is at most half a lane.
        reach = 2.0 * NEAR_M
        return any(abs(s.center.x - place.x) < reach and abs(s.center.y - place.y) < reach for s in self._signs)

    def _lane_ahead(self, place: carla.Location) -> list[carla.Waypoint]:
        """Return waypoints of the lane from the ego on, 0.5 m apart, up to 4 m ahead."""
        here = self._map.get_waypoint(place)
        found = [here]
        for _ in range(STEPS):
            following = found[-1].next(STEP_M)
            if not following:
                break
            found.append(following[0])
        return found

    def _affecting(self, moment: EgoTick, lane: list[carla.Waypoint]) -> StopSign | None:
        ahead, velocity = moment.transform.get_forward_vector(), moment.velocity
        backwards = velocity.x * ahead.x + velocity.y * ahead.y + velocity.z * ahead.z < AGAINST
        along = lane[0].transform.get_forward_vector()
        against = ahead.x * along.x + ahead.y * along.y + ahead.z * along.z < AGAINST
        if backwards or against:
            return None
        return next((sign for sign in self._signs if affects(sign, lane)), None)


def affects(sign: StopSign, lane: list[carla.Waypoint]) -> bool:
    """Return True if the ego's lane point is within 4 m of the sign's box and the lane ahead enters the box."""
    if sign.center.distance(lane[0].transform.location) > NEAR_M:
        return False
    places = (waypoint.transform.location for waypoint in lane)
    return any(abs(p.x - sign.center.x) < sign.half_x and abs(p.y - sign.center.y) < sign.half_y for p in places)


def _sign(actor: carla.TrafficSign) -> StopSign:
    volume = actor.trigger_volume
    center = actor.get_transform().transform(volume.location)
    return StopSign(actor, center, BOX_FACTOR * float(volume.extent.x), BOX_FACTOR * float(volume.extent.y))
