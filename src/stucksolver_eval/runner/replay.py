"""Collects a route's replay in the form that the report's player shows."""

from __future__ import annotations

from collections import Counter
from typing import Any

from stucksolver.decision import CONTINUE, Directive
from stucksolver_eval.arms.arm import Now
from stucksolver_eval.arms.solver_arm import SolverArm
from stucksolver_eval.replay.logger import RunLogger
from stucksolver_eval.replay.mapview import map_view
from stucksolver_eval.results.outcome import RouteOutcome
from stucksolver_eval.results.record import RouteRecord, status_text
from stucksolver_eval.results.runlog import ActorRole, RunLog, RunResult
from stucksolver_eval.runner.job import RouteJob
from stucksolver_eval.setting import Setting


class ReplayKeeper:
    """Call `tick` once per tick and `log` at the end, which returns None if this replay is not wanted."""

    def __init__(self, job: RouteJob, setting: Setting, arm: SolverArm | None) -> None:
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

    def tick(self, now: Now, directive: Directive | None) -> None:
        """Log a frame and the directive."""
        self._logger.frame(now.time_s, now.speed_mps)
        self._logger.directive(now.time_s, directive or CONTINUE)

    def log(self, record: RouteRecord, outcome: RouteOutcome) -> RunLog | None:
        """Return the complete run, or None if its replay is not wanted."""
        if self._job.replays == "failed" and record.success and not outcome.interventions:
            return None
        logger, job = self._logger, self._job
        for noted in (*outcome.infractions, *outcome.near_misses):
            if noted.kind != "min_speed_infractions":
                logger.event(noted.time_s, "infraction", noted.text)
        for said in outcome.guidance if job.arm.recovery in ("none", "timers") else ():
            logger.event(said.time_s, "guidance", f"{said.text} (nobody is listening)")
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
            stuck=tuple((s.onset_s, s.ended_s) for s in outcome.spells),
            decisions=tuple(logger.decisions),
            events=tuple(sorted(logger.events, key=lambda e: e.time_s)),
            result=_result(record, outcome, len(logger.decisions)),
        )


def _result(record: RouteRecord, outcome: RouteOutcome, decisions: int) -> RunResult:
    counts: Counter[str] = Counter(i.kind for i in outcome.infractions if i.kind != "min_speed_infractions")
    if outcome.near_misses:
        counts["near_miss"] = len(outcome.near_misses)
    recovered = [s.recovered_after_s for s in outcome.spells if s.recovered_after_s is not None]
    values: dict[str, Any] = {
        "status": record.status,
        "route_completion_pct": record.scores.score_route,
        "infractions": dict(counts),
        "stopped_s": round(sum(s.ended_s - s.onset_s for s in outcome.spells), 2),
        "time_to_recover_s": round(recovered[0], 2) if recovered else None,
        "immobilizations": len(outcome.spells),
        "decisions": decisions,
        "plans_accepted": len(outcome.interventions),
        "duration_s": record.meta.duration_game,
        "distance_m": round(record.scores.score_route / 100.0 * outcome.length_m, 1),
    }
    return RunResult(**values)
