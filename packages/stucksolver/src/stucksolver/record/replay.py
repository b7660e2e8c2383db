"""Replays every step of a record without a simulator, and reports the differences."""

from __future__ import annotations

import contextlib
import importlib
import math
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from stucksolver.guard import Guard, Verdict
from stucksolver.ladder import Ladder
from stucksolver.ladder.ladder import FORMER_KIND
from stucksolver.ladder.rung_actions import FIRST_REASONER
from stucksolver.plan import apply_limits_to_decision
from stucksolver.reasoners import ReasonerAnswer, ReasonerError, parse_trace
from stucksolver.reasoners.duties import NAME as DUTIES
from stucksolver.reasoners.duties import decide_wait
from stucksolver.record.hash_chain import RecordError, read_chain
from stucksolver.record.record_file import DETECTOR, FORMAT, WORDING, image_of, policy_of
from stucksolver.record.serialization import (
    accepted_answer,
    complete_ladder,
    inputs_of,
    sight_of,
    snapshot_of,
    state_of,
    step_output_data,
)
from stucksolver.record.surroundings_delta import DeltaDecoder
from stucksolver.scene import Scene
from stucksolver.scene.wording import in_one_line
from stucksolver.solver.state_machine.inputs import SceneInput, SolverSetup
from stucksolver.solver.state_machine.transition import transition
from stucksolver.solver.step_listener import TransitionStep

KINDS = ("begin", "road", "step", "fault", "end")
"""Kinds of lines."""
LATER = frozenset({"margin", "unit", "missing", "zones", "signs", "work_zone", "picture_only"})
"""Fields that older records lack: of a reject reason, a failed attempt, a scene and an observation."""
EQUAL = 1e-6
"""Greatest relative difference between equal numbers: another processor may round differently."""

PROSE = frozenset({"detail", "evidence", "outcome", "rationale", "reason", "text"})
"""Fields with texts for people. No value is derived from them."""


@dataclass(frozen=True)
class ReplayFinding:
    """Recorded value that is derived differently."""

    line: int
    what: str
    recorded: str
    derived: str


@dataclass
class Report:
    """Result of a replay."""

    path: Path
    versions: dict[str, str] = field(default_factory=dict)
    lines: int = 0
    ended: str | None = None
    """End of the intervention; None for an incomplete record."""
    decisions: int = 0
    underivable: int = 0
    """Number of decisions by reasoners without a trace: they are recorded but cannot be derived."""
    plans: int = 0
    ticks: int = 0
    findings: list[ReplayFinding] = field(default_factory=list)
    texts_compared: bool = True
    """False for a record of a version that words its texts for people differently."""

    @property
    def matches(self) -> bool:
        """True if every step was derived as recorded."""
        return not self.findings


def replay(path: Path) -> Report:
    """Read a record and derive it again.

    Raises:
        RecordError: The record was changed or cannot be read.
    """
    with contextlib.suppress(ImportError):
        # The modules of the models register their answer formats. Without the package, such answers are not derived.
        importlib.import_module("stucksolver_language.llm.answer_parser")
    again = _Again(path)
    for number, data in read_chain(path):
        again.line(number, data)
    if not again.report.lines:
        raise RecordError(f"{path}: empty file, not a record")
    return again.report


class _Again:
    """Replay of every step from the state after the previous one."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self.report = Report(path)
        self._unpacker = DeltaDecoder()
        self._directive: dict[str, Any] = {}
        self._lost = False
        """True if a step led to another state, so that no later one can be replayed."""

    def line(self, number: int, data: dict[str, Any]) -> None:
        """Process one line.

        Raises:
            RecordError: The line cannot be read. The message has its number.
        """
        self.report.lines = number
        try:
            kind = data["kind"]
            if (number == 1) is not (kind == "begin"):
                raise RecordError(f"{self._path}, line {number}: a record has one line of kind `begin`, the first one")
            readers = {name: getattr(self, f"_{name}") for name in KINDS}
            readers.get(kind, self._unknown)(number, data)
        except (AttributeError, LookupError, TypeError, ValueError, ArithmeticError, RecursionError) as error:
            raise RecordError(f"{self._path}, line {number}: this line cannot be read: {in_one_line(error)}") from error

    def _unknown(self, number: int, data: dict[str, Any]) -> None:
        raise RecordError(
            f"{self._path}, line {number}: unknown kind of line {data['kind']!r}; a newer version wrote it"
        )

    def _begin(self, number: int, data: dict[str, Any]) -> None:
        if data["format"] != FORMAT:
            raise RecordError(
                f"{self._path}: the record has format {data['format']}; this program reads format {FORMAT}"
            )
        ladder = Ladder.model_validate(complete_ladder(data["ladder"]))
        names, observe_only = data["reasoners"], data["observe_only"]
        names = {FIRST_REASONER if rung == FORMER_KIND else rung: name for rung, name in names.items()}
        self.report.versions = data["versions"]
        self.report.texts_compared = data.get("wording") == WORDING
        self._limits = ladder.waits.limits()
        guard = Guard(policy_of(data["policy"], self._path))
        detector = DETECTOR.validate_python(data["detector"])
        vehicle_id = data.get("vehicle_id", "")
        self._setup = SolverSetup(guard, ladder, names, data["ask_back"], observe_only, detector, vehicle_id)
        state = state_of(data["state"], ladder, frozenset(names), observe_only=observe_only)
        self._state = replace(state, scene=self._scene(data["state"]["scene"]))

    def _road(self, number: int, data: dict[str, Any]) -> None:
        self._unpacker.add_road(data["road"])

    def _fault(self, number: int, data: dict[str, Any]) -> None:
        """Skip a fault outside the steps: no state depends on it."""

    def _end(self, number: int, data: dict[str, Any]) -> None:
        self.report.ended = data["how"]

    # ---- steps

    def _step(self, number: int, data: dict[str, Any]) -> None:
        surroundings = self._unpacker.unpack(data["seen"]) if "seen" in data else None
        self._directive = data.get("directive", self._directive)
        recorded: list[dict[str, Any]] = [_with_present_rung(item) for item in data.get("told", [])]
        for item in recorded:
            self.report.plans += "judged" in item
            self.report.ticks += "tick" in item
        if self._lost:
            return
        before = self._state
        inputs = inputs_of(data["in"], sight_of(data.get("sight"), surroundings), self._snapshot(data), before.question)
        self._state, directive, outputs = transition(before, inputs, self._setup)
        step = TransitionStep(before, inputs, None, None, self._state, directive, outputs)
        derived = [step_output_data(item, step) for item in outputs]
        self._decision(number, step)
        if [_kind(item) for item in recorded] != [_kind(item) for item in derived]:
            self._first_difference(number, recorded, derived)
            derived_text = f"{_kinds(derived)}; no later step is derived"
            self._differs(number, "what happened", _kinds(recorded), derived_text)
            self._lost = True
            return
        for item, other in zip(recorded, derived, strict=True):
            self._compare(number, item, other)
        if not self._same(self._directive, directive.model_dump(mode="json")):
            derived_directive = directive.model_dump(mode="json")
            self._differs(number, "directive", _directive_text(self._directive), _directive_text(derived_directive))

    def _first_difference(self, number: int, recorded: list[dict[str, Any]], derived: list[dict[str, Any]]) -> None:
        """Report the verdict at which the runs diverged, if it was a verdict."""
        for item, other in zip(recorded, derived, strict=False):
            count = len(self.report.findings)
            if _kind(item) == _kind(other):
                self._compare(number, item, other)
            if len(self.report.findings) > count:
                return

    def _compare(self, number: int, recorded: dict[str, Any], derived: dict[str, Any]) -> None:
        ((kind, first),), ((_, second),) = recorded.items(), derived.items()
        if self._same(first, second):
            return
        if kind == "event":
            self._differs(number, f"event {first['kind']}", first["text"], self._where(first, second))
            return
        verdicts = [Verdict.model_validate(each.get("verdict", {})) for each in (first, second)]
        if self._same(verdicts[0].model_dump(mode="json"), verdicts[1].model_dump(mode="json")):
            self._differs(number, "plan" if kind == "judged" else "outcome", str(first), self._where(first, second))
        else:
            what = "verdict at acceptance" if kind == "judged" else "verdict on a tick"
            self._differs(number, what, str(verdicts[0]), str(verdicts[1]))

    def _snapshot(self, data: dict[str, Any]) -> SceneInput:
        query = data.get("asked")
        return snapshot_of(None if query is None else {**query, "scene": self._with_image(query["scene"])})

    def _scene(self, data: dict[str, Any] | None) -> Scene | None:
        return None if data is None else Scene.model_validate(self._with_image(data))

    def _with_image(self, scene: dict[str, Any] | None) -> dict[str, Any] | None:
        image = None if scene is None else scene["image"]
        return scene if scene is None or image is None else {**scene, "image": image_of(image, self._path.parent)}

    # ---- decisions

    def _decision(self, number: int, step: TransitionStep) -> None:
        """Query the reasoner for the same scene again and compare its answer."""
        answer = accepted_answer(step)
        if not isinstance(answer, ReasonerAnswer):
            return
        self.report.decisions += 1
        scene = step.before.scene
        if scene is None or (answer.reasoner != DUTIES and answer.trace is None):
            self.report.underivable += 1
            return
        recorded = answer.decision
        try:
            derived = parse_trace(answer.trace, scene) if answer.trace else decide_wait(scene, self._limits)
        except ReasonerError as error:
            self._differs(number, "decision", recorded.rationale, f"no answer: {error}")
            return
        derived = apply_limits_to_decision(derived, scene)
        if not self._same(recorded.model_dump(mode="json"), derived.model_dump(mode="json")):
            self._differs(number, "decision", recorded.rationale, derived.rationale)

    def _where(self, first: dict[str, Any], second: dict[str, Any]) -> str:
        """Return the first field in which the second value differs, with its content."""
        names = sorted(first.keys() | second.keys())
        name = next((k for k in names if not self._same(first.get(k), second.get(k))), None)
        if name is None:
            # A field without a value is in one of them only.
            name = min(first.keys() ^ second.keys())
        return f"{name}: {second.get(name)}"

    def _same(self, first: Any, second: Any) -> bool:
        """Return True if two values are equal: numbers up to rounding, texts for people only in the same version."""
        if isinstance(first, float) and isinstance(second, float):
            return math.isclose(first, second, rel_tol=EQUAL, abs_tol=EQUAL)
        if isinstance(first, dict) and isinstance(second, dict):
            prose = frozenset[str]() if self.report.texts_compared else PROSE
            compared = [name for name in first if name not in prose or not isinstance(first[name], str)]
            known = first.keys() | (second.keys() & LATER)
            return known == second.keys() and all(self._same(first[name], second[name]) for name in compared)
        if isinstance(first, list) and isinstance(second, list):
            return len(first) == len(second) and all(map(self._same, first, second))
        return bool(first == second)

    def _differs(self, line: int, what: str, recorded: str, derived: str) -> None:
        self.report.findings.append(ReplayFinding(line, what, recorded, derived))


def _with_present_rung(item: dict[str, Any]) -> dict[str, Any]:
    """Return an output with the present name of its rung."""
    event = item.get("event")
    if not isinstance(event, dict) or event.get("rung") != FORMER_KIND:
        return item
    return item | {"event": event | {"rung": FIRST_REASONER}}


def _kind(output: dict[str, Any]) -> str:
    """Return the kind of a step output in a word or two."""
    ((kind, data),) = output.items()
    return str(data["kind"]) if kind == "event" else kind


def _kinds(outputs: list[dict[str, Any]]) -> str:
    return ", ".join(map(_kind, outputs)) or "nothing"


def _directive_text(directive: dict[str, Any]) -> str:
    behavior = directive.get("behavior")
    return f"execute {behavior['name']}" if behavior else str(directive)
