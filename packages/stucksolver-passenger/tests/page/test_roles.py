"""Tokens: each opens what it is for, and nothing else does."""

from __future__ import annotations

import pytest

from stucksolver_passenger.access_tokens import TokenHolder, Tokens

TOKENS = Tokens(b"s" * 32)


def test_a_passengers_token_is_for_one_vehicle():
    holder = TOKENS.holder(TOKENS.passenger("car-1"))
    assert holder == TokenHolder("passenger", "car-1")
    assert holder.may_use("car-1") and not holder.may_use("car-10")


def test_an_operators_token_is_for_all():
    holder = TOKENS.holder(TOKENS.operator())
    assert holder == TokenHolder("operator") and holder.may_use("car-7")


def test_every_start_has_its_own_tokens():
    assert Tokens().operator() != Tokens().operator()
    assert Tokens().holder(TOKENS.operator()) is None


@pytest.mark.parametrize(
    "token",
    [
        "",
        ".",
        "o",
        "o.",
        "p.car-1",
        TOKENS.passenger("car-1")[:-1],
        TOKENS.passenger("car-1") + "A",
        TOKENS.passenger("car-1").replace("car-1", "car-2"),
        "o." + TOKENS.passenger("car-1").rpartition(".")[2],
        TOKENS.operator().upper(),
        "\u00fc" * 30,
        "x" * 10_000,
    ],
)
def test_what_is_no_token_of_ours_opens_nothing(token):
    assert TOKENS.holder(token) is None


@pytest.mark.parametrize("vehicle", ["", "a b", "../x", "a.b", "x" * 41, "-a", "\u00fc"])
def test_a_vehicle_with_a_strange_name_has_no_token(vehicle):
    with pytest.raises(ValueError, match="invalid vehicle id"):
        TOKENS.passenger(vehicle)


def test_the_comparison_takes_the_same_time_wherever_it_differs(monkeypatch):
    """By `hmac.compare_digest`, and by nothing else."""
    import stucksolver_passenger.access_tokens as roles

    seen = []
    real = roles.hmac.compare_digest
    monkeypatch.setattr(roles.hmac, "compare_digest", lambda a, b: seen.append((a, b)) or real(a, b))
    assert TOKENS.holder(TOKENS.operator()) is not None
    assert TOKENS.holder("o.wrong") is None
    assert len(seen) == 2
