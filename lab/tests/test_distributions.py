"""Each wheel holds what it should, and works where the others are not installed."""

from __future__ import annotations

import re
import subprocess
import sys
import sysconfig
import zipfile
from importlib.metadata import PackageNotFoundError, packages_distributions, requires, version
from pathlib import Path

import pytest

from lab.releasing.__main__ import NEEDS
from lab.releasing.distributions import PROJECTS, file_name

pytestmark = [pytest.mark.integration, pytest.mark.slow]


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


ONLY = """
# Nothing is found but what the wheel brings, and what it says that it needs.
import sys
class Only:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {hidden!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)
sys.meta_path.insert(0, Only())
sys.path[:0] = {folders!r}
sys.path.append({others!r})
"""


def needed_by(folder: Path) -> set[str]:
    """The distributions that a wheel names in its metadata, without extras, and those that they need in turn."""
    (metadata,) = folder.glob("*.dist-info/METADATA")
    lines = [line for line in metadata.read_text(encoding="utf-8").splitlines() if line.startswith("Requires-Dist: ")]
    todo, found = [line.removeprefix("Requires-Dist: ") for line in lines], set[str]()
    while todo:
        told = todo.pop()
        name = canonical(re.split(r"[ ;<>=!~\[(]", told, maxsplit=1)[0])
        if "extra ==" in told or name in found:
            continue
        found.add(name)
        try:
            todo += requires(name) or []
        except PackageNotFoundError:
            continue  # for another Python or system
    return found


def canonical(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def run_alone(folder: Path, program: str, *others: Path) -> subprocess.CompletedProcess[str]:
    """With one wheel and what it needs, but not with what lies in this checkout or is there by chance.

    `others` are unpacked wheels of ours that it needs.
    """
    allowed = needed_by(folder)
    brought = packages_distributions()
    hidden = {module for module, names in brought.items() if not {canonical(name) for name in names} & allowed}
    folders = [folder, *others]
    own = {path.name for each in folders for path in each.iterdir()}
    # Without `site` the links to this checkout are not followed.
    start = ONLY.format(
        hidden=hidden - own, folders=[str(each) for each in folders], others=sysconfig.get_path("purelib")
    )
    command = [sys.executable, "-E", "-S", "-c", f"START = {start!r}\n" + start + program]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, cwd=folder, check=False)


def test_wheel_holds_its_own_packages_only(unpacked):
    packages = {
        name: {p.name for p in folder.iterdir() if p.suffix != ".dist-info"} for name, folder in unpacked.items()
    }
    expected = {name: {file_name(name)} for name in PROJECTS}
    expected["stucksolver-carla"].add("stucksolver_bridge")
    assert packages == expected
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
serve = START + "from carlette.cli import main; sys.exit(main(sys.argv[1:]))"
server = subprocess.Popen(
    [sys.executable, "-E", "-S", "-c", serve, "--port", "0", "--exit-on-stdin-eof", "--client-version", VERSION],
    stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
)
port = int(server.stdout.readline().split("listening on ")[1].split()[0].rpartition(":")[2])
client = carla.Client("127.0.0.1", port)
client.set_timeout(60.0)
print(client.get_world().get_map().name)
server.stdin.close()
server.wait(10)
"""
    done = run_alone(unpacked["carlette"], f"VERSION = {version('carla')!r}\n" + program)
    assert (done.returncode, done.stdout.strip()) == (0, "Carla/Maps/demo_town"), done.stderr


def test_the_simulator_says_in_one_line_what_is_missing(unpacked):
    program = "sys.modules['carla'] = None; sys.argv[1:] = []; from carlette.cli import main; sys.exit(main())"
    done = run_alone(unpacked["carlette"], program)
    assert done.returncode == 2
    assert done.stderr.splitlines() == ["carlette: error: not installed: carla. Run pip install carla"]


def test_the_core_alone_needs_no_simulator(unpacked):
    program = "\n".join(
        [
            "import stucksolver",
            "from stucksolver.reasoners import SearchReasoner",
            "print(SearchReasoner().name, 'carlette' in sys.modules)",
        ]
    )
    done = run_alone(unpacked["stucksolver"], program)
    assert (done.returncode, done.stdout) == (0, "search False\n"), done.stderr


IMPORTED = {
    "stucksolver-carla": "stucksolver_carla.sidecar",
    "stucksolver-perception": "stucksolver_perception.pipeline",
    "stucksolver-language": "stucksolver_language.llm",
    "stucksolver-passenger": "stucksolver_passenger.gateway",
}


@pytest.mark.parametrize("name", IMPORTED)
def test_plugin_imports_with_the_distributions_it_names(unpacked, name):
    done = run_alone(unpacked[name], f"import {IMPORTED[name]}", *[unpacked[other] for other in NEEDS[name]])
    assert done.returncode == 0, done.stderr


def test_core_wheel_is_smaller_than_one_megabyte(unpacked):
    assert sum(path.stat().st_size for path in unpacked["stucksolver"].rglob("*.py")) < 2**20
