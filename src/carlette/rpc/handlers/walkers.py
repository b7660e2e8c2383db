"""Walkers: control and skeleton."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from carlette.errors import RequestError
from carlette.rpc.registry import Methods
from carlette.rpc.session import Session
from carlette.wire import encode
from carlette.world.skeleton import bones

methods = Methods()


@methods.void("apply_control_to_walker")
def apply_control_to_walker(session: Session, actor_id: int, control: Sequence[Any]) -> None:
    actor = session.walker(actor_id, "apply_control_to_walker")
    direction, speed, jump = control
    session.world.walkers.control[actor.index] = (*direction, speed, jump)


def apply_walker_state(session: Session, actor_id: int, transform: Sequence[Any], speed: float) -> None:
    """The client's own navigation places a walker (a command of a batch)."""
    actor = session.walker(actor_id, "apply_walker_state")
    pose = encode.read_pose(transform)
    if not pose.is_finite():
        raise RequestError("apply_walker_state: the transform is not finite; give real coordinates")
    session.world.teleport(actor, pose)
    session.world.walkers.control[actor.index, 3] = speed


@methods.value("get_bones_transform")
def get_bones_transform(session: Session, actor_id: int) -> Any:
    """Joints of a standing figure; the limbs of walkers do not swing here."""
    actor = session.walker(actor_id, "get_bones_transform")
    joints = bones(session.world.pose(actor), actor.box.extent.z)
    return [[[one.name, *map(encode.pose, (one.world, one.component, one.relative))] for one in joints]]


@methods.void("set_bones_transform", "blend_pose", "get_pose_from_animation")
def ignore_pose(session: Session, actor_id: int, *_: Any) -> None:
    session.walker(actor_id, "set_bones_transform")
