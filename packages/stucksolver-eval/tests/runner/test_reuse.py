"""Which routes of another evaluation are taken over, without driving anything."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from stucksolver_eval.guidance import Script, ScriptLine
from stucksolver_eval.results.manifest import EvaluationManifest
from stucksolver_eval.results.outcome import InterventionRecord, QueryRecord, RouteOutcome
from stucksolver_eval.results.store import ResultStore, StoreError
from stucksolver_eval.routes import Route
from stucksolver_eval.runner.evaluate import EvaluationSpec, _alike, _take, manifest_of
from stucksolver_eval.suites import load_routes
from stucksolver_eval.systems.spec import SystemSpec

ROUTES = load_routes("dev", ("1000", "1021", "1042"))
QUIET, ASKED, CRASHED = ROUTES
RULES = SystemSpec(recovery="search")
BOTH = SystemSpec(recovery="search", reasoner="search")


def asks(folder: Path, arm: SystemSpec) -> EvaluationManifest:
    return manifest_of(EvaluationSpec(suite="dev", out=folder, arm=arm), ROUTES)


def outcome_of(route: Route, arm: SystemSpec, **more: Any) -> RouteOutcome:
    return RouteOutcome(route_id=route.id, scenario="Accident", town=route.town, seed=1, arm=arm.name, **more)


def driven(folder: Path, arm: SystemSpec = RULES) -> ResultStore:
    """One route without a request for help, one with, and one that crashed."""
    store = ResultStore(folder)
    store.begin(asks(folder, arm), ROUTES, resume=False)
    for route, asked_s, state in ((QUIET, None, "driven"), (ASKED, 31.0, "driven"), (CRASHED, None, "crashed")):
        store.write_outcome(route, outcome_of(route, arm, state=state, asked_s=asked_s))
    return store


def taken(other: Path, out: Path, arm: SystemSpec, script: Script | None = None) -> list[str]:
    manifest = asks(out, arm)
    store, alike = ResultStore(out), _alike(other, manifest)
    store.begin(manifest, ROUTES, resume=False)
    _take(store, alike, ROUTES, script or Script(routes={}), arm)
    found = [route for route in ROUTES if store.is_done(route, 1)]
    outcomes = [store.outcome(route, 1) for route in found]
    assert all(o is not None and o.arm == arm.name for o in outcomes)
    return [route.id for route in found]


def test_reuse_model_after_rules_redrives_only_routes_with_help(tmp_path: Path) -> None:
    """A model after the rules changes only routes with a request for help; the others are reused."""
    driven(tmp_path / "rules")
    assert taken(tmp_path / "rules", tmp_path / "both", BOTH) == [QUIET.id]


def test_the_same_arm_is_taken_whole(tmp_path: Path) -> None:
    driven(tmp_path / "rules")
    assert taken(tmp_path / "rules", tmp_path / "again", RULES) == [QUIET.id, ASKED.id]


def test_routes_with_words_are_driven(tmp_path: Path) -> None:
    driven(tmp_path / "both", BOTH)
    line = ScriptLine.model_validate({"when": {"time_s": 1.0}, "say": ["go on"], "kind": "helpful"})
    script = Script(routes={QUIET.id: (line,)})
    assert taken(tmp_path / "both", tmp_path / "guided", BOTH, script) == [ASKED.id]


def test_reuse_other_reasoner_or_ladder_is_rejected(tmp_path: Path) -> None:
    """Another reasoner or a ladder of the user's is not the same system, and its routes are not reused."""
    driven(tmp_path / "both", BOTH)
    with pytest.raises(StoreError, match="its reasoner is 'search', not ''"):
        taken(tmp_path / "both", tmp_path / "rules", RULES)
    driven(tmp_path / "plain")
    ladder = Path(__file__).parents[4] / "packages/stucksolver/src/stucksolver/ladder/default.toml"
    with pytest.raises(StoreError, match="the ladder differs"):
        taken(tmp_path / "plain", tmp_path / "mine", SystemSpec(recovery="search", reasoner="search", ladder=ladder))


def test_reuse_driver_alone_takes_routes_without_recovery_action(tmp_path: Path) -> None:
    """The driver alone reuses the routes on which the recovery neither acted nor requested help."""
    rules, (idle, moved, asked) = ResultStore(tmp_path / "rules"), ROUTES
    rules.begin(asks(tmp_path / "rules", RULES), ROUTES, resume=False)
    plan = InterventionRecord(
        start_s=4.0, end_s=9.0, place_m=3.0, rung="rules", behaviors=("wait",), moves=False, finished=True
    )
    for route, plans, asked_s in ((idle, (), None), (moved, (plan,), None), (asked, (), 31.0)):
        queries = (QueryRecord(asked_s=2.0),)
        rules.write_outcome(route, outcome_of(route, RULES, asked_s=asked_s, interventions=plans, queries=queries))
    assert taken(tmp_path / "rules", tmp_path / "alone", SystemSpec()) == [idle.id]
    outcome = ResultStore(tmp_path / "alone").outcome(idle, 1)
    assert outcome is not None and outcome.queries == ()


def test_a_recovery_takes_nothing_from_the_driver_alone(tmp_path: Path) -> None:
    driven(tmp_path / "alone", SystemSpec())
    with pytest.raises(StoreError, match="its recovery is 'none', not 'search'"):
        taken(tmp_path / "alone", tmp_path / "rules", RULES)
