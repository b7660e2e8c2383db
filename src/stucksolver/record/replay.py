"""Derives every decision and every verdict of a record again, without a simulator, and says what does not match."""

from __future__ import annotations

import contextlib
import importlib
import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from stucksolver.decision import Decision, Directive, Execute, RecoveryPlan
from stucksolver.decision.directive import directive_adapter
from stucksolver.guard import Approvals, Guard, Verdict
from stucksolver.ladder import Ladder
from stucksolver.reason import ReasonerError, RuleReasoner, parse_trace
from stucksolver.record.chain import RecordError, read_chain
from stucksolver.record.compact import Unpacker
from stucksolver.record.scroll import APPROVALS, FORMAT, image_of, policy_of
from stucksolver.scene import Scene, Surroundings
from stucksolver.scene.model import Model
from stucksolver.scene.view import View
from stucksolver.solver.events import Event, EventKind
from stucksolver.solver.machine.admission import admit
from stucksolver.solver.machine.execution import Execution, Outcome
from stucksolver.solver.machine.history import History
from stucksolver.solver.questions import QuestionKind

KINDS = ("begin", "road", "event", "judged", "tick", "end")
EQUAL = 1e-6
"""Figures may differ by this much, relatively: another processor may round another way."""


@dataclass(frozen=True)
class Finding:
    """Something that was recorded in a line, and comes out otherwise."""

    line: int
    what: str
    recorded: str
    derived: str


@dataclass
class Report:
    """What a replay brought to light."""

    path: Path
    versions: dict[str, str] = field(default_factory=dict)
    lines: int = 0
    ended: str | None = None
    """How the intervention ended; None for a record that breaks off."""
    decisions: int = 0
    underivable: int = 0
    """Decisions of reasoners that leave no trace: recorded, but they cannot be derived."""
    plans: int = 0
    ticks: int = 0
    findings: list[Finding] = field(default_factory=list)

    @property
    def matches(self) -> bool:
        return not self.findings


def replay(path: Path) -> Report:
    """Read a record and derive it again. Raises `RecordError` for one that was changed or cannot be read."""
    with contextlib.suppress(ImportError):
        # The models' own forms of an answer are registered where they are defined.
        importlib.import_module("stucksolver.reason.llm.answer")
    again = _Again(path)
    for number, data in read_chain(path):
        again.line(number, data)
    again.settle_judgement()
    if not again.report.lines:
        raise RecordError(f"{path}: this is an empty file, not a record")
    return again.report


@dataclass(frozen=True)
class _Judged:
    line: int
    plan: RecoveryPlan
    approvals: Approvals
    guided: bool
    view: View
    now_s: float
    verdict: Verdict


class _Again:
    """Walks through the lines with a guard and a rule reasoner made from the first one."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self.report = Report(path)
        self._unpacker = Unpacker()
        self._scene: Scene | None = None
        self._waiting: _Judged | None = None
        self._execution: Execution | None = None
        self._last_plan: RecoveryPlan | None = None
        self._said: Directive | None = None

    def line(self, number: int, data: dict[str, Any]) -> None:
        """Take one line. Raises `RecordError` with its number where it cannot be read."""
        self.report.lines = number
        try:
            kind = data["kind"]
            if (number == 1) is not (kind == "begin"):
                raise RecordError(f"{self._path}, line {number}: a record begins with its one line of kind `begin`")
            readers = {name: getattr(self, f"_{name}") for name in KINDS}
            readers.get(kind, self._unknown)(number, data)
        except (KeyError, TypeError, ValueError) as error:
            raise RecordError(f"{self._path}, line {number}: this line cannot be read: {error!r}") from error

    def _unknown(self, number: int, data: dict[str, Any]) -> None:
        raise RecordError(
            f"{self._path}, line {number}: unknown kind of line {data['kind']!r}; a newer version wrote it"
        )

    def _begin(self, number: int, data: dict[str, Any]) -> None:
        if data["format"] != FORMAT:
            raise RecordError(f"{self._path}: written in format {data['format']}, this program reads {FORMAT}")
        ladder = Ladder.model_validate(data["ladder"])
        self.report.versions = data["versions"]
        self._guard = Guard(policy_of(data["policy"], self._path))
        self._rules = RuleReasoner(ladder.waits.limits())
        self._history = History(ladder.asking.remembered)

    def _road(self, number: int, data: dict[str, Any]) -> None:
        self._unpacker.add_road(data["road"])

    def _end(self, number: int, data: dict[str, Any]) -> None:
        self.report.ended = data["how"]

    # ---- decisions

    def _event(self, number: int, data: dict[str, Any]) -> None:
        event = self._read_event(data["event"])
        if event.scene is not None:
            self._scene = event.scene
        self.settle_judgement()
        if event.decision is not None:
            self.report.decisions += 1
            self._decide(number, event, event.decision)
        question = event.question
        if event.kind is EventKind.USELESS and self._last_plan is not None:
            self._history = self._history.useless(self._last_plan)
        denied = event.answer is False
        if denied and question and question.plan and question.kind is QuestionKind.APPROVAL:
            self._history = self._history.denied(question.plan)

    def _read_event(self, data: dict[str, Any]) -> Event:
        image = (data.get("scene") or {}).get("image")
        if image is not None:
            data["scene"]["image"] = image_of(image, self._path.parent)
        return Event.model_validate(data)

    def _decide(self, number: int, event: Event, recorded: Decision) -> None:
        scene = event.scene
        if scene is None or (event.reasoner != self._rules.name and event.trace is None):
            self.report.underivable += 1
            return
        try:
            derived = parse_trace(event.trace, scene) if event.trace else self._rules.decide(scene)
        except ReasonerError as error:
            self._differs(number, "decision", recorded.rationale, f"no answer: {error}")
            return
        if not _same(recorded.model_dump(mode="json"), derived.model_dump(mode="json")):
            self._differs(number, "decision", recorded.rationale, derived.rationale)

    # ---- verdicts

    def _judged(self, number: int, data: dict[str, Any]) -> None:
        self.settle_judgement()
        plan = RecoveryPlan.model_validate(data["plan"])
        approvals = APPROVALS.validate_python(data["approvals"])
        view = View(self._unpacker.unpack(data["seen"]))
        self._waiting = _Judged(number, plan, approvals, data["guided"], view, data["now_s"], _verdict(data))

    def settle_judgement(self) -> None:
        """Judge the plan that waits for its scene."""
        judged, self._waiting = self._waiting, None
        if judged is None:
            return
        self.report.plans += 1
        again = admit(
            judged.plan,
            judged.view,
            judged.now_s,
            guard=self._guard,
            scene=self._scene,
            history=self._history,
            guided=judged.guided,
            approvals=judged.approvals,
            again=True,
        )
        self._compare(judged.line, "verdict at acceptance", judged.verdict, again.verdict)
        if again.verdict.accepted:
            self._execution, self._last_plan = again.execution, judged.plan

    def _tick(self, number: int, data: dict[str, Any]) -> None:
        self.settle_judgement()
        self.report.ticks += 1
        seen: Surroundings = self._unpacker.unpack(data["seen"])
        if "directive" in data:
            self._said = directive_adapter.validate_python(data["directive"])
        recorded = Outcome(**data["outcome"]) if "outcome" in data else self._said
        execution = self._execution
        if execution is None:
            self._differs(number, "tick", str(recorded), "no plan is running")
            return
        if data.get("withdrawn"):
            execution.withdraw()
        derived = execution.tick(View(seen), data["now_s"])
        self._compare(number, "verdict on a tick", _verdict(data), execution.last_verdict)
        if type(derived) is not type(recorded) or not _same(_plain(recorded), _plain(derived)):
            self._differs(number, "directive", _short(recorded), _short(derived))
        if isinstance(recorded, Outcome):
            self._execution = None
            if not recorded.finished:
                self._history = self._history.aborted(execution.plan, execution.last_verdict)

    def _compare(self, line: int, what: str, recorded: Verdict, derived: Verdict) -> None:
        if not _same(recorded.model_dump(mode="json"), derived.model_dump(mode="json")):
            self._differs(line, what, str(recorded), str(derived))

    def _differs(self, line: int, what: str, recorded: str, derived: str) -> None:
        self.report.findings.append(Finding(line, what, recorded, derived))


def _verdict(data: dict[str, Any]) -> Verdict:
    return Verdict.model_validate(data.get("verdict", {}))


def _plain(result: Model | Outcome) -> Any:
    return result.recorded() if isinstance(result, Outcome) else result.model_dump(mode="json")


def _short(result: object) -> str:
    return f"execute {result.behavior.name}" if isinstance(result, Execute) else str(result)


def _same(one: Any, other: Any) -> bool:
    """Equal, with figures compared up to rounding."""
    if isinstance(one, float) and isinstance(other, float):
        return math.isclose(one, other, rel_tol=EQUAL, abs_tol=EQUAL)
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(_same(one[k], other[k]) for k in one)
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(_same, one, other))
    return bool(one == other)
