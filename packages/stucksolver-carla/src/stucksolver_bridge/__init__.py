"""StuckSolver for other processes: Python 3.7 and later, standard library only; `carla` is passed in."""

from stucksolver_bridge.agent_driver import AgentDriver
from stucksolver_bridge.lease import JsonLease
from stucksolver_bridge.recovery_client import RecoveryClient
from stucksolver_bridge.solver_process import SolverError, SolverProcess

__all__ = ["AgentDriver", "JsonLease", "RecoveryClient", "SolverError", "SolverProcess"]
