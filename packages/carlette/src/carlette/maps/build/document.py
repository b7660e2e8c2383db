"""A plan as an OpenDRIVE 1.4 document."""

from __future__ import annotations

from itertools import count
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from carlette.maps.build.junctions import build_junction
from carlette.maps.build.plan import Plan
from carlette.maps.build.roadside import junction_roadside, street_roadside
from carlette.maps.build.streets import build_street, number

GEO_REFERENCE = (
    "+proj=tmerc +lat_0=0 +lon_0=0 +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m "
    "+geoidgrids=egm96_15.gtx +vunits=m +no_defs "
)
# CARLA confuses a junction with the road of the same number if both exist.
_FIRST_JUNCTION, _FIRST_CONNECTING_ROAD, _FIRST_SIGNAL, _FIRST_CONTROLLER = 500, 1000, 10_000, 20_000


def map_xml(plan: Plan) -> str:
    """Return the whole map. The same plan gives the same text on every machine."""
    nodes = {node.name: node for node in plan.nodes}
    junction_ids = {node.name: junction_id for junction_id, node in enumerate(plan.nodes, _FIRST_JUNCTION)}
    streets = [build_street(street, road_id, nodes, junction_ids) for road_id, street in enumerate(plan.streets, 1)]
    road_ids, ids, controller_ids = count(_FIRST_CONNECTING_ROAD), count(_FIRST_SIGNAL), count(_FIRST_CONTROLLER)
    arms = [arm for street in streets for arm in (street.first, street.last)]
    junctions = [
        build_junction(node, junction_ids[node.name], [arm for arm in arms if arm.end.node == node.name], road_ids)
        for node in plan.nodes
    ]
    root = Element("OpenDRIVE")
    root.append(_header(plan))
    roads = [street.element for street in streets] + [road for junction in junctions for road, _ in junction.roads]
    root.extend(roads)
    by_id = {int(road.get("id", "")): road for road in roads}
    for street in streets:
        for road_id, group, element in street_roadside(street, ids):
            _group(by_id[road_id], group).append(element)
    for junction in junctions:
        controllers, roadside = junction_roadside(junction, ids, controller_ids)
        root.extend(controllers)
        for road_id, group, element in roadside:
            _group(by_id[road_id], group).append(element)
    root.extend(junction.element for junction in junctions)
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, encoding="unicode") + "\n"


def _header(plan: Plan) -> Element:
    header = Element("header", revMajor="1", revMinor="4", name=plan.name, version="1", date="2024-01-01T00:00:00")
    margin_m = 100.0
    header.set("north", number(max(node.y for node in plan.nodes) + margin_m))
    header.set("south", number(min(node.y for node in plan.nodes) - margin_m))
    header.set("east", number(max(node.x for node in plan.nodes) + margin_m))
    header.set("west", number(min(node.x for node in plan.nodes) - margin_m))
    header.set("vendor", "StuckSolver")
    SubElement(header, "geoReference").text = GEO_REFERENCE
    return header


def _group(road: Element, name: str) -> Element:
    """`objects` or `signals` of a road; the schema has objects first."""
    found = road.find(name)
    if found is None:
        found = Element(name)
        signals = road.find("signals")
        place = len(road) if name == "signals" or signals is None else list(road).index(signals)
        road.insert(place, found)
    return found
