"""The three cases of Bao and Li 2025 (arXiv:2510.26023) and the paper bag of their first figure, in a simulator."""

from stucksolver_eval.cases.case import CASES, Case, CaseError
from stucksolver_eval.cases.case_runner import CaseResult, run_cases

__all__ = ["CASES", "Case", "CaseError", "CaseResult", "run_cases"]
