"""Who helps the driver: nobody, timers, or StuckSolver."""

from stucksolver.evaluate.arms.arm import Arm, ArmLog
from stucksolver.evaluate.arms.make import ArmError, make_arm

__all__ = ["Arm", "ArmError", "ArmLog", "make_arm"]
