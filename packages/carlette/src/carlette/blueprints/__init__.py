"""The kinds of actors that carlette knows, under CARLA's ids."""

from carlette.blueprints.definitions import Attribute, AttributeType, Definition
from carlette.blueprints.library import Catalogue, load_catalogue
from carlette.blueprints.tables import PropModel, VehicleSpec, WalkerModel

__all__ = [
    "Attribute",
    "AttributeType",
    "Catalogue",
    "Definition",
    "PropModel",
    "VehicleSpec",
    "WalkerModel",
    "load_catalogue",
]
