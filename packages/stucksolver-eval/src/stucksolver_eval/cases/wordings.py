"""Drives one case once with each of several sentences of a passenger, and draws the outcomes."""

from __future__ import annotations

import contextlib
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

from stucksolver.optional_dependencies import can_plot
from stucksolver.scene import Interpretation
from stucksolver.solver import EventKind
from stucksolver_eval.cases.case import CASES, Case
from stucksolver_eval.cases.case_runner import CaseResult
from stucksolver_eval.cases.figure import GRAY, INK, PAPER

DRIVE_S = 66.0
"""Duration of a drive (s). A vehicle that stays behind the cyclists needs it to the end of the shipped map's street."""
TEXT_W = 470
READ_W = 290
CHART_W = 420
END_W = 300
"""Widths of the four columns. All sizes of the picture are in pixels."""
ROW_H = 58
HEAD_H = 66
MARGIN = 16
REACH_M = 40.0
"""Length of the lane in the chart, behind and ahead of the first cyclist (m). Ours."""
ASCII = 0x7F
"""Highest code point that Pillow's own font can draw."""
LATIN = 0x2000
"""Lowest code point that needs a font with Chinese characters."""
LINE = (214, 217, 222)
PASSED, STAYED, HIT = (24, 128, 74), (36, 92, 170), (190, 40, 40)


@dataclass(frozen=True)
class Wording:
    """A sentence. `meant` is the intent from its author, or None if unknown."""

    text: str
    meant: str | None = None


def worded(wordings: Sequence[Wording]) -> tuple[Case, ...]:
    """Return one case of the cyclists for each sentence."""
    case = next(item for item in CASES if item.words is not None)
    assert case.words is not None
    at_s = case.words[0]
    return tuple(
        replace(case, name=f"wording-{k}", title=wording.text, words=(at_s, wording.text), drive_s=DRIVE_S)
        for k, wording in enumerate(wordings, 1)
    )


def read_as(result: CaseResult) -> Interpretation | None:
    """Return the interpretation of the sentence, or None if there is none."""
    return next((event.reading for event in result.events if event.reading is not None), None)


def passed_s(result: CaseResult) -> float | None:
    """Return the time from the sentence until the ego stays ahead of all cyclists (s); None if it never does."""
    assert result.case.words is not None
    ahead_from: float | None = None
    for moment in result.moments:
        ahead = moment.ego_m > max(moment.others_m)
        ahead_from = (ahead_from if ahead_from is not None else moment.time_s) if ahead else None
    return None if ahead_from is None else ahead_from - result.case.words[0]


def outcome(result: CaseResult) -> str:
    """Return the outcome in a few words."""
    after_s = passed_s(result)
    touched = f", {result.collisions} collisions" if result.collisions else ""
    if after_s is not None:
        return f"past both {after_s:.0f} s later{touched}"
    done = next((e.text.replace("_", " ") + ", " for e in result.events if e.kind is EventKind.STARTED), "")
    return f"{done}stays behind for {result.moments[-1].time_s - (result.case.words or (0.0,))[0]:.0f} s{touched}"


def draw_wordings(wordings: Sequence[Wording], results: Sequence[CaseResult], path: Path) -> None:
    """Write a PNG with one row per sentence. Raises `OSError`."""
    width = TEXT_W + READ_W + CHART_W + END_W + 2 * MARGIN
    canvas = Image.new("RGB", (width, HEAD_H + ROW_H * len(results) + MARGIN), PAPER)
    draw = ImageDraw.Draw(canvas)
    left, columns = (
        MARGIN,
        ("What the passenger says", "Read as", "Position relative to the cyclists", "What the vehicle does"),
    )
    for title, size in zip(columns, (TEXT_W, READ_W, CHART_W, END_W), strict=True):
        draw.text((left, MARGIN), title, INK, font=ImageFont.load_default(17))
        left += size
    note = f"{REACH_M:.0f} m behind the first (bottom) to {REACH_M:.0f} m ahead (top), {DRIVE_S:.0f} s; dot: words"
    draw.text((MARGIN + TEXT_W + READ_W, MARGIN + 24), note, GRAY, font=ImageFont.load_default(12))
    for k, (wording, result) in enumerate(zip(wordings, results, strict=True)):
        _row(draw, HEAD_H + k * ROW_H, wording, result)
    canvas.save(path, optimize=True)


def _row(draw: ImageDraw.ImageDraw, top: int, wording: Wording, result: CaseResult) -> None:
    draw.line((MARGIN, top, MARGIN + TEXT_W + READ_W + CHART_W + END_W, top), LINE)
    for i, line in enumerate(textwrap.wrap(wording.text, 58)[:2]):
        draw.text((MARGIN, top + 9 + 21 * i), line, INK, font=_font(wording.text, 16))
    left = MARGIN + TEXT_W
    reading = read_as(result)
    draw.text(
        (left, top + 9), "nothing" if reading is None else reading.description, INK, font=ImageFont.load_default(16)
    )
    if wording.meant is not None:
        draw.text((left, top + 31), f"meant: {wording.meant.replace('_', ' ')}", GRAY, font=ImageFont.load_default(13))
    _chart(draw, left + READ_W, top, result)
    color = HIT if result.collisions else PASSED if passed_s(result) is not None else STAYED
    at = left + READ_W + CHART_W
    draw.text((at, top + 9), outcome(result), color, font=ImageFont.load_default(16))
    last = next((e.text for e in reversed(result.events) if e.kind is EventKind.GUIDANCE_ENDED), "")
    draw.text((at, top + 31), last.rpartition('": ')[2][:44], GRAY, font=ImageFont.load_default(13))


def _chart(draw: ImageDraw.ImageDraw, left: int, top: int, result: CaseResult) -> None:
    """Draw the ego's position relative to the first cyclist over time; the gray band shows the cyclists."""

    def chart_point(time_s: float, ahead_m: float) -> tuple[float, float]:
        inside = min(max(ahead_m, -REACH_M), REACH_M)
        return left + (CHART_W - 24) * time_s / DRIVE_S, top + ROW_H / 2 - inside / REACH_M * (ROW_H / 2 - 5)

    firsts = [max(moment.others_m) for moment in result.moments]
    group_m = max(first - min(m.others_m) for m, first in zip(result.moments, firsts, strict=True))
    draw.rectangle((*chart_point(0.0, 0.0), *chart_point(DRIVE_S, -group_m)), (226, 229, 234))
    way = [chart_point(m.time_s, m.ego_m - first) for m, first in zip(result.moments, firsts, strict=True)]
    draw.line(way, PASSED if passed_s(result) is not None else STAYED, 2)
    said_s = (result.case.words or (0.0,))[0]
    x, y = min(way, key=lambda item: abs(item[0] - chart_point(said_s, 0.0)[0]))
    draw.ellipse((x - 4, y - 4, x + 4, y + 4), INK)


def _font(text: str, size: int) -> ImageFont.ImageFont | ImageFont.FreeTypeFont:
    """Return a font for the text: Pillow's own has only ASCII, matplotlib's has accents, a system font may have CJK."""
    highest = max(map(ord, text), default=0)
    wide = ("NotoSansCJK-Regular.ttc", "wqy-zenhei.ttc", "DroidSansFallbackFull.ttf")
    names = wide if highest > LATIN else _accented() if highest > ASCII else ()
    for name in names:
        # The font is not installed; the loop tries the next one.
        with contextlib.suppress(OSError):
            return ImageFont.truetype(name, size)
    return ImageFont.load_default(size)


def _accented() -> tuple[str, ...]:
    if not can_plot():
        return ()
    from matplotlib import get_data_path

    return (str(Path(get_data_path(), "fonts", "ttf", "DejaVuSans.ttf")),)
