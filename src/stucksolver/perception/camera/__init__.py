"""What the front camera tells: kinds, lamps and doors of objects that were found, and the state of traffic lights."""
