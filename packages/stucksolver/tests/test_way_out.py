"""An ego that has stopped where no vehicle should stop leaves, forward or backward."""

from __future__ import annotations

import pytest

from stucksolver.scene import Zone, ZoneKind
from worlds import World, red_light, searched, straight_road, thing

FRONT_M = 4.9 / 2
RAILS = straight_road(zones=(Zone(kind=ZoneKind.LEVEL_CROSSING, start_m=45.0, end_m=54.0),))


def decide(road, *objects, stopped_s=3.0, **world):
    world = World(road, list(objects), **world)
    scene = world.scene()
    return searched(world, scene.model_copy(update={"ego": scene.ego.model_copy(update={"stopped_for_s": stopped_s})}))


def names(decision):
    return [] if decision.plan is None else [behavior.name for behavior in decision.plan.behaviors]


def test_scene_names_zone_under_the_ego():
    """Rails are named before a junction that the body touches as well."""
    both = (
        Zone(kind=ZoneKind.JUNCTION, start_m=40.0, end_m=50.0),
        Zone(kind=ZoneKind.LEVEL_CROSSING, start_m=51, end_m=54),
    )
    assert World(straight_road(zones=both)).scene().ego.zone is ZoneKind.LEVEL_CROSSING
    assert World(straight_road()).scene().ego.zone is None


@pytest.mark.parametrize(
    "objects",
    [(thing("lead", 58.0),), (thing("lead", 58.0, stationary_s=3.0, moved_s_ago=3.0),)],
    ids=["parked car", "queue"],
)
def test_way_out_of_rails_behind_a_vehicle_is_backward(objects):
    """No wait is a reason to stay on rails, not even a queue."""
    assert names(decide(RAILS, *objects)) == ["back_up"]


def test_way_out_of_rails_with_free_road_is_forward():
    assert names(decide(RAILS)) == ["keep_lane"]


def test_way_out_of_rails_between_two_vehicles_is_none():
    behind = thing("behind", 50.0 - FRONT_M - 1.0 - 2.3)
    assert decide(RAILS, thing("lead", 58.0), behind).plan is None


@pytest.mark.parametrize("kind", [ZoneKind.JUNCTION, ZoneKind.CROSSWALK, ZoneKind.KEEP_CLEAR])
def test_way_out_of_other_zones_is_taken_if_nothing_leads_on(kind):
    road = straight_road(oncoming=None, zones=(Zone(kind=kind, start_m=45.0, end_m=54.0),))
    assert names(decide(road, thing("lead", 58.0), stopped_s=20.0)) == ["back_up"]
    waiting = thing("lead", 58.0, stationary_s=3.0, moved_s_ago=3.0)
    assert decide(road, waiting, stopped_s=20.0).plan is None


def test_way_out_is_not_taken_where_one_may_stand():
    assert decide(straight_road(oncoming=None), thing("lead", 58.0), stopped_s=20.0).plan is None
    assert decide(straight_road(), controls=(red_light(3.0),)).plan is None
