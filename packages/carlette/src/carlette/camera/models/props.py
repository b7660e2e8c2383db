"""Static props as meshes: a specific shape by name if there is one, otherwise a plain box of the prop's size."""

from __future__ import annotations

from collections.abc import Callable

from carlette.camera.models import roadworks, small_props, street_furniture
from carlette.camera.models.mesh import Builder, Mesh
from carlette.geometry import Box


def prop_mesh(type_id: str, box: Box) -> Mesh:
    """Return a prop in its actor's frame; it fills its box."""
    builder = Builder()
    name = type_id.removeprefix("static.prop.")
    form = next((make for words, make in FORMS if any(word in name for word in words)), street_furniture.plain)
    form(builder, box, name)
    return builder.mesh()


Form = Callable[[Builder, Box, str], None]
FORMS: tuple[tuple[tuple[str, ...], Form], ...] = (
    (("crossinggatepost",), roadworks.gate_post),
    (("crossinggate",), roadworks.gate),
    (("cone",), roadworks.cone),
    (("streetbarrier",), roadworks.barrier),
    (("chainbarrier",), roadworks.chain),
    (("warningaccident", "warningconstruction"), roadworks.warning),
    (("trafficwarning",), roadworks.arrow_board),
    (("paperbag",), small_props.paper_bag),
    (("trashbag", "plasticbag", "shoppingbag", "purse"), small_props.bag),
    (("platformgarbage", "dirtdebris"), small_props.rubble),
    (("creasedbox02", "creasedbox01"), small_props.carton),
    (("paper", "creasedbox", "garbage", "ironplank"), small_props.paper),
    (("rock",), small_props.rock),
    (("box", "travelcase", "briefcase"), small_props.carton),
    (("container",), street_furniture.container),
    (("barrel", "trashcan", "bin"), roadworks.barrel),
    (("bench",), street_furniture.bench),
    (("table",), street_furniture.table),
    (("plantpot",), street_furniture.pot),
    (("busstop",), street_furniture.shelter),
    (("foodcart",), street_furniture.stall),
    (("vendingmachine", "atm", "kiosk", "advertisement", "mailbox", "oil_station"), street_furniture.machine),
    (("streetsign",), street_furniture.sign),
    (("ball", "toy", "helmet"), small_props.ball),
    (("tyre",), small_props.tyre),
    (("haybale",), small_props.bale),
    (("cardoor",), small_props.loose_door),
)
"""Shapes by words. The first entry whose word is part of a prop's name builds the prop."""
