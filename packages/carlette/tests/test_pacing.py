"""A snapshot waits for the readers that are not ready, and for no longer than that."""

from __future__ import annotations

import pytest

from carlette.watchdog.pacing import (
    DOUBT_S,
    HANDSHAKE_LIMIT_S,
    REST_S,
    RETURN_LIMIT_S,
    SETTLE_S,
    STEP_LIMIT_S,
    SnapshotPacer,
)


def test_without_traffic_manager_and_new_streams_nothing_waits() -> None:
    pacing = SnapshotPacer()
    pacing.cue(5.0)
    assert pacing.hold_s(5.0, managers=0, awaited_streams=0) == 0.0


def test_a_new_stream_is_waited_for_but_not_for_ever() -> None:
    pacing = SnapshotPacer()
    pacing.cue(5.0)
    assert pacing.hold_s(5.0, 0, 1) == pytest.approx(HANDSHAKE_LIMIT_S)
    assert pacing.hold_s(5.0 + HANDSHAKE_LIMIT_S, 0, 1) == 0.0


def test_a_traffic_manager_gets_time_after_it_asked_for_the_settings() -> None:
    pacing = SnapshotPacer()
    pacing.cue(5.0)
    assert pacing.hold_s(5.0, 1, 0) == pytest.approx(STEP_LIMIT_S)
    pacing.settings_asked(5.001)
    assert pacing.is_settling(5.001, 1, 0)
    assert pacing.hold_s(5.001, 1, 0) == pytest.approx(SETTLE_S)
    assert pacing.hold_s(5.002, 1, 0) == 0.0


def test_a_worker_that_asked_before_the_tick_still_gets_its_rest() -> None:
    pacing = SnapshotPacer()
    pacing.settings_asked(4.9)
    pacing.cue(5.0)
    assert pacing.hold_s(5.0, 1, 0) == pytest.approx(SETTLE_S)


def test_a_silent_traffic_manager_does_not_stop_the_world() -> None:
    pacing = SnapshotPacer()
    pacing.cue(5.0)
    assert pacing.hold_s(5.0 + STEP_LIMIT_S, 1, 0) == 0.0


def test_a_worker_that_asks_right_after_the_snapshot_is_answered_a_little_later() -> None:
    pacing = SnapshotPacer()
    pacing.published(5.0, 1)
    assert pacing.answer_after_s(5.0, managers=1) == pytest.approx(SETTLE_S)
    assert pacing.answer_after_s(5.0, managers=0) == 0.0
    assert pacing.answer_after_s(5.0 + SETTLE_S, managers=1) == 0.0


def test_a_client_that_asks_for_the_settings_itself_is_not_taken_for_the_worker() -> None:
    pacing = SnapshotPacer()
    pacing.settings_asked(4.0)
    pacing.settings_asked(4.0)
    pacing.published(4.1, 1)
    pacing.settings_asked(4.9)
    pacing.cue(5.0)
    assert pacing.hold_s(5.0, 1, 0) == pytest.approx(DOUBT_S)
    pacing.settings_asked(5.001)
    assert pacing.hold_s(5.001, 1, 0) == pytest.approx(SETTLE_S)


def test_a_worker_that_was_late_is_not_taken_for_one_that_waits() -> None:
    pacing = SnapshotPacer()
    pacing.published(4.0, 1)
    pacing.settings_asked(4.1)
    pacing.step_begun()
    pacing.cue(5.0)
    assert pacing.hold_s(5.0, 1, 0) == pytest.approx(STEP_LIMIT_S)


def test_after_a_new_episode_nobody_gets_a_snapshot_before_its_maker_has_come_back() -> None:
    pacing = SnapshotPacer()
    pacing.published(5.0, 0)
    assert pacing.episode_begun(5.01) == pytest.approx(REST_S - 0.01)
    pacing.cue(5.1)
    assert pacing.hold_s(5.1, 0, 0) == pacing.quiet_s(5.1) > 0.0
    pacing.subscribed()
    assert pacing.hold_s(5.1, 0, 0) == pacing.quiet_s(5.1) == 0.0


def test_a_new_episode_whose_maker_stays_away_goes_on_by_itself() -> None:
    pacing = SnapshotPacer()
    assert pacing.episode_begun(5.0) == 0.0
    assert pacing.quiet_s(5.0 + RETURN_LIMIT_S) == 0.0
