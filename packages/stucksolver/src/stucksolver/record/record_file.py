"""One record: the content of its lines, and the images in a folder next to it."""

from __future__ import annotations

import base64
import datetime
import hashlib
import importlib.metadata
import platform
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import TypeAdapter, ValidationError

from stucksolver.guard import GuardPolicy
from stucksolver.immobilization import DetectorSettings
from stucksolver.plan import Directive
from stucksolver.plan.json_schemas import VERSION
from stucksolver.privacy.private_files import write_once
from stucksolver.record.hash_chain import ChainWriter, RecordError
from stucksolver.record.serialization import (
    accepted_answer,
    event_data,
    finite,
    inputs_data,
    state_data,
    step_output_data,
)
from stucksolver.record.surroundings_delta import DeltaEncoder
from stucksolver.scene import RoadGeometry, Scene
from stucksolver.scene.base_model import first_problem
from stucksolver.solver.events import Event
from stucksolver.solver.state_machine.inputs import SceneInput
from stucksolver.solver.state_machine.state import Querying, State
from stucksolver.solver.step_listener import SolverInfo, TransitionStep

FORMAT = 4
"""Version of the file format."""
WORDING = 3
"""Version of the texts for people. A replay compares texts only if they have the present one. Raise it with them."""
DETECTOR: TypeAdapter[DetectorSettings] = TypeAdapter(DetectorSettings)
MOST_FILES = 100_000
"""Maximum number of records in a folder. Ours."""


@dataclass(frozen=True)
class RecordLine:
    """Line before its conversion to JSON, which happens outside the control loop. `seen` has packed surroundings."""

    entry: TransitionStep | Event | RoadGeometry
    seen: dict[str, Any] | None = None
    repeats: bool = False
    """True if the directive is the same as in an earlier line."""


class RecordFile:
    """Lines of kind `begin`, `road`, `step`, `fault` and `end`, in the order of the events."""

    def __init__(self, folder: Path, facts: SolverInfo, before: State) -> None:
        """Prepare a record.

        Args:
            folder: Folder of the records.
            facts: Setup of the solver.
            before: State before the first step.
        """
        self._folder = folder
        self._facts = facts
        self._before = before
        self._packer = DeltaEncoder()
        self._last_directive: Directive | None = None
        self._chain: ChainWriter | None = None

    def open(self) -> Path:
        """Begin a new file, never an existing one.

        Raises:
            RecordError: The file cannot be written.
        """
        self._chain = _new_file(self._folder)
        self._line("begin", {**_facts(self._facts), "state": self._state(self._before)})
        return self._chain.path

    def compact(self, entry: TransitionStep | Event) -> list[RecordLine]:
        """Return an entry as lines; fast, for the control loop. Call it in the order of the events.

        The order matters, because each line stores only the difference from the line before.
        """
        if isinstance(entry, Event):
            return [RecordLine(entry)]
        seen = None if entry.sight is None else entry.sight.surroundings
        repeats, self._last_directive = entry.directive is self._last_directive, entry.directive
        if seen is None:
            return [RecordLine(entry, repeats=repeats)]
        road = self._packer.new_road(seen)
        line = RecordLine(entry, self._packer.pack(seen), repeats)
        return [line] if road is None else [RecordLine(road), line]

    def write(self, lines: list[RecordLine]) -> None:
        """Append lines.

        Raises:
            RecordError: The lines cannot be written.
        """
        for line in lines:
            if isinstance(line.entry, Event):
                self._line("fault", {"event": event_data(line.entry, None)})
            elif isinstance(line.entry, RoadGeometry):
                self._line("road", {"road": line.entry.model_dump(mode="json")})
            else:
                self._line("step", self._step(line.entry, line))

    def end(self, how: str) -> None:
        """Write the last line. A record without it is incomplete."""
        self._line("end", {"how": how})
        self.leave()

    def leave(self) -> None:
        """Close the file without a last line."""
        if self._chain is not None:
            self._chain.close()

    def _line(self, kind: str, data: dict[str, Any]) -> None:
        assert self._chain is not None, "open it first"
        self._chain.write({"kind": kind, **data})

    def _state(self, state: State) -> dict[str, Any]:
        data = state_data(state)
        data["scene"] = None if state.scene is None else self._scene(state.scene)
        return data

    def _step(self, step: TransitionStep, line: RecordLine) -> dict[str, Any]:
        """Return the inputs, the outputs, and the directive if it changed."""
        data: dict[str, Any] = {"time_s": step.inputs.status.time_s - step.inputs.offset_s}
        data["in"] = inputs_data(step.inputs, accepted_answer(step))
        if step.sight is not None:
            data["sight"] = {"fault": step.sight.fault, "blind_s": finite(step.sight.blind_s)}
        if line.seen is not None:
            data["seen"] = line.seen
        if step.snapshot is not None:
            data["asked"] = self._snapshot(step, step.snapshot)
        if step.outputs:
            data["told"] = [step_output_data(item, step) for item in step.outputs]
        if not line.repeats:
            data["directive"] = step.directive.model_dump(mode="json")
        return data

    def _snapshot(self, step: TransitionStep, shot: SceneInput) -> dict[str, Any]:
        """Return the scene for the reasoner, if the step queried one."""
        activity = step.after.activity
        scene = activity.query.scene if isinstance(activity, Querying) and shot.scene is not None else shot.scene
        recorded = None if scene is None else self._scene(scene)
        return {"scene": recorded, "why_none": shot.why_none, "camera_fault": shot.camera_fault}

    def _scene(self, scene: Scene) -> dict[str, Any]:
        data = scene.model_dump(mode="json")
        image = scene.image
        if image is not None:
            digest = hashlib.sha256(image.jpeg).hexdigest()
            path = self._folder / "images" / f"{digest}.jpg"
            path.parent.mkdir(parents=True, exist_ok=True)
            write_once(path, image.jpeg)
            data["image"] = {"width": image.width, "height": image.height, "sha256": digest}
        return data


def image_of(data: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Return the JSON form of an image next to a record.

    Raises:
        RecordError: The image is missing or was changed.
    """
    path = folder / "images" / f"{data['sha256']}.jpg"
    try:
        jpeg = path.read_bytes()
    except OSError as error:
        raise RecordError(f"the image {path} is missing: keep the folder `images` next to the record") from error
    if hashlib.sha256(jpeg).hexdigest() != data["sha256"]:
        raise RecordError(f"the image {path} was changed after writing")
    return {"width": data["width"], "height": data["height"], "jpeg": base64.b64encode(jpeg).decode()}


LATER_NUMBERS = {"backing": {"far_m": 8.0}}
"""Numbers of the policy that older records lack. Earlier versions backed up by 8 m at most."""


def policy_of(data: dict[str, Any], path: Path) -> GuardPolicy:
    """Return the complete guard policy of a record.

    A missing number gets no default: the record's plans would be checked with bounds that were never used. Exceptions
    are numbers of `LATER_NUMBERS`, which concern only plans that earlier versions could not make.

    Raises:
        RecordError: A number is missing or unknown.
    """
    data = {**data, **{k: {**later, **data[k]} for k, later in LATER_NUMBERS.items() if isinstance(data.get(k), dict)}}
    try:
        policy = GuardPolicy.model_validate(data)
    except ValidationError as error:
        raise RecordError(f"{path}: the guard's policy cannot be read: {first_problem(error)}") from error
    differs = next(_differences(data, policy.model_dump(mode="json")), None)
    if differs is not None:
        raise RecordError(
            f"{path}: the guard's policy is of another version: {differs}; replay it with the version that wrote it"
        )
    return policy


def _differences(recorded: Any, read: Any, where: str = "") -> Iterator[str]:
    """Yield the names of values that are in only one of two JSON values, or differ."""
    if not (isinstance(recorded, dict) and isinstance(read, dict)):
        if recorded != read:
            yield where.removeprefix(".")
        return
    for name in sorted(recorded.keys() | read.keys()):
        if name in recorded and name in read:
            yield from _differences(recorded[name], read[name], f"{where}.{name}")
        else:
            yield f"{where}.{name}".removeprefix(".")


def _facts(facts: SolverInfo) -> dict[str, Any]:
    """Return everything that determines the course of a run, with versions."""
    return {
        "format": FORMAT,
        "schema": VERSION,
        "wording": WORDING,
        "written": datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds"),
        "versions": {
            "stucksolver": importlib.metadata.version("stucksolver"),
            "python": platform.python_version(),
            "numpy": np.__version__,
            "platform": platform.platform(),
        },
        "clock": facts.clock,
        "reasoners": dict(facts.reasoners),
        "ask_back": facts.ask_back,
        "observe_only": facts.observe_only,
        "vehicle_id": facts.vehicle_id,
        "detector": DETECTOR.dump_python(facts.detector, mode="json"),
        "policy": facts.policy.model_dump(mode="json"),
        "ladder": facts.ladder.model_dump(mode="json", by_alias=True),
    }


def _new_file(folder: Path) -> ChainWriter:
    for number in range(1, MOST_FILES):
        path = folder / f"intervention-{number:04d}.jsonl"
        if not path.exists():
            return ChainWriter(path)
    raise RecordError(f"{folder} holds {MOST_FILES} records: choose another folder")
