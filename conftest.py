"""What holds for every test."""

import os
import shutil
import signal
import subprocess
import tarfile

import pytest
from hypothesis import settings

# Machines are busy and noisy: how long an example takes says nothing about what is tested. Every run draws the same
# examples, so that it tells about the change and not about luck; `RANDOM_EXAMPLES=1` draws new ones.
settings.register_profile("repeatable", deadline=None, derandomize=not os.environ.get("RANDOM_EXAMPLES"))
settings.load_profile("repeatable")

# A shell starts what it puts into the background with SIGINT ignored; every process that a test starts inherits that.
signal.signal(signal.SIGINT, signal.default_int_handler)

CHROMIUM_FLAGS = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking"]
AXE = "axe-core@4.14.1"
AXE_RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"]


def pytest_collection_modifyitems(items):
    """Files that take long come first: the short ones then fill what is left, and no worker waits for the last."""
    long = {item.path: 0 for item in items}
    for item in items:
        if item.get_closest_marker("release"):
            item.add_marker("slow")
        marks = {mark.name for mark in item.iter_markers()}
        long[item.path] = max(long[item.path], 2 * ("slow" in marks or "site" in marks) + ("integration" in marks))
    items.sort(key=lambda item: -long[item.path])


@pytest.fixture(scope="module")
def browser():
    """Debian's Chromium, one for all tests of a file: Playwright keeps an event loop running as long as it is open."""
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    chromium = shutil.which("chromium")
    if chromium is None:
        pytest.skip("chromium is not installed: apt-get install chromium")
    with playwright.sync_playwright() as started:
        opened = started.chromium.launch(executable_path=chromium, args=CHROMIUM_FLAGS)
        yield opened
        opened.close()


@pytest.fixture(scope="session")
def axe(tmp_path_factory):
    """The rules of axe-core (MPL-2.0), fetched for the tests and kept nowhere else."""
    folder = tmp_path_factory.mktemp("axe")
    if shutil.which("npm") is None:
        pytest.skip("npm is not installed, which fetches axe-core")
    fetched = subprocess.run(["npm", "pack", AXE], cwd=folder, capture_output=True, text=True, timeout=60, check=False)
    if fetched.returncode:
        pytest.skip(f"npm cannot fetch {AXE}: {fetched.stderr.strip().splitlines()[-1]}")
    with tarfile.open(next(folder.glob("*.tgz"))) as packed:
        found = packed.extractfile("package/axe.min.js")
        assert found is not None
        return found.read().decode()


@pytest.fixture(scope="session")
def violations(axe):
    """What axe finds on a page of a browser, by rule, with the elements."""

    def look(page):
        page.evaluate(axe)
        told = "violations.map((one) => [one.id, one.nodes.map((node) => node.html)])"
        return page.evaluate(f"async (rules) => (await axe.run(document, {{runOnly: rules}})).{told}", AXE_RULES)

    return look
