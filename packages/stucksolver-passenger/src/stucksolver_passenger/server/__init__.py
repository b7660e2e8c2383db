"""The HTTP server. It runs in its own process, never in the process of the control loop."""
