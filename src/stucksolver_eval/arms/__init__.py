"""The arms: the driver alone, timers, or StuckSolver."""

from stucksolver_eval.arms.arm import Arm, ArmLog
from stucksolver_eval.arms.make import ArmError, carries_camera, make_arm

__all__ = ["Arm", "ArmError", "ArmLog", "carries_camera", "make_arm"]
