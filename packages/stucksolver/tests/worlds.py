"""Small worlds for tests: a straight road, objects on it, and a stand-in vehicle that drives what it is told."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache

import numpy as np

from stucksolver.guard import Guard
from stucksolver.interpreter import find_reader
from stucksolver.ladder import Approval, Ladder, profile
from stucksolver.plan import Decision, Directive, Execute, SafeStop, WaitLimits, intent_authorizes
from stucksolver.plan.behaviors import REGISTRY, describe
from stucksolver.reasoners import ReasonerRequest, SearchReasoner
from stucksolver.reasoners.duties import decide_wait
from stucksolver.scene import (
    ControlKind,
    EgoState,
    Guidance,
    LaneDirection,
    LaneKind,
    LaneSight,
    LaneStrip,
    LightState,
    LineKind,
    ObjectKind,
    RoadGeometry,
    Scene,
    Status,
    Surroundings,
    TrackedObject,
    TrafficControl,
    Zone,
)
from stucksolver.scene.boxes import separation
from stucksolver.scene.frenet_scene import FrenetScene
from stucksolver.scene.scene_builder import build_scene
from stucksolver.solver import Event, EventKind, StuckSolver
from stucksolver.solver.state_machine.plan_preview import PlanPreview

LANE_M = 3.5
NAMES = tuple(REGISTRY)
READER = find_reader()
"""The shipped one: what it makes of a test's sentences is a part of what is tested."""


@cache
def said(text: str, situation: str = "") -> Guidance:
    """A passenger's words with their reading, as the solver hands them to a reasoner."""
    return Guidance(text=text[:500], time_s=0.0, reading=READER.read(text[:500], situation))


def strip(name: str, offset: float, direction: LaneDirection, line: LineKind, count: int) -> LaneStrip:
    return LaneStrip(
        id=name,
        kind=LaneKind.DRIVING,
        direction=direction,
        start=0,
        offset_m=(offset,) * count,
        width_m=(LANE_M,) * count,
        line=(line,) * count,
        speed_limit_mps=13.4,
    )


def straight_road(
    *, oncoming: LineKind | None = LineKind.BROKEN, left: LineKind | None = None, zones: tuple[Zone, ...] = ()
) -> RoadGeometry:
    """400 m along x; the route's lane on the center line, an oncoming lane and one of our direction at will."""
    count = 401
    lanes = [strip("own", 0.0, LaneDirection.SAME, LineKind.NONE, count)]
    offset = 0.0
    if left is not None:
        offset += LANE_M
        lanes.append(strip("left", offset, LaneDirection.SAME, left, count))
    if oncoming is not None:
        offset += LANE_M
        lanes.append(strip("oncoming", offset, LaneDirection.OPPOSITE, oncoming, count))
    reference = tuple((float(x), 0.0) for x in range(count))
    key = f"straight-{oncoming}-{left}-{zones}"
    return RoadGeometry(key=key, spacing_m=1.0, reference=reference, lanes=tuple(lanes), zones=zones)


def bent_road(radius_m: float, *, count: int = 60, lanes: tuple[LaneStrip, ...] = ()) -> RoadGeometry:
    """An arc that turns left about (0, radius); negative radii turn right."""
    angles = np.arange(count) / radius_m
    reference = tuple((float(radius_m * np.sin(a)), float(radius_m * (1 - np.cos(a)))) for a in angles)
    own = strip("own", 0.0, LaneDirection.SAME, LineKind.NONE, count)
    return RoadGeometry(key=f"arc-{radius_m}-{count}", spacing_m=1.0, reference=reference, lanes=(own, *lanes))


def red_light(distance: float, state: LightState = LightState.RED, applies: bool | None = True) -> TrafficControl:
    return TrafficControl(kind=ControlKind.TRAFFIC_LIGHT, distance_m=distance, applies=applies, state=state)


def thing(
    name: str,
    x: float,
    y: float = 0.0,
    *,
    kind: ObjectKind = ObjectKind.CAR,
    speed: float = 0.0,
    sideways: float = 0.0,
    yaw: float = 0.0,
    stationary_s: float | None = None,
    moved_s_ago: float | None = None,
    hazard: bool | None = False,
    length: float | None = None,
    width: float | None = None,
    height: float = 1.5,
    **more: object,
) -> TrackedObject:
    sizes = {
        ObjectKind.BICYCLE: (1.8, 0.6),
        ObjectKind.PEDESTRIAN: (0.5, 0.5),
        ObjectKind.CONE: (0.4, 0.4),
        ObjectKind.BAG: (0.3, 0.3),
    }
    usual = sizes.get(kind, (4.6, 1.9))
    moving = math.hypot(speed, sideways) > 0.1
    return TrackedObject(
        id=name,
        kind=kind,
        x_m=x,
        y_m=y,
        yaw_rad=yaw if speed >= 0 else math.pi,
        vx_mps=speed,
        vy_mps=sideways,
        length_m=length or usual[0],
        width_m=width or usual[1],
        height_m=height,
        stationary_s=stationary_s if stationary_s is not None else (0.0 if moving else 30.0),
        moved_s_ago=moved_s_ago,
        hazard_lights=hazard,
        **more,
    )


@dataclass
class World:
    """A world that moves: the ego follows what it is told exactly, objects keep their velocity."""

    road: RoadGeometry
    objects: list[TrackedObject] = field(default_factory=list)
    controls: tuple[TrafficControl, ...] = ()
    x: float = 50.0
    y: float = 0.0
    yaw: float = 0.0
    speed: float = 0.0
    sight_m: float = 300.0
    behind_m: float = 80.0
    time_s: float = 0.0
    frame: int = 0
    cruise_mps: float = 8.0
    dt: float = 0.05
    age_s: float = 0.0
    offers: tuple[str, ...] = NAMES
    hazard_lights: bool = False

    def ego(self) -> EgoState:
        return EgoState(x_m=self.x, y_m=self.y, yaw_rad=self.yaw, speed_mps=self.speed, length_m=4.9, width_m=1.85)

    def surroundings(self) -> Surroundings:
        sight = tuple(LaneSight(lane_id=s.id, ahead_m=self.sight_m, behind_m=self.behind_m) for s in self.road.lanes)
        return Surroundings(
            frame=self.frame,
            time_s=self.time_s,
            age_s=self.age_s,
            ego=self.ego(),
            objects=tuple(self.objects),
            controls=self.controls,
            sight=sight,
            road=self.road,
        )

    def view(self) -> FrenetScene:
        return FrenetScene(self.surroundings())

    def status(self) -> Status:
        return Status(time_s=self.time_s, speed_mps=abs(self.speed), progress_m=self.x)

    def scene(self, surroundings: Surroundings | None = None) -> Scene:
        view = self.view() if surroundings is None else FrenetScene(surroundings)
        return build_scene(view, self.status(), describe(self.offers))

    def clearance(self) -> float:
        """Gap between the ego's body and the nearest object now, meters; negative in contact."""
        ego = self.ego()
        gaps = [
            float(
                separation(
                    (ego.x_m, ego.y_m, ego.yaw_rad),
                    (ego.length_m / 2, ego.width_m / 2),
                    (o.x_m, o.y_m, o.yaw_rad),
                    (o.length_m / 2, o.width_m / 2),
                )
            )
            for o in self.objects
        ]
        return min(gaps, default=math.inf)

    def drive(self, directive: Directive) -> None:
        """One tick: the directive's path is followed to the point; else straight on, behind what is in the way."""
        if isinstance(directive, Execute) and directive.behavior.hazard_lights_on is not None:
            self.hazard_lights = directive.behavior.hazard_lights_on
        if isinstance(directive, SafeStop):
            self.hazard_lights = True
        if isinstance(directive, Execute) and directive.path:
            self._along(directive)
        elif isinstance(directive, Execute | SafeStop):
            hard = directive.brake_mps2 if isinstance(directive, Execute) else None
            self._settle(0.0, braking=hard or self.ego().limits.comfort_braking_mps2)
        else:
            self.go_on()
        self.objects = [self._moved(o) for o in self.objects]
        self.time_s = round(self.time_s + self.dt, 6)
        self.frame += 1

    def go_on(self) -> None:
        """One tick of the stack's own driver: along its lane, behind whatever is in the way."""
        self._settle(self._free_speed())
        self.y += float(np.clip(-self.y, -0.5, 0.5)) * self.dt

    def _along(self, directive: Execute) -> None:
        if directive.reverse:
            self._back(directive)
            return
        xs = np.array([p.x_m for p in directive.path])
        ys = np.array([p.y_m for p in directive.path])
        bound = float(np.interp(self.x, xs, [p.speed_mps for p in directive.path]))
        self._settle(bound, turn=math.cos(self.yaw))
        y = float(np.interp(self.x, xs, ys))
        step = min(0.5, float(xs[-1]) - self.x)
        if step > 0.05:  # at its end a path has no direction any more
            self.yaw = math.atan2(float(np.interp(self.x + step, xs, ys)) - y, step)
        self.y = y

    def _back(self, directive: Execute) -> None:
        """Straight back, stopping at the end of the path."""
        way = self.x - directive.path[-1].x_m
        wanted = min(directive.path[0].speed_mps, math.sqrt(max(2 * 1.0 * (way - 0.1), 0.0)))
        self.speed = -min(wanted, abs(self.speed) + 1.0 * self.dt)
        self.x += self.speed * self.dt

    def _settle(self, wanted: float, turn: float = 1.0, braking: float = 6.0) -> None:
        self.speed = max(self.speed, 0.0)
        change = float(np.clip(wanted - self.speed, -braking * self.dt, 1.5 * self.dt))
        self.speed = max(self.speed + change, 0.0)
        self.x += self.speed * turn * self.dt

    def _free_speed(self) -> float:
        gaps = [o.x_m - o.length_m / 2 - self.x - 2.45 for o in self.objects if abs(o.y_m) < 1.9 and o.x_m > self.x]
        room = min(gaps, default=1e3) - 5.0
        lead = min((o.vx_mps for o in self.objects if abs(o.y_m) < 1.9 and o.x_m > self.x), default=0.0)
        return float(min(self.cruise_mps, max(lead, 0.0) + math.sqrt(max(2 * 2.0 * room, 0.0))))

    def _moved(self, o: TrackedObject) -> TrackedObject:
        moving = math.hypot(o.vx_mps, o.vy_mps) > 0.1
        stood = 0.0 if moving else (o.stationary_s or 0.0) + self.dt
        update = {"x_m": o.x_m + o.vx_mps * self.dt, "y_m": o.y_m + o.vy_mps * self.dt, "stationary_s": stood}
        return o.model_copy(update=update)


def searched(world: World, scene: Scene | None = None, limits: WaitLimits | None = None) -> Decision:
    """What the search decides in a world; `scene` if it is not the world's as it stands."""
    scene = scene or world.scene()
    reading = None if scene.guidance is None else scene.guidance.reading
    preview = PlanPreview(Guard(), world.view(), lambda plan: intent_authorizes(reading, plan))
    return SearchReasoner(limits).decide(ReasonerRequest(scene, assess=preview.assess)).decision


def noticed(scene: Scene) -> Decision:
    """The observation and analysis of a scene, for a stand-in reasoner that adds a plan of its own."""
    return decide_wait(scene, WaitLimits())


def ladder(
    name: str = "default", *, solid_line: str | None = None, rungs: dict | None = None, **tables: object
) -> Ladder:
    """A profile with changes: `rungs` by kind (None leaves one out), other tables whole."""
    usual = profile(name)
    kept = [
        rung.model_copy(update=changes)
        for rung in usual.rungs
        if (changes := (rungs or {}).get(rung.kind, {})) is not None
    ]
    if solid_line is not None:
        tables["approval"] = Approval(solid_line=solid_line)
    return usual.model_copy(update={"rungs": tuple(kept), **tables})


def stubborn(**more: object) -> Ladder:
    """Rules only, asked for ever."""
    nobody = {"model": None, "passenger": None, "remote": None}
    return ladder(rungs={"reasoner": {"tries": 1000, **more}, **nobody})


@dataclass
class Drive:
    """What a drive with the solver brought to light."""

    events: list[Event] = field(default_factory=list)
    directives: list[Directive] = field(default_factory=list)
    nearest_m: float = math.inf

    def kinds(self) -> list[EventKind]:
        return [e.kind for e in self.events]

    def texts(self, kind: EventKind) -> list[str]:
        return [e.text for e in self.events if e.kind is kind]


def drive(
    world: World,
    seconds: float,
    *,
    words: dict[float, str] | None = None,
    every_tick: Callable[[World], None] | None = None,
    **options: object,
) -> Drive:
    """Drives a world with a solver, lockstep if not told otherwise; `words` are said at their time."""
    seen = Drive()
    said = dict(words or {})
    with StuckSolver(world.scene, on_event=seen.events.append, **{"clock": "lockstep", **options}) as solver:
        for _ in range(round(seconds / world.dt)):
            for when in [when for when in said if when <= world.time_s]:
                solver.guide(said.pop(when))
            directive = solver.step(world.status(), world.surroundings)
            seen.directives.append(directive)
            world.drive(directive)
            seen.nearest_m = min(seen.nearest_m, world.clearance())
            if every_tick is not None:
                every_tick(world)
    return seen
