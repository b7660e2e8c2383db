"""The passenger's page and HTTP API for conversation with the car, outside the control loop."""
