"""The HTTP side, in a process of its own: never in the control loop's."""
