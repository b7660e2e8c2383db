"""Maps that ship with carlette, as OpenDRIVE text; `generate` holds the script that made them."""

from pathlib import Path

DEMO_TOWN = Path(__file__).with_name("demo_town.xodr")
"""A small town: a two-way street across a four-lane ring, with two signalised T-junctions."""
