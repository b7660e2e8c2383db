"""Places on maps for scenarios: what a type needs of a lane, a junction or a ramp, and where that is."""
