"""CONTRIBUTING.md's templates do what the page says of them."""

from __future__ import annotations

import itertools
import os
import re
import subprocess
import sys
import types
from pathlib import Path
from types import SimpleNamespace

import pytest

from stucksolver.guard import Guard
from stucksolver.plan.behaviors import describe, register, unregister
from stucksolver.reasoners.factory import make_reasoner
from stucksolver.solver import EventKind
from worlds import World, drive, straight_road, stubborn, thing

PAGE = Path(__file__).parents[2] / "CONTRIBUTING.md"
TEMPLATES = dict(re.findall(r"```python\n# (\w+): [^\n]*\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL))
STREET = straight_road()


@pytest.fixture
def made(request, monkeypatch):
    """The template as a module that can be imported by its name."""
    kind = request.param
    module = types.ModuleType(f"template_of_{kind}")
    monkeypatch.setitem(sys.modules, module.__name__, module)
    exec(compile(TEMPLATES[kind], f"CONTRIBUTING.md, {kind}", "exec"), module.__dict__)
    return module


def test_templates_cover_all_kinds_within_60_lines():
    """There is one template for each kind, and none has more than 60 lines."""
    assert sorted(TEMPLATES) == ["behavior", "criterion", "reasoner", "scenario", "sensor", "stack"]
    assert all(len(code.splitlines()) <= 60 for code in TEMPLATES.values())


@pytest.mark.parametrize("name", TEMPLATES)
def test_files_and_folders_that_the_page_names_are_there(name):
    root = PAGE.parent
    for path in re.findall(r"`((?:src|docs|examples|tests|packages)/[\w/.]+)`", PAGE.read_text(encoding="utf-8")):
        assert (root / path).exists(), path


@pytest.mark.parametrize("made", ["behavior"], indirect=True)
def test_the_behavior_is_offered_proven_and_driven(made, request):
    inch = made.InchForward(distance_m=0.8)
    register(made.InchForward)
    request.addfinalizer(lambda: unregister("inch_forward"))
    assert describe(("inch_forward",))[0].parameters["properties"]["distance_m"]["maximum"] == 1.0
    world = World(STREET, [thing("lead", 75.0)])
    verdict, proven = Guard().accept([inch], world.view(), False)
    assert verdict.accepted
    assert proven.path.end_s == pytest.approx(world.x + 0.8, abs=0.51)
    near = World(STREET, [thing("lead", 50.0 + 2.45 + 2.3 + 0.4)])
    assert not Guard().accept([inch], near.view(), False)[0].accepted


@pytest.mark.integration
@pytest.mark.parametrize("made", ["reasoner"], indirect=True)
def test_the_reasoner_waits_and_then_the_vehicle_recovers(made):
    reasoner = make_reasoner(f"own:{made.__name__}:Patient")
    world = World(STREET, [thing("lead", 75.0)], x=66.0)
    seen = drive(world, 60.0, reasoner=reasoner, ladder=stubborn())
    started = next(e for e in seen.events if e.kind is EventKind.STARTED)
    assert started.time_s > made.LONG_S
    assert EventKind.RECOVERED in seen.kinds()
    assert next(e for e in seen.events if e.decision).reasoner == "patient"


@pytest.mark.integration
@pytest.mark.parametrize("made", ["stack"], indirect=True)
def test_the_stack_gets_past_a_parked_car(made):
    """The vehicle is the stand-in of these tests, with the names that the template uses."""
    world = World(STREET, [thing("lead", 75.0)], x=66.0)

    class Vehicle:
        def __getattr__(self, name):
            seen = world.surroundings()
            facts = {"speed_mps": abs(world.speed), "progress_m": world.x, "arrived": False}
            return facts[name] if name in facts else getattr(seen, name)

        def follow(self, path, reverse):
            world.drive(stack.last)

        def stop(self):
            world.drive(stack.last)

        def drive_on(self):
            world.drive(None)

    class Noted(made.MyStack):
        def perform(self, directive):
            self.last = directive
            super().perform(directive)

    stack = Noted(Vehicle())
    while world.time_s < 30.0:
        stack.tick()
    assert world.x > 110.0
    assert world.clearance() > 0.0


@pytest.mark.parametrize("made", ["criterion"], indirect=True)
def test_the_criterion_notes_each_hard_stop_once(made):
    judge = made.HarshBraking()
    speeds = [10.0, 10.0, 9.6, 9.2, 9.0, 9.0, 8.5, 8.4]
    for k, speed in enumerate(speeds):
        place = SimpleNamespace(location=SimpleNamespace(x=1.0, y=2.0, z=0.0))
        judge.update(made.EgoTick(k, 0.05 * k, place, SimpleNamespace(x=speed, y=0.0, z=0.0)))
    assert [i.time_s for i in judge.infractions] == pytest.approx([0.1, 0.3])
    assert judge.infractions[0].kind == "harsh_braking"


@pytest.mark.parametrize("made", ["sensor"], indirect=True)
def test_sensor_template_repeats_last_fix_for_3_s_at_times(made):
    """The sensor repeats its last fix for 3 s now and then, which makes an outage."""
    from carlette.geometry import Pose, Vector
    from carlette.in_process import open_world
    from carlette.sensors.sensor import SensorAttributes

    world = open_world("demo_town")
    sensor, told = made.GnssWithOutages(SensorAttributes("sensor.other.gnss", {})), []
    for k in range(1200):
        world.tick()
        place = Pose(Vector(0.1 * k, 0.0, 0.0))
        moment = SimpleNamespace(scene=SimpleNamespace(world=world), pose=place, delta_s=world.step_s)
        told += sensor.measure(moment)
    runs = [len(list(same)) for _, same in itertools.groupby(told)]
    outages = [run for run in runs if run > 1]
    assert runs[0] == 1 and 5 < len(outages) < 20
    # 3 s are 60 ticks, give or take one by the clock's sums, and the fix before them; the last may be cut off.
    assert all((run - 1) % 60 in (59, 0, 1) for run in outages[:-1]), outages


EVERYWHERE = """
import stucksolver_eval.scenarios.types.stuck as package
package.__path__.append({folder!r})
"""
"""Run at the start of each process that drives a route: the template's file counts as one of the package."""


@pytest.mark.release
@pytest.mark.slow
@pytest.mark.integration
def test_the_scenario_is_staged_and_the_motorcycle_is_passed(tmp_path):
    pytest.importorskip("carla")
    types_of = tmp_path / "types"
    types_of.mkdir()
    (types_of / "broken_down_bike.py").write_text(TEMPLATES["scenario"], encoding="utf-8")
    (tmp_path / "sitecustomize.py").write_text(EVERYWHERE.format(folder=str(types_of)), encoding="utf-8")
    routes = (PAGE.parent / "packages/stucksolver-eval/src/stucksolver_eval/suites/data/immobilized.xml").read_text(
        encoding="utf-8"
    )
    one = next(r for r in re.findall(r" *<route .*?</route>\n", routes, re.DOTALL) if 'type="DoubleParkedVan"' in r)
    file = tmp_path / "own.xml"
    file.write_text(f"<routes>\n{one.replace('DoubleParkedVan', 'BrokenDownBike')}</routes>\n", encoding="utf-8")
    out = tmp_path / "out"
    program = "import sys; from stucksolver.commands import main; sys.exit(main())"
    told = ["evaluate", "--suite", str(file), "--recovery", "search", "--jobs", "1", "--out", str(out)]
    own_path = os.pathsep.join(filter(None, (str(tmp_path), os.environ.get("PYTHONPATH"))))
    done = subprocess.run(
        [sys.executable, "-c", program, *told],
        env=os.environ | {"PYTHONPATH": own_path},
        capture_output=True,
        text=True,
        timeout=240,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    row = (out / "routes.csv").read_text(encoding="utf-8").splitlines()[1]
    assert "BrokenDownBike" in row and "Completed" in row
