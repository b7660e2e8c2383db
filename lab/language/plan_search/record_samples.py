"""Converts records of interventions to samples: the scenes of a user's own drives, with the answers of any reasoner.

Such a sample contains the answer of a reasoner and not the continuation of the drive, so only the answer is learned
from it.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from lab.language.plan_search.decision_samples import SUFFIX, DecisionSample, write_moments
from stucksolver.plan import Decision
from stucksolver.record import RecordError
from stucksolver.record.hash_chain import read_chain
from stucksolver.scene import Scene
from stucksolver_language.student.scene_codec import write_scene

SUITE, UNKNOWN = "records", "unknown"


def collect_records(folder: Path, out: Path) -> int:
    """Write the samples of all records below a folder, one file for each; return the number of answers.

    Args:
        folder: Folder with records, at any depth.
        out: Folder for the samples.

    Raises:
        RecordError: There is no record, or one was changed.
        OutputError: A file cannot be written.
    """
    paths = sorted(path for path in folder.rglob("*.jsonl") if _is_record(path))
    if not paths:
        raise RecordError(f"no record of an intervention: {folder}. Drive with `evaluate --record` first")
    count = 0
    for path in paths:
        name = hashlib.sha256(path.relative_to(folder).as_posix().encode()).hexdigest()[:12]
        moments = list(moments_in(path, name))
        count += len(moments)
        if moments:
            write_moments(out / "moments" / SUITE / f"{name}{SUFFIX}", moments)
    return count


def _is_record(path: Path) -> bool:
    with path.open(encoding="utf-8", errors="replace") as file:
        return '"hash"' in file.readline()


def moments_in(path: Path, name: str) -> Iterator[DecisionSample]:
    """Yield a sample for each answered query of a record.

    Args:
        path: The record.
        name: Its name in the samples.

    Raises:
        RecordError: The record was changed.
    """
    scene: Scene | None = None
    for _, line in read_chain(path):
        asked = line.get("asked")
        answer: dict[str, Any] = (line.get("in") or {}).get("answer") or {}
        if scene is not None and isinstance(answer.get("decision"), dict):
            yield DecisionSample(
                suite=SUITE,
                route_id=name,
                seed=0,
                scenario=UNKNOWN,
                town=UNKNOWN,
                standstill=0,
                at_s=round(scene.time_s, 2),
                scene=write_scene(scene),
                gone_after_s=None,
                watched_s=0.0,
                answer=Decision.model_validate(answer["decision"]),
            )
            scene = None
        if isinstance(asked, dict) and asked.get("scene") is not None:
            scene = Scene.model_validate({**asked["scene"], "image": None})
