"""A small evaluation on the disk, without a simulator."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from stucksolver.atomic_files import write_text
from stucksolver_eval.criteria import Infraction
from stucksolver_eval.results.checkpoint import RouteRecord, make_record
from stucksolver_eval.results.manifest import EvaluationManifest, suite_digest
from stucksolver_eval.results.metric_info import NAMES, MetricInfo
from stucksolver_eval.results.outcome import RouteOutcome
from stucksolver_eval.results.store import ResultStore
from stucksolver_eval.routes import Position, Route, RoutePose, ScenarioSpec

ORIGIN = Position(0.0, 0.0, 0.0)


def route(number: int, scenario: str = "Accident") -> Route:
    spec = ScenarioSpec(f"{scenario}_{number}", scenario, RoutePose(ORIGIN, 0.0), {})
    return Route(str(number), "town", (ORIGIN, Position(100.0, 0.0, 0.0)), (), (spec,))


CRASH = Infraction("collisions_vehicle", 1.0, "collision")
ROUTES = (route(1), route(2, "T_Junction"))


def manifest(**changes: Any) -> EvaluationManifest:
    usual: dict[str, Any] = {
        "suite": "two",
        "suite_digest": suite_digest(ROUTES),
        "routes": len(ROUTES),
        "seeds": (1,),
        "driver": "behavior:normal",
        "recovery": "none",
        "clock": "lockstep",
        "perception": "privileged",
    }
    return EvaluationManifest(**(usual | changes))


def record(of: Route, completion: float = 100.0, failure: str | None = None, *infractions: Infraction) -> RouteRecord:
    return make_record(
        route_id=of.id,
        scenario=of.scenarios[0].type,
        town=of.town,
        length_m=100.0,
        game_s=20.0,
        wall_s=2.0,
        completion_pct=completion,
        failure=failure,
        infractions=infractions,
    )


def outcome(of: Route, seed: int = 1, **changes: Any) -> RouteOutcome:
    usual = {"route_id": of.id, "scenario": of.scenarios[0].type, "town": of.town, "seed": seed, "arm": "driver alone"}
    return RouteOutcome(**(usual | changes))


def metric_info(ticks: int = 40) -> MetricInfo:
    info = MetricInfo()
    rows = np.zeros((ticks, 18))
    rows[:, 6] = rows[:, 10] = 1.0
    info._rows = [tuple(row) for row in rows.tolist()]
    return info


def begun(folder: Path, **changes: Any) -> ResultStore:
    store = ResultStore(folder)
    store.begin(manifest(**changes), ROUTES, resume=False)
    return store


def keep(store: ResultStore, of: Route, seed: int, kept: RouteRecord) -> None:
    """Write a driven route's files."""
    name = kept.save_name
    metric_info().write(store.folder / f"seed-{seed}" / "metrics" / name)
    from stucksolver_eval.results.checkpoint import checkpoint_text

    write_text(store.folder / f"seed-{seed}" / "records" / f"{name}.json", checkpoint_text(kept))
    store.write_outcome(of, outcome(of, seed, points=101, length_m=100.0))


__all__ = ["CRASH", "NAMES", "ROUTES", "begun", "keep", "manifest", "metric_info", "outcome", "record", "route"]
