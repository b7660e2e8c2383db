"""What the front camera shows: kinds, lamps and doors of detected objects, and the state of traffic lights."""
