"""The actors at one time as parts to draw: meshes and poses, with shadows and lights."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from carlette.blueprints import load_catalog
from carlette.camera.environment.repeater_lights import repeaters_of
from carlette.camera.models import cycles, doors_and_stop_arm, lamps, traffic_lights
from carlette.camera.models.animals import animal_mesh
from carlette.camera.models.mesh import EMPTY, Builder, Color, Mesh, Point
from carlette.camera.models.people import ORANGE, VEST, Clothes, clothes_of, person, stride
from carlette.camera.models.props import prop_mesh
from carlette.camera.models.vehicles import vehicle_mesh
from carlette.camera.rendering import tags
from carlette.camera.rendering.lighting import Light
from carlette.camera.rendering.renderer import RenderPart
from carlette.camera.rendering.view import matrix_of
from carlette.geometry import Box, Floats, Pose, Rotation, Vector
from carlette.world.actor import Actor, ActorKind
from carlette.world.skeleton import bones
from carlette.world.world import World

SWING_STEPS, GAIT_STEPS = 12, 12
"""Numbers of cached positions of a door and of a walking leg. Ours."""
LONGEST_SHADOW = 3.0
"""Longest shadow, in heights of the object. Ours."""
DEFAULT_COLOR: Color = (150, 152, 156)


def cast(world: World, light: Light) -> list[RenderPart]:
    """Return all parts of all actors, in the order of their ids."""
    parts: list[RenderPart] = []
    doors = _open_doors(world)
    for actor in world.actors.values():
        pose = world.pose(actor)
        if actor.kind is ActorKind.VEHICLE:
            parts.extend(_vehicle(world, actor, pose, light, doors.get(actor.row, ())))
        elif actor.kind is ActorKind.WALKER:
            parts.extend(_walker(world, actor, pose, light))
        elif actor.kind is ActorKind.PROP:
            parts.extend(_prop(actor, pose, light))
        elif actor.kind is ActorKind.LIGHT:
            parts.extend(_traffic_light(world, actor, pose))
    return parts


def contains(world: World, actor: Actor, point: Vector, margin_m: float = 0.05) -> bool:
    """True if a point is within an actor's box."""
    pose = world.pose(actor)
    matrix = matrix_of(pose)
    inside = matrix[:3, :3].T @ (np.array(point) - matrix[:3, 3]) - np.array(actor.box.center)
    return bool((np.abs(inside) <= np.array(actor.box.extent) + margin_m).all())


def _open_doors(world: World) -> dict[int, list[tuple[int, float]]]:
    """Return doors that are not closed, by the row of their vehicle: number and swing (0 to 1)."""
    found: dict[int, list[tuple[int, float]]] = {}
    for row, door, swing in zip(
        world.doors.row.tolist(), world.doors.door.tolist(), world.doors.swing.tolist(), strict=True
    ):
        found.setdefault(row, []).append((door, round(swing * SWING_STEPS) / SWING_STEPS))
    return found


def _vehicle(
    world: World, actor: Actor, pose: Pose, light: Light, doors: list[tuple[int, float]] | tuple[()]
) -> Iterator[RenderPart]:
    model = load_catalog().vehicles[actor.type_id]
    color, tag = _color(actor), actor.tags[0]
    matrix = matrix_of(pose)
    radius = _radius(actor.box) + 0.5

    def render_part(mesh: Mesh, *, is_shade: bool = False, adds: bool = False) -> RenderPart:
        return RenderPart(mesh, matrix, actor.id, tag, radius, is_shade, adds)

    lit, phase = lamps.lit_lamps(int(world.fleet.light_state[actor.index]), world.elapsed_s)
    lamp, halo = EMPTY, EMPTY
    if model.is_two_wheeler:
        way, motor = float(matrix[:2, 0] @ matrix[:2, 3]), model.base_type == "motorcycle"
        turn = round((way / 2.2) % 1.0 * GAIT_STEPS) / GAIT_STEPS
        yield render_part(_cycle(actor.type_id, actor.box, model.wheelbase_m, color, turn, motor))
        if motor:
            lamp, halo = _cycle_lamps(actor.type_id, actor.box, model.wheelbase_m, lit)
    else:
        yield render_part(_body(actor.type_id, actor.box, model.wheelbase_m, color))
        lamp, halo = _lamps(actor.type_id, actor.box, lit, phase)
    if len(lamp):
        yield render_part(lamp)
    for door, swing in doors:
        yield render_part(_door(actor.type_id, actor.box, door, swing, color))
    yield from _shadows(actor, pose, light)
    if len(halo):
        yield render_part(halo, is_shade=True, adds=True)
    if light.is_dark and len(lamp):
        beam = _beam(actor.type_id, actor.box, lit & int(lamps.BEAMS | lamps.VehicleLights.BRAKE))
        if len(beam):
            yield RenderPart(beam, matrix, actor.id, tag, 45.0, True, True)


def _walker(world: World, actor: Actor, pose: Pose, light: Light) -> Iterator[RenderPart]:
    speed = float(np.hypot(*world.bodies.velocity[actor.row, :2]))
    height = 2 * actor.box.extent.z
    matrix = matrix_of(pose)
    way = float(matrix[:2, 0] @ matrix[:2, 3])
    phase = round((way / max(0.85 * height, 0.3)) % 1.0 * GAIT_STEPS) / GAIT_STEPS if speed > 0.1 else 0.0
    share = min(1.0, round(speed / 1.5 * 4) / 4) if speed > 0.1 else 0.0
    if actor.type_id.startswith("animal."):
        mesh = _animal(actor.type_id, actor.box, phase, share)
    else:
        joints = _joints(actor)
        sign = actor.attributes["gesture"][1] if "gesture" in actor.attributes else ""
        mesh = _person(actor.type_id, actor.box.extent.z, joints, phase, share, sign)
    if actor.index >= 0 and world.walkers.dead[actor.index]:
        lying = matrix_of(Pose(Vector(z=0.16 - actor.box.extent.z), Rotation(pitch=-90.0)))
        matrix = matrix @ lying
    yield RenderPart(mesh, matrix, actor.id, actor.tags[0] if actor.tags else tags.PEDESTRIAN, height)
    yield from _shadows(actor, pose, light)


def _joints(actor: Actor) -> tuple[tuple[str, float, float, float], ...]:
    """Return joints in the actor's frame, without the rig's prefix; hashable."""
    found = bones(Pose(), actor.box.extent.z, actor.posed, actor.blend)
    joints = []
    for item in found:
        x, y, z = item.component.location
        joints.append((item.name.removeprefix("crl_"), round(x, 3), round(y, 3), round(z, 3)))
    return tuple(joints)


def _prop(actor: Actor, pose: Pose, light: Light) -> Iterator[RenderPart]:
    tag = actor.tags[0] if actor.tags else tags.STATIC
    yield RenderPart(_prop_mesh(actor.type_id, actor.box), matrix_of(pose), actor.id, tag, _radius(actor.box))
    yield from _shadows(actor, pose, light)


def _traffic_light(world: World, actor: Actor, pose: Pose) -> Iterator[RenderPart]:
    color = int(world.signals.lights.color[actor.index])
    arm, matrix = round(actor.box.center.x, 1), matrix_of(pose)
    yield from _heads(actor, matrix, _post(arm), _lights(arm, color))
    repeater = repeaters_of(world.roads)[actor.index]
    if repeater is not None:
        there = matrix.copy()
        there[:3, 3] = matrix[:3, :3] @ np.array(repeater) + matrix[:3, 3]
        yield from _heads(actor, there, traffic_lights.repeater_mesh(), _repeater_lights(color))


def _heads(actor: Actor, matrix: Floats, post: Mesh, lights: tuple[Mesh, Mesh]) -> Iterator[RenderPart]:
    lamp, halo = lights
    yield RenderPart(post, matrix, actor.id, tags.TRAFFIC_LIGHT, 12.0)
    yield RenderPart(lamp, matrix, actor.id, tags.TRAFFIC_LIGHT, 12.0)
    if len(halo):
        yield RenderPart(halo, matrix, actor.id, tags.TRAFFIC_LIGHT, 12.0, True, True)


def _shadows(actor: Actor, pose: Pose, light: Light) -> Iterator[RenderPart]:
    """Yield the shadow where the object touches the ground, and the one that it casts in the sun."""
    low = max(actor.box.center.z - actor.box.extent.z, -actor.box.extent.z)
    heading = round(pose.rotation.yaw / 5.0) * 5.0
    sun = light.sun if sum(light.direct) > 0.25 else None
    mesh = _shadow(actor.box, low, heading if sun else 0.0, sun, round(sum(light.direct) / 3, 1))
    yield RenderPart(mesh, matrix_of(pose), actor.id, 0, _radius(actor.box) * LONGEST_SHADOW, True)


@lru_cache(maxsize=1024)
def _shadow(box: Box, low: float, heading_deg: float, sun: tuple[float, float, float] | None, strength: float) -> Mesh:
    builder = Builder()
    (cx, cy, _), (hx, hy, hz) = box.center, box.extent
    up: Point = (0.0, 0.0, 1.0)
    grow = 0.35 * min(1.0, 2 * min(hx, hy))
    inner, outer = (
        [(cx + a * i, cy + b * j, low + 0.035) for i, j in _RING]
        for a, b in ((hx * 0.96, hy * 0.96), (hx + grow, hy + grow))
    )
    builder.face(inner, (0, 0, 0), up, glow=True, alpha=140)
    for k in range(4):
        n = (k + 1) % 4
        builder.glowing([inner[k], inner[n], outer[n], outer[k]], (0, 0, 0), up, [140, 140, 0, 0])
    if sun is not None:
        turn = math.radians(-heading_deg)
        x, y = sun[0] * math.cos(turn) - sun[1] * math.sin(turn), sun[0] * math.sin(turn) + sun[1] * math.cos(turn)
        reach = min(2 * hz * 0.9 / max(sun[2], 0.05), LONGEST_SHADOW * 2 * hz)
        flat = math.hypot(x, y) or 1.0
        shift = np.array([-x / flat, -y / flat]) * reach * min(1.0, flat)
        base = np.array([(cx + 0.95 * hx * i, cy + 0.9 * hy * j) for i, j in _RING])
        top = np.array([(cx + 0.7 * hx * i, cy + 0.75 * hy * j) for i, j in _RING]) + shift
        outline = _convex(np.concatenate([base, top]))
        shade: list[Point] = [(float(p[0]), float(p[1]), low + 0.03) for p in outline]
        builder.face(shade, (0, 0, 12), (0, 0, 1.0), glow=True, alpha=int(min(130, 190 * strength)))
    return builder.mesh()


def _convex(points: Floats) -> list[Floats]:
    """Return the convex hull, in order (Andrew's monotone chain)."""
    ordered = sorted(points.tolist())
    chains = []
    for sequence in (ordered, ordered[::-1]):
        chain: list[list[float]] = []
        for p in sequence:
            while len(chain) >= 2 and _turn(chain[-2], chain[-1], p) <= 0:
                chain.pop()
            chain.append(p)
        chains.append(chain[:-1])
    return [np.array(p) for p in chains[0] + chains[1]]


def _turn(a: list[float], b: list[float], c: list[float]) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def _radius(box: Box) -> float:
    return math.hypot(*box.extent) + math.hypot(*box.center)


def _color(actor: Actor) -> Color:
    text = actor.attributes["color"][1] if "color" in actor.attributes else ""
    try:
        red, green, blue = (min(255, max(0, int(float(item)))) for item in text.split(","))
    except (ValueError, OverflowError):
        # An invalid color of a client must not stop the camera.
        return DEFAULT_COLOR
    return red, green, blue


_RING = ((1, 1), (1, -1), (-1, -1), (-1, 1))
_body = lru_cache(maxsize=256)(vehicle_mesh)
_lamps = lru_cache(maxsize=1024)(lamps.lamp_meshes)
_cycle_lamps = lru_cache(maxsize=256)(lamps.cycle_lamp_meshes)
_beam = lru_cache(maxsize=256)(lamps.beam_mesh)
_prop_mesh = lru_cache(maxsize=512)(prop_mesh)
_animal = lru_cache(maxsize=256)(animal_mesh)
_post = lru_cache(maxsize=256)(traffic_lights.post_mesh)
_lights = lru_cache(maxsize=512)(traffic_lights.lamps_mesh)
_repeater_lights = lru_cache(maxsize=8)(traffic_lights.repeater_lamps_mesh)


@lru_cache(maxsize=256)
def _door(type_id: str, box: Box, door: int, swing: float, color: Color) -> Mesh:
    return doors_and_stop_arm.door_mesh(type_id, box, door, swing, color)


@lru_cache(maxsize=256)
def _cycle(type_id: str, box: Box, wheelbase_m: float, color: Color, pedal: float, motor: bool) -> Mesh:
    return cycles.cycle_mesh(type_id, box, wheelbase_m, color, pedal, motor=motor)


@lru_cache(maxsize=1024)
def _person(
    type_id: str,
    half_height_m: float,
    joints: tuple[tuple[str, float, float, float], ...],
    phase: float,
    share: float,
    sign: str,
) -> Mesh:
    model = load_catalog().walkers[type_id]
    height = 2 * half_height_m
    places: dict[str, Point] = {name: (x, y, z) for name, x, y, z in joints}
    if share > 0:
        places = stride(places, phase, share, height)
    if type_id.startswith("walker.flagger"):
        look = clothes_of(type_id, model.gender, model.age)
        dressed = Clothes(look.skin, look.hair, VEST, (60, 66, 84), hat=ORANGE)
        return person(places, height, dressed, {"stop": "stop", "slow": "slow", "go": "slow"}.get(sign, ""))
    return person(places, height, clothes_of(type_id, model.gender, model.age))
