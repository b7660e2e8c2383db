"""Recordings of drives: the rig's sensors on the hero, the truth beside them, and a crowd to be seen."""
