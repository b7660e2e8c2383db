"""Why the car stands: a line for the passenger within 10 s, an entry of the operator's queue within 30 s."""

from __future__ import annotations

import pytest
from sitting import Sitting

from stucksolver.scene import ObjectKind
from stucksolver_passenger.api_types import VehicleReport
from stucksolver_passenger.server.fleet_state import Board
from stucksolver_passenger.socket_frames import SocketMessage, Topic
from worlds import World, straight_road, thing

pytest.importorskip("onnxruntime")


def before_people():
    people = [thing(f"p{k}", 60.0, -3.0 - 1.2 * k, kind=ObjectKind.PEDESTRIAN, sideways=0.6) for k in range(60)]
    return Sitting(World(straight_road(oncoming=None), people, cruise_mps=0.0))


def queue_of(report: VehicleReport):
    board = Board()
    board.take(SocketMessage(Topic.HELLO, "car-1", b"Car 1"), lambda data: None)
    board.take(SocketMessage(Topic.NOW, "car-1", report.model_dump_json().encode()), lambda data: None)
    return board.queue()


def test_passenger_is_told_once_why_the_car_waits():
    sitting = before_people()
    sitting.until(lambda now: "I am waiting for people on the road." in " ".join(sitting.car()), limit_s=10.2)
    sitting.drive(20.0)
    assert len([line for line in sitting.car() if "people on the road" in line]) == 1


def test_operator_sees_a_notice_and_no_question():
    sitting = before_people()
    now = sitting.until(lambda now: now.notice is not None, limit_s=30.5)
    (call,) = queue_of(now)
    assert (call.kind, call.question_id, now.question) == ("notice", None, None)
    assert "people on the road" in call.text


def test_notice_leaves_the_queue_when_the_car_moves():
    sitting = before_people()
    sitting.until(lambda now: now.notice is not None, limit_s=30.5)
    sitting.world.objects, sitting.world.cruise_mps = [], 8.0
    assert queue_of(sitting.until(lambda now: now.notice is None, limit_s=4.0)) == ()


def test_question_to_the_operator_replaces_the_notice():
    """One entry for each vehicle: the question has the reason, too."""
    sitting = before_people()
    now = sitting.until(lambda now: now.notice is not None, limit_s=30.5)
    asked = {"question": {"id": "q1", "to": "operator", "kind": "assistance", "text": "May I try again?"}}
    (call,) = queue_of(VehicleReport.model_validate(now.model_dump() | asked))
    assert call.kind == "question"
