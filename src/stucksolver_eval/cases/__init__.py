"""The three cases with which Bao and Li 2025 (arXiv:2510.26023) show how a model reasons, run in a simulator."""

from stucksolver_eval.cases.case import CASES, Case, CaseError
from stucksolver_eval.cases.run import CaseResult, run_cases

__all__ = ["CASES", "Case", "CaseError", "CaseResult", "run_cases"]
