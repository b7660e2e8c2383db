"""Draws the Mermaid diagrams of the pages as images without scripts: `python -m lab.docsite.diagrams MERMAID_JS`.

The site must not load anything from another host, and the usual theme loads Mermaid from one. Therefore Chromium draws
each diagram once, with `dist/mermaid.min.js` of the npm package `mermaid` (11), and the image is stored in
`docs/images/diagrams` under the hash of its source. If the source has changed since, it is shown instead.
"""

from __future__ import annotations

import hashlib
import re
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
"""Root of the repository."""
FOLDER = ROOT / "docs" / "images" / "diagrams"
BLOCK = re.compile(r"```mermaid\n(.*?)```", re.DOTALL)
DRAW = """async (source) => {
  mermaid.initialize({startOnLoad: false, securityLevel: "strict", theme: "neutral", htmlLabels: false,
    flowchart: {htmlLabels: false}, fontFamily: "sans-serif"});
  return (await mermaid.render("diagram", source)).svg;
}"""


def picture(source: str) -> Path:
    """Return the path of the drawing of a diagram, which may not exist yet."""
    return FOLDER / f"{hashlib.sha256(source.strip().encode()).hexdigest()[:16]}.svg"


def sources() -> Iterator[str]:
    """Yield the sources of all diagrams in the repository's pages."""
    for page in (ROOT / "ARCHITECTURE.md", ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))):
        yield from BLOCK.findall(page.read_text(encoding="utf-8"))


def with_images(text: str, up: str) -> str:
    """Return a page with its diagrams as images. `up` is the path from the page's folder to the root."""

    def replaced(found: re.Match[str]) -> str:
        """Return the image, with the source folded below it for readers that cannot see the image."""
        source, file = found[1], picture(found[1])
        if not file.is_file():
            return f"```text\n{source}```"
        text = "\n".join(f"    {line}" for line in f"```text\n{source}```".splitlines())
        image = f"![Diagram; its source is below]({up}docs/images/diagrams/{file.name}){{ .diagram }}"
        return f'{image}\n\n??? note "The diagram as text"\n\n{text}\n'

    return BLOCK.sub(replaced, text)


def main() -> int:
    """Draw the missing diagrams, and remove those that no page uses any more."""
    if len(sys.argv) != 2 or not Path(sys.argv[1]).is_file():
        print(
            "error: no mermaid.min.js given. Give its path (npm pack mermaid@11; it is in package/dist/)",
            file=sys.stderr,
        )
        return 2
    from playwright.sync_api import sync_playwright

    FOLDER.mkdir(parents=True, exist_ok=True)
    wanted = {picture(source): source for source in sources()}
    for old in set(FOLDER.glob("*.svg")) - set(wanted):
        old.unlink()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        page = browser.new_page()
        page.set_content("<p></p>")
        page.add_script_tag(path=sys.argv[1])
        for file, source in wanted.items():
            if not file.is_file():
                file.write_text(page.evaluate(DRAW, source), encoding="utf-8")
                print(file.relative_to(ROOT))
        browser.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
