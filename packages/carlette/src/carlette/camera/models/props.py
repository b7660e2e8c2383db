"""Static props as meshes: a specific shape by name if there is one, otherwise a plain box of the prop's size."""

from __future__ import annotations

from collections.abc import Callable

from carlette.camera.models import litter, roadworks, streetware
from carlette.camera.models.mesh import Builder, Mesh
from carlette.geometry import Box


def prop_mesh(type_id: str, box: Box) -> Mesh:
    """A prop in its actor's frame; it fills its box."""
    builder = Builder()
    name = type_id.removeprefix("static.prop.")
    form = next((make for words, make in FORMS if any(word in name for word in words)), streetware.plain)
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
    (("paperbag",), litter.paper_bag),
    (("trashbag", "plasticbag", "shoppingbag", "purse"), litter.bag),
    (("platformgarbage", "dirtdebris"), litter.rubble),
    (("creasedbox02", "creasedbox01"), litter.carton),
    (("paper", "creasedbox", "garbage", "ironplank"), litter.paper),
    (("rock",), litter.rock),
    (("box", "travelcase", "briefcase"), litter.carton),
    (("container",), streetware.container),
    (("barrel", "trashcan", "bin"), roadworks.barrel),
    (("bench",), streetware.bench),
    (("table",), streetware.table),
    (("plantpot",), streetware.pot),
    (("busstop",), streetware.shelter),
    (("foodcart",), streetware.stall),
    (("vendingmachine", "atm", "kiosk", "advertisement", "mailbox", "oil_station"), streetware.machine),
    (("streetsign",), streetware.sign),
    (("ball", "toy", "helmet"), litter.ball),
    (("tyre",), litter.tyre),
    (("haybale",), litter.bale),
    (("cardoor",), litter.loose_door),
)
"""The first entry whose word is part of a prop's name builds it."""
