"""One record: what stands in each of its lines, and the images beside it."""

from __future__ import annotations

import base64
import datetime
import hashlib
import importlib.metadata
import platform
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import TypeAdapter, ValidationError

from stucksolver.decision import Directive
from stucksolver.decision.schema import VERSION
from stucksolver.detect import DetectorSettings
from stucksolver.guard import Approvals, GuardPolicy
from stucksolver.record.chain import ChainWriter, RecordError
from stucksolver.record.compact import Packer
from stucksolver.scene import RoadGeometry
from stucksolver.solver.events import Event, Facts, Judgement, Tick
from stucksolver.solver.machine.execution import Outcome

FORMAT = 3
APPROVALS: TypeAdapter[Approvals] = TypeAdapter(Approvals)
DETECTOR: TypeAdapter[DetectorSettings] = TypeAdapter(DetectorSettings)
MOST_FILES = 100_000
Lines = list[tuple[str, "Event | RoadGeometry | dict[str, Any]"]]


class Scroll:
    """Lines of kind `begin`, `road`, `event`, `judged`, `tick`, `end`, in the order in which things happened."""

    def __init__(self, folder: Path, facts: Facts) -> None:
        self._folder = folder
        self._facts = facts
        self._packer = Packer()
        self._said: Directive | None = None
        self._chain: ChainWriter | None = None

    def open(self) -> Path:
        """Begin a new file, never an old one again. Raises `RecordError`."""
        self._chain = _new_file(self._folder)
        self._line("begin", _facts(self._facts))
        return self._chain.path

    def compact(self, entry: Event | Judgement | Tick) -> Lines:
        """What an entry says, as lines: quick, for the control loop. Call it in the order in which things happen."""
        if isinstance(entry, Event):
            return [("event", entry)]
        road = self._packer.new_road(entry.surroundings)
        kind, data = ("judged", self._judgement(entry)) if isinstance(entry, Judgement) else ("tick", self._tick(entry))
        return [(kind, data)] if road is None else [("road", road), (kind, data)]

    def write(self, lines: Lines) -> None:
        """Append them. Raises `RecordError`."""
        for kind, said in lines:
            if isinstance(said, Event):
                self._line(kind, {"event": self._event(said)})
            elif isinstance(said, RoadGeometry):
                self._line(kind, {"road": said.model_dump(mode="json")})
            else:
                self._line(kind, said)

    def end(self, how: str) -> None:
        """The last line; a record without it was broken off."""
        self._line("end", {"how": how})
        self.leave()

    def leave(self) -> None:
        if self._chain is not None:
            self._chain.close()

    def _line(self, kind: str, data: dict[str, Any]) -> None:
        assert self._chain is not None, "open it first"
        self._chain.write({"kind": kind, **data})

    def _event(self, event: Event) -> dict[str, Any]:
        data = event.model_dump(mode="json", exclude_none=False)
        data = {key: value for key, value in data.items() if value is not None}
        image = event.scene.image if event.scene else None
        if image is not None:
            digest = hashlib.sha256(image.jpeg).hexdigest()
            _write_once(self._folder / "images" / f"{digest}.jpg", image.jpeg)
            data["scene"]["image"] = {"width": image.width, "height": image.height, "sha256": digest}
        return data

    def _judgement(self, judgement: Judgement) -> dict[str, Any]:
        return {
            "time_s": judgement.time_s,
            "now_s": judgement.now_s,
            "plan": judgement.plan.model_dump(mode="json"),
            "guided": judgement.guided,
            "approvals": _sorted(APPROVALS.dump_python(judgement.approvals, mode="json")),
            "verdict": judgement.verdict.model_dump(mode="json", exclude_defaults=True),
            "seen": self._packer.pack(judgement.surroundings),
        }

    def _tick(self, tick: Tick) -> dict[str, Any]:
        data: dict[str, Any] = {"time_s": tick.time_s, "now_s": tick.now_s}
        if tick.withdrawn:
            data["withdrawn"] = True
        if not tick.verdict.accepted:
            data["verdict"] = tick.verdict.model_dump(mode="json", exclude_defaults=True)
        if isinstance(tick.result, Outcome):
            data["outcome"] = tick.result.recorded()
        elif tick.result is not self._said:
            data["directive"] = tick.result.model_dump(mode="json")
            self._said = tick.result
        data["seen"] = self._packer.pack(tick.surroundings)
        return data


def image_of(data: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The JSON form of an image that lies beside a record. Raises `RecordError` where it is missing or changed."""
    path = folder / "images" / f"{data['sha256']}.jpg"
    try:
        jpeg = path.read_bytes()
    except OSError as error:
        raise RecordError(f"the image {path} is missing: keep the folder `images` beside the record") from error
    if hashlib.sha256(jpeg).hexdigest() != data["sha256"]:
        raise RecordError(f"the image {path} was changed after writing")
    return {"width": data["width"], "height": data["height"], "jpeg": base64.b64encode(jpeg).decode()}


def policy_of(data: dict[str, Any], path: Path) -> GuardPolicy:
    """The guard's policy of a record, whole. Raises `RecordError` where a number is missing or means nothing here.

    A default would do for neither: the plans of the record would be judged by bounds that nobody judged them by.
    """
    try:
        policy = GuardPolicy.model_validate(data)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        raise RecordError(f"{path}: the guard's policy cannot be read: {where}: {first['msg']}") from error
    differs = next(_differences(data, policy.model_dump(mode="json")), None)
    if differs is not None:
        raise RecordError(
            f"{path}: the guard's policy is another version's: {differs}; replay it with the version that wrote it"
        )
    return policy


def _differences(recorded: Any, read: Any, where: str = "") -> Iterator[str]:
    """Names of what is in only one of two JSON values, or differs."""
    if not (isinstance(recorded, dict) and isinstance(read, dict)):
        if recorded != read:
            yield where.removeprefix(".")
        return
    for name in sorted(recorded.keys() | read.keys()):
        if name in recorded and name in read:
            yield from _differences(recorded[name], read[name], f"{where}.{name}")
        else:
            yield f"{where}.{name}".removeprefix(".")


def _facts(facts: Facts) -> dict[str, Any]:
    """Everything that decides how a run goes, with versions."""
    return {
        "format": FORMAT,
        "schema": VERSION,
        "written": datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds"),
        "versions": {
            "stucksolver": importlib.metadata.version("stucksolver"),
            "python": platform.python_version(),
            "numpy": np.__version__,
            "platform": platform.platform(),
        },
        "clock": facts.clock,
        "reasoners": dict(facts.reasoners),
        "observe_only": facts.observe_only,
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


def _write_once(path: Path, content: bytes) -> None:
    if path.exists():
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(".part")
    part.write_bytes(content)
    part.replace(path)


def _sorted(data: dict[str, list[str]]) -> dict[str, list[str]]:
    return {key: sorted(value) for key, value in data.items()}
