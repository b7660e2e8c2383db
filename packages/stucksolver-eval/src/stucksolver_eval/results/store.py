"""The folder of an evaluation: the location of its files, and the finished routes.

```
evaluation.json                      settings of the evaluation
routes.xml                           the routes, unchanged
seed-1/records/NAME.json             one checkpoint of the leaderboard for each route, and nothing else
seed-1/metrics/NAME/metric_info.json
seed-1/replays/NAME.json.gz
seed-1/interventions/NAME/           hash-chained records, if requested
seed-1/events/NAME.jsonl             all events of the solver, if requested
seed-1/outcomes/NAME.json            written last: a route with it is done
```
"""

from __future__ import annotations

import gzip
import shutil
from pathlib import Path

from pydantic import ValidationError

from stucksolver.atomic_files import cannot_write, write_bytes, write_text
from stucksolver.solver import Event
from stucksolver_eval.results.checkpoint import CheckpointFile, RouteRecord, checkpoint_text, save_name
from stucksolver_eval.results.manifest import EvaluationManifest
from stucksolver_eval.results.outcome import RouteOutcome
from stucksolver_eval.results.route_result import RouteResult
from stucksolver_eval.results.run_log import RunLog
from stucksolver_eval.routes import Route, read_routes, write_routes

OUTCOMES = "outcomes"
MANIFEST, ROUTES = "evaluation.json", "routes.xml"
DONE = ("driven", "unsupported")
"""States of a finished route. A route that crashed, or could not be driven as specified, is repeated on resume."""

_FILES = {
    "metrics": "{}",
    "replays": "{}.json.gz",
    "interventions": "{}",
    "events": "{}.jsonl",
    "records": "{}.json",
    OUTCOMES: "{}.json",
}


class StoreError(RuntimeError):
    """A folder cannot be used as a result folder. The message names the folder, the cause and the remedy."""


class ResultStore:
    """Reads and writes one such folder. Raises `StoreError` and `OutputError`."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    # ---- begin and resume

    def begin(self, manifest: EvaluationManifest, routes: tuple[Route, ...], resume: bool) -> None:
        """Start or resume an evaluation in the folder. It never overwrites the results of another one."""
        path = self.folder / MANIFEST
        if path.exists():
            found = self.manifest()
            if not resume:
                raise StoreError(
                    f"folder has results of {found.title}: {self.folder}. "
                    "Add --resume to continue, or choose another --out"
                )
            differs = manifest.differs_from(found)
            if differs:
                raise StoreError(f"cannot resume folder: {self.folder}: {differs}. Choose another --out")
            return
        if self.folder.exists() and any(self.folder.iterdir()):
            raise StoreError(f"not an evaluation and not empty: {self.folder}. Choose another --out")
        write_routes(self.folder / ROUTES, routes)
        write_text(path, manifest.model_dump_json(indent=1) + "\n")

    def manifest(self) -> EvaluationManifest:
        """Return the settings of the evaluation. Raises `StoreError` if the folder contains no result."""
        path = self.folder / MANIFEST
        try:
            return EvaluationManifest.model_validate_json(path.read_text(encoding="utf-8"))
        except OSError as error:
            raise StoreError(
                f"not a result folder of `stucksolver evaluate`: {self.folder} has no {MANIFEST}. Choose another folder"
            ) from error
        except ValidationError as error:
            raise StoreError(
                f"file of another version: {path}: {error.errors()[0]['msg']}. Use that version, or run again"
            ) from error

    def routes(self) -> tuple[Route, ...]:
        """Return the routes of the run."""
        return read_routes(self.folder / ROUTES)

    def seeds(self) -> tuple[int, ...]:
        """Return the seeds of the run."""
        return self.manifest().seeds

    def is_done(self, route: Route, seed: int) -> bool:
        """Return True if a route need not be driven again."""
        found = self.outcome(route, seed)
        return found is not None and found.state in DONE

    # ---- one route

    def write_driven(self, route: Route, seed: int, driven: RouteResult) -> None:
        """Write all files of a route, the outcome last."""
        driven.metric_info.write(self._path("metrics", route, seed))
        if driven.replay is not None:
            packed = gzip.compress(driven.replay.model_dump_json().encode(), 6, mtime=0)
            write_bytes(self.replay(route, seed), packed)
        if driven.events:
            lines = [event.model_dump_json() for event in driven.events]
            write_text(self._path("events", route, seed), "\n".join(lines) + "\n")
        write_text(self._path("records", route, seed), checkpoint_text(driven.record))
        self.write_outcome(route, driven.outcome)

    def write_outcome(self, route: Route, outcome: RouteOutcome) -> None:
        """Write the outcome of a route atomically."""
        write_text(self._path(OUTCOMES, route, outcome.seed), outcome.model_dump_json() + "\n")

    def take(self, other: ResultStore, route: Route, outcome: RouteOutcome) -> None:
        """Copy all files of a route that is done in another store. Writes its outcome last, unchanged."""
        for part in _FILES:
            if part == OUTCOMES:
                continue
            theirs, ours = (store._path(part, route, outcome.seed) for store in (other, self))
            try:
                if theirs.is_dir():
                    shutil.copytree(theirs, ours, dirs_exist_ok=True)
                elif theirs.exists():
                    write_bytes(ours, theirs.read_bytes())
            except OSError as error:
                raise cannot_write(ours, error) from error
        self.write_outcome(route, outcome)

    def outcome(self, route: Route, seed: int) -> RouteOutcome | None:
        """Return the outcome of a route; None if it was not driven."""
        path = self._path(OUTCOMES, route, seed)
        return RouteOutcome.model_validate_json(_read(path)) if path.exists() else None

    def record(self, route: Route, seed: int) -> RouteRecord | None:
        """Return the leaderboard's record of a route; None if there is none."""
        path = self._path("records", route, seed)
        if not path.exists():
            return None
        return CheckpointFile.model_validate_json(_read(path)).checkpoint.records[0]

    def metric_info(self, route: Route, seed: int) -> Path:
        """Return the path of a route's `metric_info.json` for Bench2Drive."""
        return self._path("metrics", route, seed) / "metric_info.json"

    def replay(self, route: Route, seed: int) -> Path:
        """Return the path of a route's replay."""
        return self._path("replays", route, seed)

    def run_log(self, route: Route, seed: int) -> RunLog:
        """Return the replay of a route."""
        return RunLog.model_validate_json(gzip.decompress(self.replay(route, seed).read_bytes()))

    def events(self, route: Route, seed: int) -> tuple[Event, ...]:
        """Return the solver's events, with times since the start of the route (s)."""
        path = self._path("events", route, seed)
        lines = _read(path).splitlines() if path.exists() else []
        return tuple(Event.model_validate_json(line) for line in lines)

    def interventions(self, route: Route, seed: int) -> Path:
        """Return the folder with the records of a route's interventions."""
        return self._path("interventions", route, seed)

    def _path(self, part: str, route: Route, seed: int) -> Path:
        return self.folder / f"seed-{seed}" / part / _FILES[part].format(_name(route))


def _name(route: Route) -> str:
    return save_name(route.id, route.town, route.scenarios[0].type if route.scenarios else "None")


def _read(path: Path) -> str:
    return path.read_text(encoding="utf-8")
