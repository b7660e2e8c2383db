from __future__ import annotations

import pytest
from made_up import frame

from lab.perception.evaluation.metrics.clear_mot import MotCounts, clear_mot


def test_a_track_on_its_object_makes_no_error() -> None:
    counts = clear_mot([frame({1: 0.0}, {7: 0.5}), frame({1: 1.0}, {7: 1.5})], 2.0)
    assert (counts.mota, counts.motp_m, counts.switches) == (1.0, 0.5, 0)


def test_another_track_on_the_same_object_is_a_switch() -> None:
    counts = clear_mot([frame({1: 0.0}, {7: 0.0}), frame({1: 0.0}, {8: 0.0})], 2.0)
    assert (counts.switches, counts.misses, counts.false_positives) == (1, 0, 0)
    assert counts.mota == 0.5


def test_a_switch_is_noticed_after_a_gap_too() -> None:
    frames = [frame({1: 0.0}, {7: 0.0}), frame({1: 0.0}, {}), frame({1: 0.0}, {8: 0.0})]
    counts = clear_mot(frames, 2.0)
    assert (counts.switches, counts.misses) == (1, 1)


def test_an_object_keeps_its_track_though_another_is_nearer() -> None:
    frames = [frame({1: 0.0}, {7: 0.0}), frame({1: 0.0}, {7: 1.0, 8: 0.1})]
    counts = clear_mot(frames, 2.0)
    assert (counts.switches, counts.false_positives) == (0, 1)


def test_pairs_are_such_that_the_sum_of_distances_is_smallest() -> None:
    counts = clear_mot([frame({1: 0.0, 2: 1.5}, {7: 1.0, 8: 2.5})], 2.0)
    assert (counts.matches, counts.distance_m) == (2, 2.0)


def test_mota_errors_exceeding_objects_make_it_negative() -> None:
    """Misses and false tracks are counted, and MOTA is negative when they outnumber the objects."""
    counts = clear_mot([frame({1: 0.0}, {7: 10.0, 8: 20.0})], 2.0)
    assert (counts.misses, counts.false_positives) == (1, 2)
    assert counts.mota == -2.0


def test_clear_mot_uncounted_object_is_neither_miss_nor_error() -> None:
    """An object that does not count is neither missed nor a false positive when it is tracked."""
    followed = clear_mot([frame({1: 0.0, 2: 9.0}, {7: 0.0, 8: 9.0}, unseen=2)], 2.0)
    alone = clear_mot([frame({1: 0.0, 2: 9.0}, {7: 0.0}, unseen=2)], 2.0)
    assert (followed.objects, followed.false_positives, followed.misses) == (1, 0, 0)
    assert (alone.objects, alone.misses) == (1, 0)


def test_without_objects_there_is_no_accuracy() -> None:
    assert MotCounts().mota is None


def test_counts_of_drives_add_up() -> None:
    one, other = clear_mot([frame({1: 0.0}, {7: 0.0})], 2.0), clear_mot([frame({1: 0.0}, {})], 2.0)
    assert (one + other).mota == pytest.approx(0.5)
