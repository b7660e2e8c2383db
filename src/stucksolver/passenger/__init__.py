"""The passenger's page and HTTP API for talking to the car, outside the control loop."""

from stucksolver.passenger.desk import Desk
from stucksolver.passenger.link import LinkError
from stucksolver.passenger.roles import Holder, Tokens
from stucksolver.passenger.seat import Seat
from stucksolver.passenger.server.options import PageError, PageOptions
from stucksolver.passenger.server.process import PassengerServer, ServerDied
from stucksolver.passenger.told import Now

__all__ = [
    "Desk",
    "Holder",
    "LinkError",
    "Now",
    "PageError",
    "PageOptions",
    "PassengerServer",
    "Seat",
    "ServerDied",
    "Tokens",
]
