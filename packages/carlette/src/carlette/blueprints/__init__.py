"""The kinds of actors of carlette, under CARLA's ids."""

from carlette.blueprints.definitions import Attribute, AttributeType, Definition
from carlette.blueprints.library import Catalog, load_catalog
from carlette.blueprints.tables import PropModel, VehicleSpec, WalkerModel

__all__ = [
    "Attribute",
    "AttributeType",
    "Catalog",
    "Definition",
    "PropModel",
    "VehicleSpec",
    "WalkerModel",
    "load_catalog",
]
