"""Drawing of a journal: measures and tempo over time, and a row for each kind of event from each source."""

from itertools import pairwise
from typing import Final

from live.app.pictures.reach_picture import Canvas
from live.clock.ticks import TICK
from live.show.journal.journal_reader import Survey

LEFT, RIGHT, ROW, HEAD, CURVE = 220, 24, 18, 56, 70
"""Pixels: width of names, right margin, row height, space above the first row, height of the tempo curve."""
WIDTH: Final = 1600
INK, FAINT = "#222222", "#dddddd"
COLOURS: Final = ("#1f4e8c", "#b8562b", "#3f7f4f", "#7a4a93", "#8a7a20", "#2b8a94", "#a03060", "#555555")
STEPS: Final = (1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048)


def size_of(survey: Survey) -> tuple[int, int]:
    """Return width and height of the picture [pixels]."""
    return WIDTH, HEAD + CURVE + ROW * (len(survey.events) + 2)


def draw_journal(survey: Survey, canvas: Canvas) -> None:
    """Draw the journal; events on the same pixel are one line."""
    scale = (WIDTH - LEFT - RIGHT) / max(survey.ticks, 1)
    bottom = size_of(survey)[1] - ROW

    def x(tick: int) -> float:
        return LEFT + scale * tick

    name = str(survey.journal.patch.get("name", survey.journal.path.name))
    many = sum(survey.counts.values())
    words = f"{name}: {survey.seconds / 60:.1f} min, {len(survey.measure)} measures, {many} events"
    canvas.text((12, 24), words + (f", {survey.damaged} damaged lines" if survey.damaged else ""), 16, INK)
    for tick, number in _numbered(survey, scale):
        canvas.line((x(tick), HEAD), (x(tick), bottom), FAINT, 1)
        canvas.text((x(tick), HEAD - 6), str(number), 10, INK, "middle")
    canvas.text((LEFT - 8, HEAD - 6), "measure", 10, INK, "end")
    _tempo(survey, canvas, scale)
    sources = sorted({source for source, _ in survey.events})
    for row, (key, ticks) in enumerate(sorted(survey.events.items())):
        y = HEAD + CURVE + ROW * row
        colour = COLOURS[sources.index(key[0]) % len(COLOURS)]
        canvas.text((LEFT - 8, y + 13), f"{key[1]} · {key[0]}  {len(ticks)}"[-40:], 11, colour, "end")
        for place in sorted({round(x(tick)) for tick in ticks}):
            canvas.line((place, y + 3), (place, y + ROW - 3), colour, 1)
    minutes = survey.seconds / 60.0
    step = next((s for s in STEPS if minutes / s <= 12), STEPS[-1])
    for minute in range(0, int(minutes) + 1, step):
        canvas.text((x(round(minute * 60 / TICK)), bottom + 14), f"{minute} min", 10, INK, "middle")


def _numbered(survey: Survey, scale: float) -> list[tuple[int, int]]:
    """Return tick and number of the measures to label, spaced so that labels do not touch."""
    whole = len(survey.measure)
    if not whole:
        return []
    wide = scale * survey.ticks / whole
    step = next((s for s in STEPS if s * wide >= 34), STEPS[-1])
    rows = zip(survey.measure_tick, survey.measure, strict=True)
    return [(tick, number) for tick, number in rows if (number - 1) % step == 0]


def _tempo(survey: Survey, canvas: Canvas, scale: float) -> None:
    tempo = survey.tempo()
    if not tempo:
        return
    low, high = min(bpm for _, bpm in tempo), max(bpm for _, bpm in tempo)
    low, high = low - 2.0, high + 2.0
    foot = HEAD + CURVE - 12
    points = [(LEFT + scale * tick, foot - (bpm - low) / (high - low) * (CURVE - 24)) for tick, bpm in tempo]
    for a, b in pairwise(points):
        canvas.line(a, b, INK, 1.5)
    canvas.text((LEFT - 8, foot), f"{low + 2:.1f} to {high - 2:.1f} bpm", 11, INK, "end")
