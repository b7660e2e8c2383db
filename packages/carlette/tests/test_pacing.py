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


def test_pacer_traffic_manager_gets_settle_time_after_settings_request() -> None:
    """The snapshot waits for a traffic manager, and for a settle time once it has requested the settings."""
    pacing = SnapshotPacer()
    pacing.cue(5.0)
    assert pacing.hold_s(5.0, 1, 0) == pytest.approx(STEP_LIMIT_S)
    pacing.settings_asked(5.001)
    assert pacing.is_settling(5.001, 1, 0)
    assert pacing.hold_s(5.001, 1, 0) == pytest.approx(SETTLE_S)
    assert pacing.hold_s(5.002, 1, 0) == 0.0


def test_pacer_settings_requested_before_tick_still_get_settle_time() -> None:
    """A worker that requested the settings before the tick still gets its settle time."""
    pacing = SnapshotPacer()
    pacing.settings_asked(4.9)
    pacing.cue(5.0)
    assert pacing.hold_s(5.0, 1, 0) == pytest.approx(SETTLE_S)


def test_a_silent_traffic_manager_does_not_stop_the_world() -> None:
    pacing = SnapshotPacer()
    pacing.cue(5.0)
    assert pacing.hold_s(5.0 + STEP_LIMIT_S, 1, 0) == 0.0


def test_pacer_settings_request_after_snapshot_is_answered_later() -> None:
    """A worker that requests the settings directly after the snapshot is answered after the settle time."""
    pacing = SnapshotPacer()
    pacing.published(5.0, 1)
    assert pacing.answer_after_s(5.0, managers=1) == pytest.approx(SETTLE_S)
    assert pacing.answer_after_s(5.0, managers=0) == 0.0
    assert pacing.answer_after_s(5.0 + SETTLE_S, managers=1) == 0.0


def test_pacer_settings_request_of_client_is_not_of_worker() -> None:
    """Settings that the client requests itself do not count as the request of the worker."""
    pacing = SnapshotPacer()
    pacing.settings_asked(4.0)
    pacing.settings_asked(4.0)
    pacing.published(4.1, 1)
    pacing.settings_asked(4.9)
    pacing.cue(5.0)
    assert pacing.hold_s(5.0, 1, 0) == pytest.approx(DOUBT_S)
    pacing.settings_asked(5.001)
    assert pacing.hold_s(5.001, 1, 0) == pytest.approx(SETTLE_S)


def test_pacer_late_worker_does_not_count_as_waiting() -> None:
    """A worker whose request came late does not count as one that waits."""
    pacing = SnapshotPacer()
    pacing.published(4.0, 1)
    pacing.settings_asked(4.1)
    pacing.step_begun()
    pacing.cue(5.0)
    assert pacing.hold_s(5.0, 1, 0) == pytest.approx(STEP_LIMIT_S)


def test_pacer_new_episode_holds_snapshots_until_its_client_returns() -> None:
    """After a new episode, snapshots wait until the client that made it has subscribed again."""
    pacing = SnapshotPacer()
    pacing.published(5.0, 0)
    assert pacing.episode_begun(5.01) == pytest.approx(REST_S - 0.01)
    pacing.cue(5.1)
    assert pacing.hold_s(5.1, 0, 0) == pacing.quiet_s(5.1) > 0.0
    pacing.subscribed()
    assert pacing.hold_s(5.1, 0, 0) == pacing.quiet_s(5.1) == 0.0


def test_pacer_new_episode_with_absent_client_continues() -> None:
    """A new episode continues after the time limit if its client does not return."""
    pacing = SnapshotPacer()
    assert pacing.episode_begun(5.0) == 0.0
    assert pacing.quiet_s(5.0 + RETURN_LIMIT_S) == 0.0
