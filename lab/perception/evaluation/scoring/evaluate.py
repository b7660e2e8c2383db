"""Scores perception on recordings, each part separately, and writes a JSON file and a page."""

from __future__ import annotations

import json
import platform
import resource
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TextIO

from lab.perception.evaluation.metrics.latency import StageLatency, latency
from lab.perception.evaluation.scoring.camera import score_attributes, score_lights
from lab.perception.evaluation.scoring.detection import score_lidar
from lab.perception.evaluation.scoring.far_detection import score_far
from lab.perception.evaluation.scoring.localization import score_localization
from lab.perception.evaluation.scoring.noise import score_noise
from lab.perception.evaluation.scoring.scoring_part import (
    MissingGroundTruthError,
    ScoringInput,
    ScoringResult,
    figure,
    plain,
    table,
)
from lab.perception.evaluation.scoring.tracking import score_tracking
from stucksolver.atomic_files import write_text
from stucksolver_perception.network_files import NetworkFileError
from stucksolver_perception.recording import recordings

JSON, PAGE = "perception.json", "perception.md"
PARTS: Mapping[str, tuple[str, Callable[[ScoringInput], ScoringResult]]] = {
    "lidar": ("Detection by LiDAR", score_lidar),
    "noise": ("Noise of the LiDAR detector", score_noise),
    "tracking": ("Tracking", score_tracking),
    "localisation": ("Localisation", score_localization),
    "lights": ("Traffic lights", score_lights),
    "attributes": ("Kinds, lamps and doors", score_attributes),
    "far": ("Vehicles far ahead", score_far),
}


@dataclass(frozen=True)
class Scored:
    """The parts that were scored, those that were left out with the reason, and the page."""

    done: tuple[str, ...]
    left_out: Mapping[str, str]
    page: Path
    scores: Path
    """JSON file with all metrics."""


def evaluate_perception(
    folder: Path, out: Path, only: Sequence[str], source: ScoringInput | None = None, err: TextIO = sys.stderr
) -> Scored:
    """Score the parts named in `only`, or all if it is empty, on the recordings in `folder`; write the scores to `out`.

    A part is left out, with the reason, if its weights or packages are missing, or if the recordings lack its data.

    Raises:
        RecordingError: The recordings cannot be read.
        OutputError: The scores cannot be written.
    """
    base = source or ScoringInput(())
    scoring_input = replace(base, recordings=recordings(folder), say=lambda line: print(line, file=err, flush=True))
    done: dict[str, ScoringResult] = {}
    left_out: dict[str, str] = {}
    for name in only or PARTS:
        found = _scored(PARTS[name][1], scoring_input)
        if isinstance(found, ScoringResult):
            done[name] = found
        else:
            left_out[name] = found
    stages = _stages(done.values())
    memory_mib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    data = {
        "recordings": [recording.folder.name for recording in scoring_input.recordings],
        "parts": {name: plain(part.data) for name, part in done.items()},
        "left_out": left_out,
        "latency_ms": plain(stages),
        "memory_mib": memory_mib,
        "threads": scoring_input.threads,
        "machine": f"{platform.machine()}, Python {platform.python_version()}",
    }
    write_text(out / JSON, json.dumps(data, indent=1) + "\n")
    write_text(
        out / PAGE, _page(len(scoring_input.recordings), done, left_out, stages, memory_mib, scoring_input.threads)
    )
    return Scored(tuple(done), left_out, out / PAGE, out / JSON)


def _scored(part: Callable[[ScoringInput], ScoringResult], source: ScoringInput) -> ScoringResult | str:
    """Return the scores of a part, or the reason why there are none."""
    try:
        return part(source)
    except (NetworkFileError, MissingGroundTruthError, ModuleNotFoundError) as error:
        # A part without its data or packages is left out; the page shows the reason.
        return str(error)


def _stages(parts: Any) -> dict[str, StageLatency]:
    times: dict[str, list[float]] = {}
    for part in parts:
        for stage, taken in part.stages_ms.items():
            times.setdefault(stage, []).extend(taken)
    return {stage: found for stage, taken in times.items() if (found := latency(taken)) is not None}


def _page(
    count: int,
    done: Mapping[str, ScoringResult],
    left_out: Mapping[str, str],
    stages: Mapping[str, StageLatency],
    memory_mib: float,
    threads: int,
) -> str:
    pieces = [f"# Perception on {count} recordings\n"]
    pieces += [f"## {PARTS[name][0]}\n\n{part.page}" for name, part in done.items()]
    rows = [
        (name, str(stage.runs), figure(stage.median_ms, 1), figure(stage.p95_ms, 1), figure(stage.worst_ms, 1))
        for name, stage in stages.items()
    ]
    pieces.append(
        f"## Time and memory\n\n{threads} threads per network; the process used at most {memory_mib:.0f} MiB, "
        f"including the recordings.\n\n{table(('stage', 'runs', 'median ms', '95 % ms', 'worst ms'), rows)}\n"
    )
    if left_out:
        lines = "\n".join(f"* {name}: {reason}" for name, reason in left_out.items())
        pieces.append(f"## Left out\n\n{lines}\n")
    return "\n".join(pieces)
