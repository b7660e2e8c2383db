"""The HTTP server, in its own process and never in the control loop's."""
