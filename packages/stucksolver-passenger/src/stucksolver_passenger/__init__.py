"""The passenger's page and HTTP API for talking to the car, outside the control loop."""
