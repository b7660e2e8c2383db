"""One route's result in the leaderboard's checkpoint format, which Bench2Drive's tools read."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from urllib.parse import quote

from pydantic import BaseModel, ConfigDict, Field

from stucksolver_eval.criteria.criterion import Infraction
from stucksolver_eval.criteria.penalties import KINDS, score_route
from stucksolver_eval.criteria.route_timeout import TICK_RUNTIME, TICKS

COMPLETED, PERFECT = "Completed", "Perfect"
TICK_S = 0.05
"""Simulated time of a tick, in the benchmark and here."""


class Scores(BaseModel):
    """Scores of one route under the leaderboard's names: 0 to 100, the penalty 0 to 1."""

    score_route: float
    score_penalty: float
    score_composed: float


class Meta(BaseModel):
    """Meters, and seconds of game and wall time."""

    route_length: float
    duration_game: float
    duration_system: float


class RouteRecord(BaseModel):
    """The leaderboard's record of one route, with its field names. Further fields of other files stay."""

    model_config = ConfigDict(extra="allow")

    index: int = 0
    route_id: str
    scenario_name: str
    weather_id: int | None = None
    save_name: str
    status: str
    num_infractions: int
    infractions: dict[str, list[str]]
    scores: Scores
    meta: Meta
    town_name: str = ""

    @property
    def id(self) -> str:
        """The route's id in its XML."""
        return self.route_id.split("_")[1]

    @property
    def success(self) -> bool:
        """True for a success by Bench2Drive's rule: completed, without infractions except those of minimum speed."""
        clean = not any(texts for kind, texts in self.infractions.items() if kind != "min_speed_infractions")
        return self.status in (COMPLETED, PERFECT) and clean


class _Checkpoint(BaseModel):
    global_record: dict[str, object] = Field(default_factory=dict)
    progress: list[int] = [1, 1]
    records: list[RouteRecord]


class CheckpointFile(BaseModel):
    """A complete checkpoint file of the leaderboard. Files from this package have one route each."""

    checkpoint: _Checkpoint = Field(alias="_checkpoint")
    entry_status: str = "Finished"
    eligible: bool = True
    sensors: list[str] = []
    values: list[str] = []
    labels: list[str] = []


def checkpoint_text(record: RouteRecord) -> str:
    """Return the text of a checkpoint file with one record."""
    return CheckpointFile(_checkpoint=_Checkpoint(records=[record])).model_dump_json(by_alias=True, indent=1) + "\n"


def make_record(
    *,
    route_id: str,
    scenario: str,
    town: str,
    length_m: float,
    game_s: float,
    wall_s: float,
    completion_pct: float,
    failure: str | None,
    infractions: Iterable[Infraction],
) -> RouteRecord:
    """Return the record of a driven route. `failure` is None if the destination was reached."""
    noted = list(infractions)
    scores = score_route(completion_pct, noted)
    texts = {kind: [i.text for i in noted if i.kind == kind] for kind in KINDS}
    count = sum(len(entries) for entries in texts.values())
    return RouteRecord(
        route_id=f"RouteScenario_{route_id}_rep0",
        scenario_name=scenario,
        save_name=save_name(route_id, town, scenario),
        status=_status(completion_pct, failure, count),
        num_infractions=count,
        infractions=texts,
        scores=Scores(score_route=scores.route, score_penalty=scores.penalty, score_composed=scores.composed),
        meta=Meta(route_length=round(length_m, 3), duration_game=round(game_s, 3), duration_system=round(wall_s, 3)),
        town_name=town,
    )


def status_text(status: str) -> str:
    """Return the leaderboard's status for people, with an explanation if it needs one."""
    return status.replace(TICK_RUNTIME, f"{TICK_RUNTIME} (not done after {TICKS} ticks, {TICKS * TICK_S:.0f} s)")


def save_name(route_id: str, town: str, scenario: str) -> str:
    """Return the name of a route's files. The town may be a map file.

    The names in it come from a route file. None of them leads to another folder, because path separators are encoded.
    Characters outside ASCII are encoded as well, because a system without UTF-8 cannot write them in a file's name.
    """
    name = f"RouteScenario_{route_id}_rep0_{Path(town).stem}_{scenario}"
    return re.sub(r"[/\\%]|[^ -~]", lambda found: quote(found[0], safe="", errors="surrogatepass"), name)


def _status(completion_pct: float, failure: str | None, infractions: int) -> str:
    if completion_pct >= 100.0:
        return COMPLETED if infractions else PERFECT
    return f"Failed - {failure}" if failure else "Failed"
