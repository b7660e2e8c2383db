"""Collects a route's replay in the form of the report's player."""

from __future__ import annotations

from stucksolver.plan import CONTINUE, Directive
from stucksolver_eval.metrics.run_result import immobilizations, run_result
from stucksolver_eval.results.checkpoint import RouteRecord, status_text
from stucksolver_eval.results.outcome import RouteOutcome
from stucksolver_eval.results.run_log import ActorRole, RunLog
from stucksolver_eval.run_log.logger import RunLogger
from stucksolver_eval.run_log.map_view import map_view
from stucksolver_eval.runner.job import RouteJob
from stucksolver_eval.scenario_context import ScenarioContext
from stucksolver_eval.systems.solver_system import SolverSystem
from stucksolver_eval.systems.system_under_test import TickInfo


class ReplayKeeper:
    """Call `tick` once per tick and `log` at the end, which returns None if this replay is not needed."""

    def __init__(self, job: RouteJob, setting: ScenarioContext, arm: SolverSystem | None) -> None:
        self._job, self._setting = job, setting
        camera = None if arm is None else arm.camera
        self._logger = RunLogger(setting.world, setting.hero, self._role, job.frame_every_s, camera)
        if arm is not None:
            arm.listen(self._logger.hear)

    def _role(self, actor_id: str) -> ActorRole:
        actor = self._setting.world.get_actor(int(actor_id))
        role = "" if actor is None else actor.attributes.get("role_name", "")
        if role == "background":
            return "traffic"
        return "scenario" if role == "scenario" else "prop"

    def tick(self, now: TickInfo, directive: Directive | None) -> None:
        """Log a frame and the directive."""
        self._logger.frame(now.time_s, now.speed_mps)
        self._logger.directive(now.time_s, directive or CONTINUE)

    def log(self, record: RouteRecord, outcome: RouteOutcome) -> RunLog | None:
        """Return the complete run, or None if its replay is not needed."""
        if self._job.replays == "failed" and record.success and not outcome.interventions:
            return None
        logger, job = self._logger, self._job
        for noted in (*outcome.infractions, *outcome.near_misses):
            if noted.kind != "min_speed_infractions":
                logger.event(noted.time_s, "infraction", noted.text)
        for line in outcome.guidance if job.arm.recovery in ("none", "timers") else ():
            logger.event(line.time_s, "guidance", f"{line.text} (nobody is listening)")
        met = immobilizations(outcome)
        for item in met:
            if item.recovered_after_s is not None:
                text = f"recovered: 15 m of new progress, {item.recovered_after_s:.1f} s after the onset"
                logger.event(item.ended_s, "outcome", text)
        logger.event(outcome.ticks * self._setting.dt_s, "run", status_text(record.status))
        places = [(w.transform.location.x, -w.transform.location.y) for w in self._setting.route.waypoints]
        return RunLog(
            scenario=f"{job.scenario}, route {job.route.id}",
            arm=job.arm.name,
            seed=job.seed,
            driver=job.arm.driver,
            reasoner=job.arm.recovery,
            clock=job.arm.clock,
            perception=job.arm.perception,
            map=map_view(self._setting.map, places),
            route=tuple((round(x, 2), round(y, 2)) for x, y in places[::2]),
            actors=tuple(logger.actors),
            frames=tuple(logger.frames),
            stuck=tuple((item.onset_s, item.ended_s) for item in met),
            decisions=tuple(logger.decisions),
            events=tuple(sorted(logger.events, key=lambda e: e.time_s)),
            result=run_result(record, outcome, len(logger.decisions)),
        )
