"""Finds sites for scenarios on maps: lanes, junctions and ramps that satisfy a type's requirements."""
