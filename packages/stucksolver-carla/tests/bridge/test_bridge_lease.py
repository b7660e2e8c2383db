"""The lease of stacks that cannot import stucksolver is the same as that of those which can, and never raises."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from stucksolver.plan import CONTINUE, Execute, Lease, PathPoint, Replan, SafeStop, lease
from stucksolver.plan.behaviors import KeepLane, Wait
from stucksolver.plan.directive import EXPIRES_TICKS, directive_adapter
from stucksolver_bridge import lease as bridge
from stucksolver_bridge.solver_exchange import OLD_TICKS

ON = KeepLane(distance_m=60.0, speed_mps=5.0)
places = st.floats(-50.0, 50.0)
points = st.builds(PathPoint, x_m=places, y_m=places, speed_mps=st.floats(0.0, 11.0), no_stop=st.booleans())
orders = st.one_of(
    st.just(CONTINUE),
    st.just(Replan()),
    st.just(SafeStop(reason="blocked")),
    st.builds(Execute, behavior=st.just(Wait(duration_s=2.0)), brake_mps2=st.none() | st.floats(1.0, 9.0)),
    st.builds(
        Execute,
        behavior=st.just(ON),
        path=st.lists(points, min_size=2, max_size=5).map(tuple),
        expires_ticks=st.integers(1, 12),
    ),
)
ticks = st.tuples(places, places, st.booleans(), st.booleans())
steps = st.one_of(orders, ticks, ticks, ticks, st.just("expire"))


@pytest.mark.integration
@given(st.lists(steps, max_size=60))
def test_both_leases_perform_the_same(sequence):
    ours, theirs = Lease(), bridge.JsonLease()
    for step in sequence:
        if step == "expire":
            ours.expire()
            theirs.expire()
        elif isinstance(step, tuple):
            x, y, done, rests = step
            told = ours.tick(x, y, path_is_done=done, at_rest=rests)
            form = theirs.tick(x, y, path_is_done=done, at_rest=rests)
            assert directive_adapter.validate_python(form) == told
        else:
            ours.renew(step)
            theirs.renew(directive_adapter.dump_python(step, mode="json"))
        assert theirs.expired == ours.expired


def test_their_figures_are_the_same():
    assert EXPIRES_TICKS == bridge.EXPIRES_TICKS == OLD_TICKS
    assert lease.STUCK_TICKS == bridge.STUCK_TICKS
    assert directive_adapter.validate_python(bridge.STAND) == lease.STAND


JUNK = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=8,
)
FIELDS = ("kind", "path", "expires_ticks", "brake_mps2", "behavior", "reverse")


@pytest.mark.integration
@given(st.dictionaries(st.sampled_from(FIELDS), JUNK).map(lambda form: {"kind": "execute", **form}) | JUNK)
def test_whatever_is_said_something_can_be_performed(form):
    held = bridge.JsonLease()
    held.renew(form)
    for k in range(30):
        due = held.tick(0.0, 0.0, path_is_done=False, at_rest=k > 20)
        assert due["kind"] in ("continue", "execute", "replan", "safe_stop")


def test_json_lease_unchanged_answer_renews_and_expired_needs_directive():
    """An unchanged answer renews the lease; after its expiry, the directive must be sent again."""
    held, order = bridge.JsonLease(), {"kind": "execute", "path": [{"x_m": 0.0, "y_m": 0.0, "speed_mps": 1.0}] * 2}
    held.renew(order)
    for _ in range(50):
        held.renew(None)
        assert held.tick(0.0, 0.0, path_is_done=False, at_rest=False) is order
    for _ in range(EXPIRES_TICKS):
        held.tick(0.0, 0.0, path_is_done=False, at_rest=False)
    held.renew(None)
    assert held.expired and held.tick(0.0, 0.0, path_is_done=False, at_rest=False) == bridge.STAND
    held.renew(order)
    assert not held.expired


@pytest.mark.parametrize("wrong", [7, "go", [], {}, {"kind": "drive"}, {"kind": "execute", "path": "ahead"}])
def test_what_cannot_be_performed_is_stood_still_at(wrong):
    held = bridge.JsonLease()
    held.renew({"kind": "continue"})
    held.renew(wrong)
    assert held.fault and held.order == bridge.STAND
