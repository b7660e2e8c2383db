"""Routes in the CARLA leaderboard's XML form, and the dense line that a route becomes on a map."""

from stucksolver.evaluate.routes.read import RouteFileError, read_routes
from stucksolver.evaluate.routes.route import Parameter, Pose, Position, Route, ScenarioSpec, WeatherKey
from stucksolver.evaluate.routes.write import write_routes

__all__ = [
    "Parameter",
    "Pose",
    "Position",
    "Route",
    "RouteFileError",
    "ScenarioSpec",
    "WeatherKey",
    "read_routes",
    "write_routes",
]
