"""Reads the decisions of a record with the camera image of each query, without replaying it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stucksolver.plan import Decision
from stucksolver.plan.mirror import mirrored_decision
from stucksolver.record.hash_chain import RecordError, read_chain
from stucksolver.record.record_file import image_of
from stucksolver.scene import CameraImage
from stucksolver.scene.wording import in_one_line
from stucksolver.solver import Event, EventKind
from stucksolver.solver.side_texts import swapped_event


@dataclass(frozen=True)
class RecordedDecision:
    """Decision in a record. `event` reported it, with trigger and verdict; its time is on the stack's clock (s)."""

    event: Event
    decision: Decision
    image: CameraImage | None
    """Image of the front camera in the scene of the query."""


def read_decisions(path: Path) -> Iterator[RecordedDecision]:
    """Yield the decisions in the order of the record, with the sides as people saw them.

    Raises:
        RecordError: The record was changed or cannot be read, or an image is missing.
    """
    image: CameraImage | None = None
    mirrored = False
    for number, line in read_chain(path):
        try:
            if isinstance(line.get("asked"), dict):
                image = _image(line["asked"].get("scene"), path.parent)
                mirrored = bool((line["asked"].get("scene") or {}).get("mirrored"))
            decided = _decided(line)
        except (AttributeError, LookupError, TypeError, ValueError, RecursionError) as error:
            raise RecordError(f"{path}, line {number}: this line cannot be read: {in_one_line(error)}") from error
        for event, decision in decided:
            if mirrored:
                event, decision = swapped_event(event), mirrored_decision(decision)
            yield RecordedDecision(event, decision, image)


def _decided(line: dict[str, Any]) -> list[tuple[Event, Decision]]:
    """Return the decisions of a line, each with its event."""
    # A decision that arrived with this line is stored once, as its answer.
    answer = (line.get("in") or {}).get("answer") or {}
    recorded = [item["event"] for item in line.get("told", ()) if "event" in item]
    events = [Event.model_validate({"decision": answer.get("decision"), **event}) for event in recorded]
    return [(e, e.decision) for e in events if e.kind is EventKind.DECIDED and e.decision is not None]


def _image(scene: dict[str, Any] | None, folder: Path) -> CameraImage | None:
    image = None if scene is None else scene.get("image")
    return None if image is None else CameraImage.model_validate(image_of(image, folder))
