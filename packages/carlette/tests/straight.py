"""A straight road as OpenDRIVE text, and worlds on it: the smallest place to drive."""

from __future__ import annotations

from carlette.geometry import Pose, Rotation, Vector
from carlette.opendrive.map_file import MapFile
from carlette.opendrive.road_network import RoadNetwork
from carlette.physics.vehicle_dynamics import BRAKE, HAND_BRAKE, REVERSE, STEER, THROTTLE
from carlette.world.spawn import spawn
from carlette.world.world import World

CAR = "vehicle.tesla.model3"
LENGTH_M = 2000.0
LANE_Y_M = 1.75
"""Center of the lane that leads along +x (CARLA's y points right)."""


def straight_road(slope: float = 0.0, signals: str = "", lane: str = "driving") -> str:
    """A road along +x from the origin: a lane each way and sidewalks; it rises by `slope` meters per meter."""

    def lane_xml(number: int, kind: str) -> str:
        inside = '<width sOffset="0" a="3.5" b="0" c="0" d="0"/><roadMark sOffset="0" type="broken" width="0.12"/>'
        return f'<lane id="{number}" type="{kind}" level="false">{inside}</lane>'

    return f"""<?xml version="1.0"?><OpenDRIVE><header revMajor="1" revMinor="4" name="straight">
    <geoReference><![CDATA[+proj=tmerc +lat_0=0 +lon_0=0 +k=1]]></geoReference></header>
    <road name="" length="{LENGTH_M}" id="7" junction="-1"><type s="0" type="town"><speed max="50" unit="km/h"/></type>
    <planView><geometry s="0" x="0" y="0" hdg="0" length="{LENGTH_M}"><line/></geometry></planView>
    <elevationProfile><elevation s="0" a="0" b="{slope}" c="0" d="0"/></elevationProfile>
    <lanes><laneSection s="0"><left>{lane_xml(2, "sidewalk")}{lane_xml(1, lane)}</left>
    <center><lane id="0" type="none" level="false"/></center>
    <right>{lane_xml(-1, lane)}{lane_xml(-2, "sidewalk")}</right></laneSection></lanes>
    <signals>{signals}</signals></road></OpenDRIVE>"""


def straight_world(slope: float = 0.0, seed: int = 0) -> World:
    """A world on the straight road."""
    return World(RoadNetwork(MapFile("straight", straight_road(slope))), seed)


def on_lane(x: float, z: float = 0.0, yaw: float = 0.0, y: float = LANE_Y_M) -> Pose:
    """A pose on the lane along +x."""
    return Pose(Vector(x, y, z), Rotation(yaw=yaw))


def add(world: World, type_id: str = CAR, x: float = 50.0, **place: float):
    """Spawns an actor on the lane; a vehicle has driven before, and is in gear."""
    actor = spawn(world, type_id, {}, on_lane(x, **place))
    world.fleet.engage_s[:] = 0.0
    return actor


def drive(world: World, car, throttle=0.0, steer=0.0, brake=0.0, hand_brake=0.0, reverse=0.0) -> None:
    """Sets a vehicle's control."""
    control = world.fleet.control[car.index]
    control[[THROTTLE, STEER, BRAKE, HAND_BRAKE, REVERSE]] = (throttle, steer, brake, hand_brake, reverse)


def speed_of(world: World, actor) -> float:
    """Planar speed in m/s."""
    x, y, _ = world.bodies.velocity[actor.row]
    return float((x * x + y * y) ** 0.5)


def launch(world: World, car, mps: float) -> None:
    """Gives an actor a speed along its heading of zero yaw."""
    world.bodies.velocity[car.row, 0] = mps


def ticks(world: World, count: int):
    """Ticks and yields the world after each."""
    for _ in range(count):
        world.tick()
        yield world
