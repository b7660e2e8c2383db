"""What holds for every test of the core."""

import pytest

from alike import comparing
from stucksolver.solver.state_machine.execution import Execution
from stucksolver.solver.state_machine.execution_phases import TRANSITIONS
from stucksolver.solver.state_machine.execution_steps import ExecutionOutcome


@pytest.fixture
def alike():
    """What a test has judged (of looks, every fiftieth) is judged in the mirrored, turned and shuffled world."""
    with comparing(every=50) as found:
        yield
    assert found == []


@pytest.fixture(autouse=True)
def phases(monkeypatch):
    """Every execution in the core's tests takes only the transitions that `docs/states.md` shows."""
    tick, taken = Execution.tick, set()

    def noted(self, view, now_s):
        before = self.phase.name
        result = tick(self, view, now_s)
        if not isinstance(result, ExecutionOutcome) and self.phase.name is not before:
            taken.add((before, self.phase.name))
        return result

    monkeypatch.setattr(Execution, "tick", noted)
    yield taken
    assert taken <= set(TRANSITIONS)
