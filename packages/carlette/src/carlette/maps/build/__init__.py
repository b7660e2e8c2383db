"""Makes OpenDRIVE maps from a plan of nodes and the streets between them."""

from carlette.maps.build.document import map_xml
from carlette.maps.build.plan import Block, Control, Crossing, End, Node, Plan, PlanError, Street

__all__ = ["Block", "Control", "Crossing", "End", "Node", "Plan", "PlanError", "Street", "map_xml"]
