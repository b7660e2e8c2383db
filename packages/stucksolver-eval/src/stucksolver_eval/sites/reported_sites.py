"""Sites of the suite `reported`: streets with one lane each way, lanes beside others, junctions and level crossings."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from stucksolver_eval.sites.junction_sites import LIT, STRAIGHT, UNLIT, JunctionSites
from stucksolver_eval.sites.lane_requirements import Fits, one_lane, right_of_two
from stucksolver_eval.sites.lane_sites import LaneSites
from stucksolver_eval.sites.lane_walk import Path, Town, oncoming
from stucksolver_eval.sites.stuck_sites import closed_streets, level_crossings, to_pass
from stucksolver_eval.sites.suite_placement import Finder

_LIMIT_KMH = 50.0
"""Highest signed speed limit of a street (km/h); 0 is a street without a sign. Ours."""

SiteKind = Literal["street", "two lanes", "lights", "junction", "rails", "closed street"]


def street(town: Town, stretch: Path) -> bool:
    """True for one lane each way with a broken center line, without a sign above 50 km/h."""
    slow = town.limit_kmh(stretch[0]) <= _LIMIT_KMH
    return slow and one_lane(town, stretch) and all(oncoming(item) for item in stretch[::20])


_STREET: Fits = street
FINDERS: Mapping[SiteKind, Finder] = {
    "street": to_pass(_STREET),
    "two lanes": LaneSites(right_of_two),
    "lights": JunctionSites(STRAIGHT, LIT),
    "junction": JunctionSites(STRAIGHT, UNLIT),
    "rails": level_crossings,
    "closed street": closed_streets,
}
"""Finders by kind of site."""
AT_JUNCTION: frozenset[SiteKind] = frozenset({"lights", "junction"})
"""Sites whose position is the entry of the route's next junction."""
ON_LANE: frozenset[SiteKind] = frozenset({"street", "two lanes"})
"""Sites whose position is drawn along a lane."""
ONLY_IN: Mapping[SiteKind, str] = {"closed street": "grid_town"}
"""The only map with such sites: the others have no way around a closed street."""
