"""Routes in the CARLA leaderboard's XML format, and their dense lines on a map."""

from stucksolver_eval.routes.reader import RouteFileError, read_routes
from stucksolver_eval.routes.route import Parameter, Position, Route, RoutePose, ScenarioSpec, WeatherKey
from stucksolver_eval.routes.writer import write_routes

__all__ = [
    "Parameter",
    "Position",
    "Route",
    "RouteFileError",
    "RoutePose",
    "ScenarioSpec",
    "WeatherKey",
    "read_routes",
    "write_routes",
]
