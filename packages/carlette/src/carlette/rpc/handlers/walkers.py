"""Walkers: control and skeleton."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from carlette.errors import RequestError
from carlette.rpc.registry import Methods
from carlette.rpc.session import ClientSession
from carlette.wire import encode
from carlette.world.skeleton import BONES, bones

methods = Methods()


@methods.void("apply_control_to_walker")
def apply_control_to_walker(session: ClientSession, actor_id: int, control: Sequence[Any]) -> None:
    actor = session.walker(actor_id, "apply_control_to_walker")
    direction, speed, jump = control
    session.world.walkers.control[actor.index] = (*direction, speed, jump)


def apply_walker_state(session: ClientSession, actor_id: int, transform: Sequence[Any], speed: float) -> None:
    """Put a walker where the client's own navigation has it (a batch command)."""
    actor = session.walker(actor_id, "apply_walker_state")
    pose = encode.read_pose(transform)
    if not pose.is_finite():
        raise RequestError("apply_walker_state: the transform is not finite; give real coordinates")
    session.world.teleport(actor, pose)
    session.world.walkers.control[actor.index, 3] = speed


@methods.value("get_bones_transform")
def get_bones_transform(session: ClientSession, actor_id: int) -> Any:
    """Return the joints of a standing figure, or of the pose that a client set; limbs do not swing here."""
    actor = session.walker(actor_id, "get_bones_transform")
    joints = bones(session.world.pose(actor), actor.box.extent.z, actor.posed, actor.blend)
    return [[[joint.name, *map(encode.pose, (joint.world, joint.component, joint.relative))] for joint in joints]]


@methods.void("set_bones_transform")
def set_bones_transform(session: ClientSession, actor_id: int, control: Sequence[Any]) -> None:
    """Set joints, each in its parent bone's frame; `blend_pose` shows them."""
    actor = session.walker(actor_id, "set_bones_transform")
    posed = {str(name): encode.read_pose(transform) for name, transform in control[0]}
    if not all(item.is_finite() for item in posed.values()):
        raise RequestError("set_bones_transform: a transform is not finite; give real coordinates")
    unknown = [name for name in posed if name not in BONES]
    if unknown:
        raise RequestError(f"set_bones_transform: a walker has no bone '{unknown[0][:40]}'; get_bones() names them")
    actor.posed = {**actor.posed, **posed}


@methods.void("blend_pose")
def blend_pose(session: ClientSession, actor_id: int, share: float) -> None:
    actor = session.walker(actor_id, "blend_pose")
    actor.blend = min(max(float(share), 0.0), 1.0) if share == share else 0.0


@methods.void("get_pose_from_animation")
def get_pose_from_animation(session: ClientSession, actor_id: int) -> None:
    """Use the walker's own pose as the target of the blend."""
    session.walker(actor_id, "get_pose_from_animation").posed = {}
