"""Contact sheet: pictures of a show in rows with measure, section, cue and steps under each."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFont

from live.app.offline.sheet_moments import SheetMoment
from live.render.lettering.glyph_atlas import without_accents

Picture = npt.NDArray[np.uint8]
Colour = tuple[int, int, int]

MAX_HEIGHT: Final = 30_000
"""Maximum height of a sheet [pixels]: few programs open larger pictures."""


@dataclass(frozen=True, slots=True)
class Paper:
    """The colours of a sheet, sRGB."""

    ground: Colour
    ink: Colour
    faint: Colour
    mark: Colour


DARK: Final = Paper((17, 18, 21), (236, 233, 226), (134, 134, 142), (226, 166, 90))
LIGHT: Final = Paper((247, 245, 240), (30, 29, 27), (128, 124, 117), (178, 96, 28))


class Sheet:
    """Arranges pictures of one size (width, height) [pixels] in columns."""

    def __init__(self, size: tuple[int, int], columns: int, paper: Paper) -> None:
        self._size, self._columns, self._paper = size, columns, paper
        self._unit = unit = size[0] / 40.0
        self._gap, self._margin, self._words = round(2.2 * unit), round(4.0 * unit), round(6.4 * unit)
        self._head = round(10.0 * unit)
        self._fonts = {
            name: ImageFont.load_default(size=max(round(share * unit), 6))
            for name, share in (("title", 3.2), ("number", 2.1), ("plain", 1.4), ("small", 1.25))
        }

    def draw(self, pictures: list[tuple[Picture, SheetMoment]], title: str, subtitle: str) -> Image.Image:
        """Draw the sheet; `subtitle`: small text next to the title."""
        width, height = self.size_for(len(pictures))
        image = Image.new("RGB", (width, height), self._paper.ground)
        pen = ImageDraw.Draw(image)
        baseline = round(self._margin + 3.0 * self._unit)
        room = width - 2 * self._margin - pen.textlength(subtitle, self._fonts["plain"]) - 2.0 * self._unit
        title = self._shorten(pen, title, room, "title")
        pen.text((self._margin, baseline), title, self._paper.ink, self._fonts["title"], anchor="ls")
        pen.text((width - self._margin, baseline), subtitle, self._paper.faint, self._fonts["plain"], anchor="rs")
        last: SheetMoment | None = None
        for number, (picture, taken) in enumerate(pictures):
            row, column = divmod(number, self._columns)
            x = self._margin + column * (self._size[0] + self._gap)
            y = self._head + row * (self._size[1] + self._words + self._gap)
            image.paste(Image.fromarray(picture), (x, y))
            self._draw_caption(pen, (x, y + self._size[1]), taken, last)
            last = taken
        return image

    def size_for(self, count: int) -> tuple[int, int]:
        """Return width and height [pixels] of a sheet of `count` pictures."""
        rows = -(-count // self._columns)
        columns = min(self._columns, max(count, 1))
        width = 2 * self._margin + columns * (self._size[0] + self._gap) - self._gap
        return width, self._head + rows * (self._size[1] + self._words + self._gap) - self._gap + self._margin

    def _draw_caption(
        self, pen: ImageDraw.ImageDraw, corner: tuple[int, int], taken: SheetMoment, last: SheetMoment | None
    ) -> None:
        """Draw the text under a picture with this lower left corner."""
        u, paper, fonts = self._unit, self._paper, self._fonts
        left, right, top = corner[0], corner[0] + self._size[0], corner[1]
        fresh = last is None or last.section != taken.section
        if taken.section is not None and fresh:  # a section begins: a line above its first picture
            over = top - self._size[1] - round(0.8 * u)
            pen.rectangle((left, over, right - 1, over + max(round(0.2 * u), 1)), fill=paper.mark)
        line = top + round(2.8 * u)
        clock = f"{int(taken.seconds) // 60}:{int(taken.seconds) % 60:02d}   {taken.tempo:.0f} bpm   beat {taken.beat}"
        pen.text((right, line), clock, paper.faint, fonts["small"], anchor="rs")
        room = right - pen.textlength(clock, fonts["small"]) - u
        number = str(taken.measure)
        pen.text((left, line), number, paper.ink, fonts["number"], anchor="ls")
        x = left + pen.textlength(number, fonts["number"]) + u
        if taken.section is not None:
            words = self._shorten(pen, taken.section, room - x, "plain")
            pen.text((x, line), words, paper.ink if fresh else paper.faint, fonts["plain"], anchor="ls")
            x += pen.textlength(words, fonts["plain"]) + u
        if taken.cue is not None and (last is None or last.cue != taken.cue) and room - x > 3.0 * u:
            pen.polygon([(x, line - u), (x, line), (x + 0.8 * u, line - 0.5 * u)], fill=paper.mark)
            words = self._shorten(pen, taken.cue, room - x - 1.4 * u, "plain")
            pen.text((x + 1.4 * u, line), words, paper.mark, fonts["plain"], anchor="ls")
        self._draw_steps(pen, (left, right), line + round(2.4 * u), taken)

    def _draw_steps(self, pen: ImageDraw.ImageDraw, across: tuple[int, int], line: int, taken: SheetMoment) -> None:
        u, x = self._unit, float(across[0])
        each = (across[1] - x) / max(len(taken.steps), 1)
        radius, alone = 0.38 * u, len(taken.steps) == 1
        for colour, group, step in taken.steps:
            middle = line - 0.42 * u
            pen.ellipse((x, middle - radius, x + 2.0 * radius, middle + radius), fill=to_srgb(colour))
            words = step if alone else f"{group}: {step}"
            start = x + 1.3 * u
            used = self._shorten(pen, words, x + each - start - 0.6 * u, "small")
            pen.text((start, line), used, self._paper.ink, self._fonts["small"], anchor="ls")
            x += each

    def _shorten(self, pen: ImageDraw.ImageDraw, words: str, room: float, font: str) -> str:
        """Return the text, shortened to fit `room` [pixels]."""
        words = without_accents(words)
        if pen.textlength(words, self._fonts[font]) <= room:
            return words
        while words and pen.textlength(words + "…", self._fonts[font]) > room:
            words = words[:-1]
        return words.rstrip() + "…" if words else ""


def to_srgb(colour: tuple[float, float, float]) -> Colour:
    """Convert a linear colour to sRGB (IEC 61966-2-1)."""
    light = np.clip(np.array(colour), 0.0, 1.0)
    value = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    red, green, blue = (int(one) for one in np.round(255.0 * value))
    return red, green, blue
