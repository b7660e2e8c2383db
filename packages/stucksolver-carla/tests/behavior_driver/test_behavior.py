"""What the published profiles and the stopping envelope promise."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stucksolver_carla.drivers.behavior.profiles import PROFILES, cruise_speed, emergency, profile_named, toward_gap


def settle(speed, room, lead_speed, deceleration, seconds=60.0, dt=0.02):
    """Drive exactly the wanted acceleration; returns the least room, the last room and speed, hardest braking."""
    least, hardest = room, 0.0
    for _ in range(int(seconds / dt)):
        wanted = min(toward_gap(speed, room, lead_speed, deceleration), 2.0)
        hardest = min(hardest, wanted)
        before, speed = speed, max(speed + wanted * dt, 0.0)
        room += (lead_speed - (before + speed) / 2.0) * dt
        least = min(least, room)
    return least, room, speed, -hardest


@pytest.mark.integration
@given(st.floats(0.0, 20.0), st.floats(0.0, 10.0), st.floats(1.5, 3.5))
def test_braking_to_gap_has_no_overshoot_and_comfortable_deceleration(extra, lead, deceleration):
    """A gap is closed without overshoot and with about the comfortable braking."""
    speed = lead + min(extra, 14.0)
    room = (speed - lead) ** 2 / (2.0 * deceleration) * 1.2 + deceleration + 3.0
    least, last, final, hardest = settle(speed, room, lead, deceleration)
    assert least > -0.2
    assert last == pytest.approx(0.0, abs=0.3)
    assert final == pytest.approx(lead, abs=0.1)
    assert hardest < 1.35 * deceleration


@given(st.floats(0.0, 30.0), st.floats(0.0, 100.0), st.floats(0.0, 30.0))
def test_more_room_never_asks_for_more_braking(speed, room, lead):
    assert toward_gap(speed, room + 1.0, lead, 2.5) >= toward_gap(speed, room, lead, 2.5) - 1e-6


@given(st.floats(1.0, 30.0), st.floats(1.2, 100.0))
def test_an_emergency_brakes_hard_enough_to_stop_where_physics_can(speed, gap):
    braking = emergency(speed, gap, 0.0)
    needed = speed**2 / (2.0 * gap)
    if braking is None:
        assert needed < 4.0
    else:
        assert -braking >= min(needed, 9.5)


def test_targets_keep_the_published_margins_below_the_limit():
    kmh = {name: round(cruise_speed(profile, 50.0) * 3.6, 3) for name, profile in PROFILES.items()}
    assert kmh == {"cautious": 40.0, "normal": 47.0, "aggressive": 49.0}
    assert cruise_speed(PROFILES["aggressive"], 200.0) * 3.6 == pytest.approx(70.0)


def test_an_unknown_profile_is_refused_with_the_known_ones():
    with pytest.raises(ValueError, match="cautious, normal, aggressive"):
        profile_named("sporty")
