"""StuckSolver for other processes: Python 3.7 and later, standard library only; `carla` is passed in."""

from stucksolver_bridge.agent_driver import AgentDriver
from stucksolver_bridge.lease import Lease
from stucksolver_bridge.recovery_client import Recovery
from stucksolver_bridge.solver_process import SolverError, SolverProcess

__all__ = ["AgentDriver", "Lease", "Recovery", "SolverError", "SolverProcess"]
