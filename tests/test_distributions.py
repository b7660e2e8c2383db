"""Each wheel holds what it should, and works where the other is not installed."""

from __future__ import annotations

import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path

import pytest

pytestmark = pytest.mark.integration

ROOT = Path(__file__).parents[1]
PROJECTS = {"stucksolver": ROOT, "carlette": ROOT / "packages" / "carlette"}


@pytest.fixture(scope="module")
def unpacked(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """The wheel of each distribution, built as a release would be, and unpacked."""
    found = {}
    for name, project in PROJECTS.items():
        folder = tmp_path_factory.mktemp(name)
        build = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation"]
        subprocess.run([*build, "--disable-pip-version-check", "-w", str(folder), str(project)], check=True)
        (wheel,) = folder.glob("*.whl")
        found[name] = folder / "in"
        zipfile.ZipFile(wheel).extractall(found[name])
    return found


def run_alone(folder: Path, program: str) -> subprocess.CompletedProcess[str]:
    """With one wheel and what others wrote, but not with what lies in this checkout."""
    others = sysconfig.get_path("purelib")
    # Without `site` the links to this checkout are not followed.
    start = f"import sys; sys.path[:0] = [{str(folder)!r}]; sys.path.append({others!r}); "
    command = [sys.executable, "-E", "-S", "-c", start + program]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, cwd=folder, check=False)


def test_each_wheel_holds_its_own_packages_and_nothing_of_the_other(unpacked):
    packages = {
        name: {p.name for p in folder.iterdir() if p.suffix != ".dist-info"} for name, folder in unpacked.items()
    }
    assert packages == {
        "stucksolver": {"stucksolver", "stucksolver_eval", "stucksolver_bridge"},
        "carlette": {"carlette"},
    }
    for name, folder in unpacked.items():
        source = PROJECTS[name] / "src"
        tracked = {p.relative_to(source) for p in source.rglob("*") if p.is_file() and "__pycache__" not in p.parts}
        assert tracked <= {p.relative_to(folder) for p in folder.rglob("*")}


def test_the_simulator_alone_serves_a_client(unpacked):
    program = """
import subprocess, carla
try:
    import stucksolver
except ImportError:
    pass
else:
    sys.exit("stucksolver is there")
serve = f"import sys; sys.path[:] = {sys.path!r}; from carlette.cli import main; sys.exit(main(sys.argv[1:]))"
server = subprocess.Popen(
    [sys.executable, "-E", "-S", "-c", serve, "--port", "0", "--exit-on-stdin-eof", "--client-version", VERSION],
    stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
)
port = int(server.stdout.readline().split("listening on ")[1].split()[0].rpartition(":")[2])
client = carla.Client("127.0.0.1", port)
client.set_timeout(30.0)
print(client.get_world().get_map().name)
server.stdin.close()
server.wait(10)
"""
    from importlib.metadata import version

    done = run_alone(unpacked["carlette"], f"VERSION = {version('carla')!r}\n" + program)
    assert (done.returncode, done.stdout.strip()) == (0, "Carla/Maps/demo_town"), done.stderr


def test_the_simulator_says_in_one_line_what_is_missing(unpacked):
    program = "sys.modules['carla'] = None; sys.argv[1:] = []; from carlette.cli import main; sys.exit(main())"
    done = run_alone(unpacked["carlette"], program)
    assert done.returncode == 2
    assert done.stderr.splitlines() == ["carlette: error: not installed: carla; pip install carlette"]


def test_the_core_alone_needs_no_simulator(unpacked):
    program = "\n".join(
        [
            "sys.modules.update(dict.fromkeys(('carla', 'msgpack', 'numba', 'networkx', 'PIL', 'onnxruntime')))",
            "import stucksolver",
            "from stucksolver.reason import RuleReasoner",
            "print(RuleReasoner().name, 'carlette' in sys.modules)",
        ]
    )
    done = run_alone(unpacked["stucksolver"], program)
    assert (done.returncode, done.stdout) == (0, "rules False\n"), done.stderr
