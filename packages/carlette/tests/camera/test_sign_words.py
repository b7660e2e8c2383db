"""Signs that close a road or lead around it are known by their names on the map, and carry their words."""

from __future__ import annotations

import pytest

from carlette.camera.models.signs import DETOUR, ROAD_CLOSED, kind_of, post_sign


@pytest.mark.parametrize(
    ("name", "kind"),
    [("Sign_RoadClosed", ROAD_CLOSED), ("road_closed_02", ROAD_CLOSED), ("Detour_left", DETOUR), ("Yield_1", "205")],
)
def test_a_sign_is_known_by_its_name(name, kind):
    assert kind_of(name, "-1", "-1") == (kind, "")


def test_sign_two_lines_draw_more_letters_than_one():
    """A sign with two lines has more faces for letters than one with a single line, and a plain sign has none."""

    def faces(kind):
        return len(post_sign(kind).colors)

    assert faces(ROAD_CLOSED) > faces(DETOUR) > faces("306") + 20
