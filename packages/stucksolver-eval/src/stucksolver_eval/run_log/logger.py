"""Logs a run for its replay: poses at a fixed interval, decisions and events."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Literal

from stucksolver.plan import Directive, Execute, Replan, SafeStop
from stucksolver.plan.mirror import mirrored_decision
from stucksolver.scene import TrackedObject
from stucksolver.scene.mirror import mirrored_reading
from stucksolver.solver import Event, EventKind
from stucksolver_carla.stack.carla_frames import to_local
from stucksolver_carla.stack.contact import footprint
from stucksolver_carla.stack.front_camera import PictureSource
from stucksolver_carla.stack.ground_truth_tracker import Tracker
from stucksolver_eval.results.outcome import came_to
from stucksolver_eval.results.run_log import ActorInfo, ActorRole, DecisionMoment, LogEvent, Polyline, RunLogFrame
from stucksolver_eval.run_log.thumbnail import thumbnail

if TYPE_CHECKING:
    import carla

RANGE_M = 160.0
"""Distance from the ego within which actors are logged (m). Ours."""
LIGHT_RANGE_M = 120.0
"""Distance from the ego within which traffic lights are logged (m). Ours."""

Kind = Literal["guidance", "directive", "abort", "outcome", "infraction", "stuck", "run"]
_KINDS: dict[EventKind, Kind] = {
    EventKind.ASKED_BACK: "outcome",
    EventKind.ABORTED: "abort",
    EventKind.FINISHED: "outcome",
    EventKind.FAILED: "outcome",
    EventKind.GUIDANCE_ENDED: "outcome",
}


class RunLogger:
    """Collects the data of the replay. All times are seconds since the start of the run.

    With a `camera`, each decision includes the image at the time of its query.
    """

    def __init__(
        self,
        world: carla.World,
        ego: carla.Vehicle,
        role_of: Callable[[str], ActorRole],
        frame_every_s: float,
        camera: PictureSource | None = None,
    ) -> None:
        self._world = world
        self._ego = ego
        self._role_of = role_of
        self._frame_every_s = frame_every_s
        self._camera = camera
        self._picture: str | None = None
        self._tracker = Tracker(world, ego.id, RANGE_M)
        self._lights = [
            (light, to_local(light.get_location())) for light in world.get_actors().filter("*traffic_light*")
        ]
        self._index: dict[str, int] = {}
        self._next_frame_s = 0.0
        self._path: Polyline = ()
        self._last_directive: Directive | None = None
        self._start_s = float(world.get_snapshot().timestamp.elapsed_seconds)
        box = ego.bounding_box.extent
        self._size = (2 * float(box.x), 2 * float(box.y))
        self.actors = [ActorInfo(label="ego", kind="car", length_m=self._size[0], width_m=self._size[1], role="ego")]
        self.frames: list[RunLogFrame] = []
        self.decisions: list[DecisionMoment] = []
        self.events: list[LogEvent] = []

    def frame(self, time_s: float, speed_mps: float) -> None:
        """Log all poses if a frame is due."""
        if time_s < self._next_frame_s - 1e-6:
            return
        self._next_frame_s = time_s + self._frame_every_s
        transform = self._ego.get_transform()
        x, y = to_local(transform.location)
        objects = self._tracker.update(footprint(self._ego), self._start_s + time_s)
        poses = [(0, round(x, 2), round(y, 2), round(-transform.rotation.yaw, 1))]
        poses += [(self._actor(o), round(o.x_m, 2), round(o.y_m, 2), round(o.yaw_rad * 57.29578, 1)) for o in objects]
        lights = tuple(
            (round(p[0], 1), round(p[1], 1), str(light.get_state()).lower())
            for light, p in self._lights
            if abs(p[0] - x) < LIGHT_RANGE_M and abs(p[1] - y) < LIGHT_RANGE_M
        )
        self.frames.append(
            RunLogFrame(
                time_s=round(time_s, 2),
                speed_mps=round(speed_mps, 2),
                poses=tuple(poses),
                lights=lights,
                path=self._path,
            )
        )

    def _actor(self, o: TrackedObject) -> int:
        if o.id not in self._index:
            self._index[o.id] = len(self.actors)
            self.actors.append(
                ActorInfo(
                    label=f"{o.kind.value} {o.id}",
                    kind=o.kind.value,
                    length_m=round(o.length_m, 2),
                    width_m=round(o.width_m, 2),
                    role=self._role_of(o.id),
                )
            )
        return self._index[o.id]

    def directive(self, time_s: float, directive: Directive) -> None:
        """Log the directive if it has changed."""
        if directive is self._last_directive:
            return
        self._last_directive = directive
        self._path = ()
        if isinstance(directive, Execute):
            self._path = tuple((round(p.x_m, 2), round(p.y_m, 2)) for p in directive.path[::4])
            self.event(time_s, "directive", f"execute {directive.behavior.name}")
        elif isinstance(directive, Replan):
            self.event(time_s, "directive", f"replan the route from {directive.route_start or 'here'}")
        elif isinstance(directive, SafeStop):
            self.event(time_s, "directive", f"safe stop: {directive.reason}")

    def event(self, time_s: float, kind: Kind, text: str) -> None:
        """Log an event."""
        self.events.append(LogEvent(time_s=round(time_s, 2), kind=kind, text=text))

    def hear(self, event: Event) -> None:
        """Log an event of the solver."""
        time_s = event.time_s - self._start_s
        if event.kind is EventKind.TRIGGERED and self._camera is not None:
            image = self._camera.image()
            self._picture = None if image is None else thumbnail(image)
        elif event.kind is EventKind.DECIDED and event.decision is not None:
            outcome, verdict = came_to(event.verdict)
            decision = mirrored_decision(event.decision) if event.mirrored else event.decision
            self.decisions.append(
                DecisionMoment(
                    time_s=round(time_s, 2),
                    trigger="guidance" if event.trigger == "guidance" else "detector",
                    decision=decision.model_dump(mode="json"),
                    outcome=outcome,
                    codes=() if event.verdict is None else event.verdict.codes,
                    verdict=verdict,
                    picture=self._picture,
                )
            )
        elif event.kind is EventKind.GUIDANCE:
            self.event(time_s, "guidance", event.text)
            if event.reading is not None:
                reading = mirrored_reading(event.reading) if event.mirrored else event.reading
                self.event(time_s, "outcome", f"understood: {reading.description}")
        elif event.kind in _KINDS:
            self.event(time_s, _KINDS[event.kind], event.text)
