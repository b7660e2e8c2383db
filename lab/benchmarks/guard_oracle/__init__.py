"""An oracle for the guard: drives accepted plans in closed loop. It shares no prediction or geometry with the guard."""
