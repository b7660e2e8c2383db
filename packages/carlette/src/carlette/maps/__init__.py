"""The shipped maps, as OpenDRIVE text; `generate` writes them from the plans in `layouts`."""

from pathlib import Path

SHIPPED = Path(__file__).parent
"""The folder of the `.xodr` files. A map's name is its file's stem."""

DEMO_TOWN = SHIPPED / "demo_town.xodr"
"""A small town: a two-way street across a four-lane ring, with two signalized T-junctions."""
