"""Meshes of vehicles, people, animals, props, signs and lights."""
