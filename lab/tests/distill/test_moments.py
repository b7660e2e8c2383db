"""Moments: when a wait ended by itself, which plans the guard accepts, and what is kept of a drive."""

from __future__ import annotations

import numpy as np
import pytest

from lab.language.plan_search.decision_samples import DecisionSample, gone_after, read_moments, write_moments
from lab.language.student.data import ends_of, held_out

TRACK = np.array([(0, 0), (1, 10), (2, 10), (3, 10), (4, 10), (5, 11), (6, 14), (7, 20), (8, 20)], np.float64)


def moment(**changes: object) -> DecisionSample:
    usual = {
        "suite": "s",
        "route_id": "1",
        "seed": 1,
        "scenario": "Accident",
        "town": "grid_town",
        "standstill": 0,
        "at_s": 1.0,
        "scene": "",
        "gone_after_s": None,
        "watched_s": 3.0,
    }
    return DecisionSample.model_validate({**usual, **changes})


@pytest.mark.parametrize(("at_s", "after_s"), [(1.0, 3.5), (4.0, 0.5), (2.5, 2.0), (7.0, None)])
def test_standstill_ends_when_vehicle_leaves_position_for_good(at_s, after_s):
    """A standstill ends with the start after which the vehicle leaves its position for good."""
    assert gone_after(TRACK, at_s) == after_s


def test_who_only_creeps_up_has_not_gone_on():
    crawls = np.array([(0, 0), (1, 2), (2, 2), (3, 4), (4, 4)], np.float64)
    assert gone_after(crawls, 0.0) is None


@pytest.mark.parametrize(
    ("gone", "watched", "ends"),
    [
        (1.0, 100.0, [1, -1, -1, -1, -1]),
        (7.0, 100.0, [0, 0, 1, -1, -1]),
        (None, 100.0, [0, 0, 0, 0, 0]),
        (None, 12.0, [0, 0, 0, -1, -1]),
        (90.0, 100.0, [0, 0, 0, 0, 0]),
        (None, 0.0, [-1, -1, -1, -1, -1]),
    ],
)
def test_what_was_not_watched_is_not_known(gone, watched, ends):
    assert ends_of(gone, watched).tolist() == ends


def test_variants_of_one_situation_are_held_out_together():
    for name in ("Accident", "ParkedObstacle", "ConstructionObstacle", "HazardAtSideLane"):
        groups = {held_out(moment(scenario=name + more), ()) in ("train", "tune") for more in ("", "TwoWays")}
        assert len(groups) == 1
    assert held_out(moment(town="motorway"), ("motorway",)) == "maps"
    assert held_out(moment(), (f"{moment().suite}/{moment().route_id}",)) == "routes"


def test_moments_survive_their_file(tmp_path):
    kept = [moment(), moment(at_s=4.0, gone_after_s=2.0)]
    write_moments(tmp_path / "a.jsonl.gz", kept)
    assert read_moments(tmp_path / "a.jsonl.gz") == kept


def test_a_damaged_file_is_named(tmp_path):
    write_moments(tmp_path / "a.jsonl.gz", [moment()] * 30)
    data = (tmp_path / "a.jsonl.gz").read_bytes()
    (tmp_path / "a.jsonl.gz").write_bytes(data[: len(data) // 2])
    with pytest.raises(ValueError, match=r"cannot read samples: .*a\.jsonl\.gz"):
        read_moments(tmp_path / "a.jsonl.gz")
