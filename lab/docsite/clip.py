"""Makes the README's clip from the demonstration's page: `python -m lab.docsite.clip [out/demo/report.html]`.

Chromium shows the page's first situation, with its two runs side by side, at successive times. The screenshots become
the looping animation `docs/images/demo.webp`. `make demo` writes the page.
"""

from __future__ import annotations

import io
import shutil
import sys
from pathlib import Path

from PIL import Image

from lab.docsite.diagrams import ROOT

FILE = ROOT / "docs" / "images" / "demo.webp"
FROM_S, TO_S, STEP_S = 4.0, 43.0, 0.5
"""Start, end and step of the clip in the report (s)."""
FRAME_MS = 125
"""Duration of a frame (ms): the clip plays at four times the speed of the drive."""
SIZE = {"width": 1200, "height": 545}
"""Size of the screenshots (px)."""
WIDTH_PX = 900
"""Width of the clip (px)."""
SHOW = """([slider, time_s]) => {
  slider.value = time_s;
  slider.dispatchEvent(new Event("input", {bubbles: true}));
}"""


def frames(report: Path) -> list[Image.Image]:
    """Return screenshots of the top of the page at each time."""
    from playwright.sync_api import sync_playwright

    pictures = []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        page = browser.new_page(viewport=SIZE)  # type: ignore[arg-type]
        page.goto(report.resolve().as_uri())
        page.locator("h2").first.evaluate("one => scrollTo(0, one.getBoundingClientRect().top + scrollY - 10)")
        slider = page.locator("input[type=range]").first.element_handle()
        for k in range(round((TO_S - FROM_S) / STEP_S) + 1):
            page.evaluate(SHOW, [slider, FROM_S + k * STEP_S])
            picture = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
            pictures.append(
                picture.resize((WIDTH_PX, WIDTH_PX * picture.height // picture.width), Image.Resampling.LANCZOS)
            )
        browser.close()
    return pictures


def main() -> int:
    """Write the clip. Returns 2 if the page does not exist."""
    report = Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "out" / "demo" / "report.html")
    if not report.is_file():
        print(f"error: file not found: {report}. `make demo` writes out/demo/report.html", file=sys.stderr)
        return 2
    first, *rest = frames(report)
    first.save(FILE, save_all=True, append_images=rest, duration=FRAME_MS, loop=0, quality=60, method=6)
    print(f"{FILE.relative_to(ROOT)}: {1 + len(rest)} pictures, {FILE.stat().st_size / 1e6:.2f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
