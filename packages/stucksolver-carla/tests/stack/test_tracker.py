"""What is around the ego: what it is, where it is, since when it stands, and what its lamps say."""

from __future__ import annotations

import math

import pytest

carla = pytest.importorskip("carla")

from townstage import CAR  # noqa: E402

from stucksolver.scene import ObjectKind  # noqa: E402
from stucksolver_carla.stack.contact import footprint  # noqa: E402
from stucksolver_carla.stack.ground_truth_tracker import Tracker  # noqa: E402
from stucksolver_carla.stack.object_kinds import attributes_of, kind_of  # noqa: E402

KINDS = {
    "vehicle.tesla.model3": ObjectKind.CAR,
    "vehicle.mercedes.sprinter": ObjectKind.VAN,
    "vehicle.carlamotors.carlacola": ObjectKind.TRUCK,
    "vehicle.mitsubishi.fusorosa": ObjectKind.BUS,
    "vehicle.carlamotors.firetruck": ObjectKind.EMERGENCY,
    "vehicle.ford.ambulance": ObjectKind.EMERGENCY,
    "vehicle.dodge.charger_police": ObjectKind.EMERGENCY,
    "vehicle.kawasaki.ninja": ObjectKind.MOTORCYCLE,
    "vehicle.bh.crossbike": ObjectKind.BICYCLE,
    "vehicle.gazelle.omafiets": ObjectKind.BICYCLE,
    "walker.pedestrian.0001": ObjectKind.PEDESTRIAN,
    "static.prop.constructioncone": ObjectKind.CONE,
    "static.prop.streetbarrier": ObjectKind.BARRIER,
    "static.prop.trafficwarning": ObjectKind.BARRIER,
    "static.prop.trashbag": ObjectKind.DEBRIS,
    "static.prop.dirtdebris01": ObjectKind.DEBRIS,
    "static.prop.plasticbag": ObjectKind.BAG,
    "static.prop.creasedbox01": ObjectKind.LITTER,
    "static.prop.platformgarbage01": ObjectKind.DEBRIS,
    "static.prop.crossinggatepost": ObjectKind.CROSSING_GATE,
    "animal.dog": ObjectKind.ANIMAL,
    "static.prop.trashcan01": ObjectKind.PROP,
    "static.prop.vendingmachine": ObjectKind.PROP,
}
HAZARD = carla.VehicleLightState(carla.VehicleLightState.LeftBlinker | carla.VehicleLightState.RightBlinker)


def look(stage, tracker: Tracker, center) -> dict[str, object]:
    return {o.id: o for o in tracker.update(footprint(center), stage.now_s)}


def test_every_actor_is_what_its_blueprint_says(stage):
    ego = stage.add(CAR, (3, -1, 10.0))
    actors = {name: stage.add(name, (3, -2, 20.0 + 15.0 * k)) for k, name in enumerate(KINDS)}
    stage.ticks(1)
    seen = look(stage, Tracker(stage.world, ego.id, 400.0), ego)
    assert {name: seen[str(actor.id)].kind for name, actor in actors.items()} == KINDS
    assert str(ego.id) not in seen


def test_role_names_say_nothing(stage):
    plain = stage.add(CAR, (3, -2, 30.0))
    acting = stage.add(CAR, (3, -2, 50.0), role="hero")
    stage.ticks(1)
    assert attributes_of(plain) == attributes_of(acting)
    assert "role_name" not in attributes_of(acting)
    assert kind_of(CAR, attributes_of(acting) | {"role_name": "scenario"}) is ObjectKind.CAR


@pytest.mark.parametrize(
    ("type_id", "attributes", "kind"),
    [
        ("vehicle.bh.crossbike", {"number_of_wheels": "2"}, ObjectKind.BICYCLE),
        ("vehicle.yamaha.yzf", {"number_of_wheels": "2"}, ObjectKind.MOTORCYCLE),
        ("vehicle.audi.a2", {"number_of_wheels": "4"}, ObjectKind.CAR),
        ("vehicle.unheard.of", {}, ObjectKind.CAR),
        ("static.prop.unheard_of", {}, ObjectKind.PROP),
    ],
)
def test_kind_of_old_blueprint_uses_name_and_wheels(type_id, attributes, kind):
    """Old blueprints without a base type are classified by name and number of wheels."""
    assert kind_of(type_id, attributes) is kind


def test_objects_are_in_the_right_handed_local_frame(stage):
    ego = stage.add(CAR, (11, -1, 60.0))
    other = stage.add("vehicle.carlamotors.carlacola", (11, 1, 90.0), speed=4.0)
    stage.ticks(20)
    seen = look(stage, Tracker(stage.world, ego.id), ego)[str(other.id)]
    box, transform = other.bounding_box, other.get_transform()
    center = transform.transform(carla.Location(box.location))
    assert (seen.x_m, seen.y_m) == pytest.approx((center.x, -center.y), abs=0.02)
    assert math.remainder(seen.yaw_rad + math.radians(transform.rotation.yaw), math.tau) == pytest.approx(0, abs=1e-3)
    velocity = other.get_velocity()
    assert (seen.vx_mps, seen.vy_mps) == pytest.approx((velocity.x, -velocity.y), abs=1e-3)
    assert seen.vx_mps < -3.5
    sizes = (2 * box.extent.x, 2 * box.extent.y, 2 * box.extent.z)
    assert (seen.length_m, seen.width_m, seen.height_m) == pytest.approx(sizes, abs=1e-3)


def test_standing_time_grows_and_starts_anew_after_a_move(stage):
    ego, other = stage.add(CAR, (3, -1, 10.0)), stage.add(CAR, (3, -1, 40.0))
    stage.ticks(20)
    tracker = Tracker(stage.world, ego.id)

    def standing(seconds: float):
        found = None
        for _ in range(round(seconds / 0.5)):
            stage.ticks(10)
            found = look(stage, tracker, ego)[str(other.id)]
        return found

    first = standing(0.5)
    assert (first.stationary_s, first.moved_s_ago) == (0.0, None)
    assert standing(3.0).stationary_s == pytest.approx(3.0, abs=0.06)
    other.enable_constant_velocity(carla.Vector3D(3.0, 0.0, 0.0))
    assert (standing(0.5).stationary_s, standing(0.5).moved_s_ago) == (0.0, 0.0)
    other.disable_constant_velocity()
    other.apply_control(carla.VehicleControl(brake=1.0, hand_brake=True))
    halted = standing(4.0)
    assert 2.0 < halted.stationary_s < 4.0
    assert halted.stationary_s < halted.moved_s_ago <= halted.stationary_s + 0.51


def test_tracker_reads_hazard_and_brake_lights_not_single_blinker(stage):
    """Hazard and brake lights are read, and a single blinker is no hazard light."""
    ego = stage.add(CAR, (3, -1, 10.0))
    others = [stage.add(CAR, (3, -2, 20.0 + 15.0 * k)) for k in range(4)]
    others[0].set_light_state(HAZARD)
    others[1].set_light_state(carla.VehicleLightState(carla.VehicleLightState.LeftBlinker))
    others[2].set_light_state(carla.VehicleLightState(carla.VehicleLightState.Brake))
    stage.ticks(2)
    tracker = Tracker(stage.world, ego.id)
    unread = look(stage, tracker, ego)
    assert {o.hazard_lights for o in unread.values()} == {None}
    tracker.read_lights(stage.now_s)
    seen = look(stage, tracker, ego)
    assert [seen[str(o.id)].hazard_lights for o in others] == [True, False, False, False]
    assert [seen[str(o.id)].brake_lights for o in others] == [False, False, True, False]


def test_who_is_gone_or_out_of_range_is_forgotten(stage):
    ego, near, far = (stage.add(CAR, (3, -1, s)) for s in (10.0, 40.0, 200.0))
    stage.ticks(1)
    tracker = Tracker(stage.world, ego.id, range_m=100.0)
    assert set(look(stage, tracker, ego)) == {str(near.id)}
    near.destroy()
    stage.actors.remove(near)
    stage.ticks(1)
    assert look(stage, tracker, ego) == {}
    assert str(far.id) in look(stage, Tracker(stage.world, ego.id, range_m=300.0), ego)


def test_tracker_reads_emergency_lights_and_their_duration(stage):
    """The roof lights of an emergency vehicle are read, and so is how long it has been visible."""
    ego, van = stage.add(CAR, (3, -2, 30.0)), stage.add("vehicle.ford.ambulance", (3, -2, 60.0))
    stage.ticks(1)
    tracker = Tracker(stage.world, ego.id)
    look(stage, tracker, ego)
    van.set_light_state(carla.VehicleLightState(carla.VehicleLightState.Special1))
    stage.ticks(30)
    tracker.read_lights(stage.now_s)
    seen = look(stage, tracker, ego)[str(van.id)]
    assert (seen.kind, seen.emergency_lights, seen.hazard_lights) == (ObjectKind.EMERGENCY, True, False)
    assert seen.seen_for_s == pytest.approx(1.5, abs=0.01)
    assert seen.kind_confidence == 1.0
