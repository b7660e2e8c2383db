"""An oracle for the guard that shares no prediction and no geometry with it: accepted plans, driven in closed loop."""
