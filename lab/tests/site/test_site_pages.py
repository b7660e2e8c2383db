"""The documentation's site, built once: nothing is asked of another host, no link is broken, everybody can read it."""

from __future__ import annotations

import contextlib
import functools
import http.server
import json
import re
import subprocess
import sys
import threading
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest

from grids import each_value, sample

pytestmark = [pytest.mark.integration, pytest.mark.site]

ROOT = Path(__file__).parents[3]
LOADS = re.compile(
    r'<(?:script|img|iframe|audio|video|source)\b[^>]*\bsrc="([^"]+)"|<link\b(?=[^>]*rel="(?:stylesheet|preload|preconnect|icon)")[^>]*href="([^"]+)"'
)
STYLE_LOADS = re.compile(r"(?:@import\s+|url\()[\"']?([^\"')]+)")
REPORT = "<!doctype html><html lang=en><title>replay</title><h1>A replay</h1></html>"
WIDE, NARROW = (1400, 900), (390, 844)
LOOKED_AT = (
    "index.html",
    "docs/tutorial/own-stack.html",
    "docs/reference/python.html",
    "docs/reference/commands.html",
    "docs/states.html",
)


class Quiet(http.server.SimpleHTTPRequestHandler):
    """Serves files without a word."""

    def log_message(self, *told):
        pass


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The folder of the site, as `make docs` builds it."""
    pytest.importorskip("mkdocs", reason="the extra docs is not installed")
    folder = tmp_path_factory.mktemp("site")
    (folder / "report.html").write_text(REPORT, encoding="utf-8")
    command = [
        sys.executable,
        "-m",
        "lab.docsite",
        "--out",
        str(folder / "site"),
        "--report",
        str(folder / "report.html"),
    ]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    return folder / "site"


@pytest.fixture(scope="module")
def address(site):
    """Where the site is served, as a host would serve it."""
    handler = functools.partial(Quiet, directory=str(site))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


def pages(site: Path) -> list[Path]:
    return sorted(site.rglob("*.html"))


def test_site_files_load_nothing_from_other_hosts(site):
    """No page or style sheet loads a file from another host."""
    foreign = []
    for page in pages(site):
        for found in LOADS.findall(page.read_text(encoding="utf-8")):
            foreign += [(page.name, item) for item in found if item.startswith(("http:", "https:", "//"))]
    for sheet in site.rglob("*.css"):
        loads = STYLE_LOADS.findall(sheet.read_text(encoding="utf-8"))
        foreign += [(sheet.name, load) for load in loads if load.startswith(("http:", "https:", "//"))]
    assert foreign == []


def test_every_link_within_the_site_leads_somewhere(site):
    ids = {page: set(re.findall(r'\bid="([^"]+)"', page.read_text(encoding="utf-8"))) for page in pages(site)}
    broken = []
    for page in pages(site):
        if page.name == "404.html":
            continue  # its links are those of a site at the top of its host
        for link in re.findall(r'<a\b[^>]*\bhref="([^"]+)"', page.read_text(encoding="utf-8")):
            to = urlsplit(link)
            if to.scheme or to.netloc:
                continue
            target = (page.parent / unquote(to.path)).resolve() if to.path else page
            target = target / "index.html" if target.is_dir() else target
            if not target.exists() or (
                to.fragment and target in ids and unquote(to.fragment) not in ids[target] | {"__top"}
            ):
                broken.append((str(page.relative_to(site)), link))
    assert broken == []


def test_site_pages_open_without_other_hosts_or_script_errors(site, address, browser):
    """Pages open in a browser without a request to another host and without a failing script."""
    asked, wrong = set(), []
    with contextlib.closing(browser.new_page()) as page:
        page.on("pageerror", lambda error: wrong.append(str(error)))
        page.on("response", lambda answer: wrong.append(answer.url) if answer.status >= 400 else None)

        def decide(route):
            asked.add(urlsplit(route.request.url).netloc)
            route.continue_() if route.request.url.startswith(address) else route.abort()

        page.route(re.compile("^https?:"), decide)
        for item in {*LOOKED_AT, *sample((str(item.relative_to(site)) for item in pages(site)), 20)} - {"404.html"}:
            page.goto(f"{address}/{item}")
    assert asked == {urlsplit(address).netloc} and wrong == []


def test_search_finds_a_word_without_another_host(address, browser):
    with contextlib.closing(browser.new_page()) as page:
        page.goto(f"{address}/index.html", wait_until="networkidle")
        # The page listens for keys, not for what is filled in, and only once its scripts have run.
        page.locator("input.md-search__input").press_sequentially("immobilized", delay=50.0)
        page.wait_for_selector(".md-search-result__item")


@pytest.mark.parametrize(("size", "scheme"), each_value([WIDE, NARROW], ["light", "dark"]))
def test_axe_finds_nothing(address, browser, violations, size, scheme):
    found = {}
    context = browser.new_context(color_scheme=scheme, viewport={"width": size[0], "height": size[1]})
    with contextlib.closing(context):
        page = context.new_page()
        for name in LOOKED_AT:
            page.goto(f"{address}/{name}")
            found[name] = violations(page)
            sideways = page.evaluate("document.documentElement.scrollWidth - document.documentElement.clientWidth")
            assert sideways <= 0, f"{name} is wider than the screen"
    assert not any(found.values()), found


def test_the_reference_has_every_command_option_type_and_call(site):
    from lab.commands import COMMANDS
    from stucksolver.commands.command_table import commands as all_commands
    from stucksolver.plan.json_schemas import schemas

    commands = (site / "docs/reference/commands.html").read_text(encoding="utf-8")
    assert all(f'id="stucksolver-{name}"' in commands for name in all_commands())
    assert all(f'id="python-m-lab-{name}"' in commands for name in COMMANDS)
    assert "--oncoming" in commands and "Exit codes" in commands
    for name, schema in schemas().items():
        assert json.loads((site / f"docs/reference/schemas/{name}.json").read_text(encoding="utf-8")) == schema
    http_page = (site / "docs/reference/http.html").read_text(encoding="utf-8")
    calls = json.loads((site / "docs/reference/openapi.json").read_text(encoding="utf-8"))["paths"]
    assert len(calls) > 5 and all(path in http_page for path in calls)
    python = (site / "docs/reference/python.html").read_text(encoding="utf-8")
    assert 'id="stucksolver.solver.StuckSolver.step"' in python


def test_site_contains_demo_report_unchanged(site):
    """The report of the demonstration is a page of the site, unchanged, and its page links to it."""
    assert (site / "docs/demo/report.html").read_text(encoding="utf-8") == REPORT
    assert 'href="demo/report.html"' in (site / "docs/demo.html").read_text(encoding="utf-8")


def test_diagrams_are_pictures_with_their_text(site):
    page = (site / "ARCHITECTURE.html").read_text(encoding="utf-8")
    assert "flowchart LR" in page, "as text, below the picture or in its place"
    assert 'class="mermaid"' not in page
