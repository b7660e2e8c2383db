"""The three cases by which the paper shows how a model reasons, acted out in a simulator."""

from stucksolver_eval.cases.case import CASES, Case, CaseError
from stucksolver_eval.cases.run import CaseResult, run_cases

__all__ = ["CASES", "Case", "CaseError", "CaseResult", "run_cases"]
