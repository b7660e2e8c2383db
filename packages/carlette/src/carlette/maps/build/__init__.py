"""Makes OpenDRIVE maps from a plan of nodes and the streets between them."""

from carlette.maps.build.document import map_xml
from carlette.maps.build.plan import (
    Control,
    End,
    JunctionNode,
    Plan,
    PlanError,
    PlannedStreet,
    RoadsidePlot,
    StreetCrossing,
)

__all__ = [
    "Control",
    "End",
    "JunctionNode",
    "Plan",
    "PlanError",
    "PlannedStreet",
    "RoadsidePlot",
    "StreetCrossing",
    "map_xml",
]
