"""Sweeps the detector's settings: one evaluation for each combination, each in its own folder."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace

from stucksolver_eval.metrics.summary import Summary, summarize
from stucksolver_eval.runner.evaluate import EvaluationSpec, evaluate

SETTINGS = {"v_min": ("v_min_mps", 1 / 3.6), "dt": ("dwell_s", 1.0)}
"""Names on the command line: the detector's field, and the factor from the command line's unit (km/h, s)."""


class SweepError(ValueError):
    """A sweep is invalid. The message contains the correct form."""


Sweep = dict[str, tuple[float, ...]]


def parse_sweep(texts: Sequence[str]) -> Sweep:
    """Parse a sweep such as `v_min=2,5,10` and `dt=0.5,1`. Raises `SweepError`."""
    sweep: Sweep = {}
    for text in texts:
        name, _, values = text.partition("=")
        if name not in SETTINGS:
            raise SweepError(
                f"unknown setting in --sweep: {name!r} of {text}. Use {' or '.join(SETTINGS)}, as v_min=2,5,10"
            )
        try:
            sweep[name] = tuple(float(value) for value in values.split(","))
        except ValueError as error:
            raise SweepError(f"invalid value in --sweep: {text}. Give numbers, as {name}=2,5,10") from error
        if not all(value > 0 for value in sweep[name]):
            raise SweepError(f"invalid value in --sweep: {text}. Every value must be greater than 0")
    return sweep


def sweep_specs(spec: EvaluationSpec, sweep: Sweep) -> dict[str, EvaluationSpec]:
    """Return an evaluation for each combination, by its label, such as `v_min=5,dt=1`."""
    found = {}
    for values in itertools.product(*sweep.values()):
        label = ",".join(f"{name}={value:g}" for name, value in zip(sweep, values, strict=True))
        detector = {SETTINGS[name][0]: value * SETTINGS[name][1] for name, value in zip(sweep, values, strict=True)}
        found[label] = replace(spec, out=spec.out / label, arm=replace(spec.arm, detector=detector))
    return found


def run_sweep(spec: EvaluationSpec, sweep: Sweep) -> dict[str, Summary]:
    """Run all evaluations. Returns their metrics by label. Raises `SweepError` and the errors of `evaluate`."""
    if spec.arm.recovery in ("none", "timers"):
        raise SweepError(f"no detector to sweep: --recovery {spec.arm.recovery}. Use search or another reasoner")
    return {label: summarize(evaluate(item)) for label, item in sweep_specs(spec, sweep).items()}
