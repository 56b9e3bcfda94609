"""Letters of any size: the signed distance to each letter's outline in one texture (Green 2007, Improved alpha-tested
magnification for vector textures and special effects).

Letters are made by a thread when a text first needs them, some milliseconds each; until then they are not drawn.
"""

import threading
import unicodedata
from collections import deque
from collections.abc import Mapping
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFont

from live.base.arrays import Float32
from live.render.lettering.glyph_atlas import plain_letter

EM: Final = 72
"""Texels of an em."""
SPREAD: Final = 9
"""Distance from the outline that the field holds [texels]."""
CELL: Final = 112
"""Side of a letter's cell [texels]."""
COLUMNS: Final = 16
"""Cells in a row, and rows, of the texture."""
_FINER: Final = 4
"""Letters are drawn at this many times the field's resolution."""
_NO_GLYPH: Final = "\uffff"

Field = npt.NDArray[np.uint8]
_Key = tuple[str, str]
"""Name of the font, and letter."""


class LetterField:
    """The letters that have been asked for: their cells, widths and fields. Thread: one; another one makes fields.

    `blocking`: `request` returns when all letters are made, as for an offline film.
    """

    def __init__(self, fonts: Mapping[str, str], *, blocking: bool = False) -> None:
        """`fonts`: files of fonts by name; unknown names mean the usual font."""
        self.missing: list[str] = []
        """Messages about letters that a font lacks, and fonts that cannot be read; each once."""
        self._files, self._blocking = fonts, blocking
        self._fonts: dict[str, ImageFont.FreeTypeFont | ImageFont.ImageFont] = {}
        self._cells: dict[_Key, int] = {}
        self._plain: dict[_Key, str] = {}
        self._base: dict[_Key, str] = {}  # the letter whose width a composed one has
        self._jobs: deque[_Key] = deque()
        self._done: deque[tuple[int, Field]] = deque()
        self._condition = threading.Condition()
        self._closing = False
        self._thread: threading.Thread | None = None

    def request(self, text: str, font: str) -> None:
        """Have the letters of a text made that are not there yet."""
        for letter in "".join(self._drawable(each, font) for each in text.replace("|", " ")):
            key = font, letter
            if letter == " " or key in self._cells:
                continue
            if len(self._cells) >= COLUMNS * COLUMNS:
                self._tell("there are too many different letters; some are not shown")
                continue
            self._cells[key] = len(self._cells)
            if self._blocking:
                self._done.append((self._cells[key], self._bake(key)))
                continue
            with self._condition:
                self._jobs.append(key)
                self._condition.notify()
            if self._thread is None:
                self._thread = threading.Thread(target=self._run, name="letters", daemon=True)
                self._thread.start()

    def clear(self) -> None:
        """Forget all letters that were asked for; not while a thread makes any."""
        self._cells.clear()
        self._done.clear()

    def made(self) -> tuple[int, Field] | None:
        """Return the cell and field (112, 112) of a letter that was made since the last call, or None."""
        return self._done.popleft() if self._done else None

    def close(self) -> None:
        """End the thread."""
        with self._condition:
            self._closing = True
            self._condition.notify()
        if self._thread is not None:
            self._thread.join(timeout=2.0)

    def lay_out(self, text: str, font: str, tracking: float) -> tuple[Float32, float, float]:
        """Return the letters of a text around its middle, their half width and half height [ems].

        Letters (N, 6): x and y of the cell's lower left corner [ems, y up], u and v of its upper left texel, order 0
        to 1, and x of the letter's middle as a share of the width, 0 to 1. Letters that the font lacks take no room.
        """
        face = self._font(font)
        cap = self.cap_height(font)
        rows: list[tuple[float, ...]] = []
        lines = ["".join(self._drawable(letter, font) for letter in line.strip()) for line in text.split("|")]
        bases = ["".join(self._base.get((font, letter), letter) for letter in line) for line in lines]
        pitch = 1.6 * cap
        widths = [self._line_width(line, face, tracking) for line in bases]
        widest, count = max(widths, default=0.0), sum(len(line.replace(" ", "")) for line in lines)
        ascent = face.getmetrics()[0] / EM if isinstance(face, ImageFont.FreeTypeFont) else 0.8
        for number, (line, width) in enumerate(zip(lines, widths, strict=True)):
            x = -0.5 * width
            baseline = 0.5 * pitch * (len(lines) - 1) - 0.5 * cap - number * pitch
            for place, letter in enumerate(line):
                if letter != " ":
                    cell = self._cells.get((font, letter))
                    advance = face.getlength(bases[number][place]) / EM
                    if cell is not None:
                        left, top = x - SPREAD / EM, baseline + ascent + SPREAD / EM
                        share = (x + 0.5 * advance + 0.5 * widest) / max(widest, 1e-6)
                        u, v = cell % COLUMNS * CELL, cell // COLUMNS * CELL
                        rows.append((left, top - CELL / EM, u, v, len(rows) / max(count - 1, 1), share))
                x += self._advance(bases[number], place, face, tracking)
        letters = np.array(rows, np.float32).reshape(-1, 6)
        return letters, 0.5 * widest, 0.5 * (pitch * (len(lines) - 1) + cap)

    def cap_height(self, font: str) -> float:
        """Return the height of a capital letter [ems]."""
        box = self._font(font).getbbox("H")
        return max(box[3] - box[1], 1.0) / EM

    def _line_width(self, line: str, face: ImageFont.FreeTypeFont | ImageFont.ImageFont, tracking: float) -> float:
        width = sum(self._advance(line, place, face, tracking) for place in range(len(line)))
        return max(width - tracking, 0.0) if line else 0.0

    @staticmethod
    def _advance(line: str, place: int, face: ImageFont.FreeTypeFont | ImageFont.ImageFont, tracking: float) -> float:
        """Return how far a letter moves the pen, with the kerning to the next one [ems]."""
        pair = line[place : place + 2]
        own = face.getlength(pair) - face.getlength(pair[1]) if len(pair) == 2 else face.getlength(pair)
        return float(own) / EM + tracking

    def _font(self, font: str) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
        if font not in self._fonts:
            if font and font not in self._files:
                self._tell(f"the font {font} is read when the show starts again; the usual one is drawn")
            try:
                self._fonts[font] = read_font(self._files.get(font, ""), EM)
            except (OSError, ValueError):
                self._tell(f"the font {Path(self._files[font]).name} cannot be read; the usual one is drawn")
                self._fonts[font] = read_font("", EM)
        return self._fonts[font]

    def _drawable(self, letter: str, font: str) -> str:
        """Return the letter, without its accent if the font lacks it, or nothing if it lacks both."""
        key = font, letter
        if key not in self._plain:
            face = self._font(font)
            parts = composition(letter)
            if not _has(face, letter) and parts is not None and _has(face, parts[0] + parts[1][0]):
                self._plain[key], self._base[key] = letter, parts[0]
                return letter
            plain = next((each for each in (letter, plain_letter(letter)) if each and _has(face, each)), "")
            if not plain and letter.isprintable():
                self._tell(f"the font lacks {letter!r} (U+{ord(letter):04X}); it is not shown")
            self._plain[key] = plain
        return self._plain[key]

    def _tell(self, words: str) -> None:
        if words not in self.missing and len(self.missing) < 32:
            self.missing.append(words)

    def _run(self) -> None:
        while True:
            with self._condition:
                self._condition.wait_for(lambda: self._closing or self._jobs)
                if self._closing:
                    return
                key = self._jobs.popleft()
            try:
                self._done.append((self._cells[key], self._bake(key)))
            except Exception as error:  # a letter is lost, not the thread
                self._tell(f"a letter cannot be drawn: {error}")

    def _bake(self, key: _Key) -> Field:
        try:
            return bake_field(key[1], read_font(self._files.get(key[0], ""), _FINER * EM))
        except (OSError, ValueError):
            return bake_field(key[1], read_font("", _FINER * EM))


def read_font(file: str, size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """Return a font from its file, or the usual one; OSError or ValueError if it cannot be read."""
    if not file:
        return ImageFont.load_default(size=size)
    return ImageFont.truetype(file, size, layout_engine=ImageFont.Layout.BASIC)


_ACCENTS: Final = {
    "\u0300": ("`", 1.0), "\u0301": ("´", 1.0), "\u0302": ("^", 0.62), "\u0303": ("~", 0.62), "\u0308": ("..", 0.9),
    "\u030a": ("°", 0.8), "\u030c": ("^", -0.62), "\u0327": (",", 0.9),
}  # fmt: skip
"""Combining marks, and the signs that are drawn for them where a font has no accented letters, with their sizes; below
0: upside down."""
_BELOW: Final = "\u0327"
_DOTTED: Final = "ij"
_ACCENT_GAP: Final = 0.05
"""Space between a letter and its accent [ems]."""


def composition(letter: str) -> tuple[str, str, float, bool] | None:
    """Return the letter without its accent, the accent's sign, its size and whether it lies below; None if the letter
    has no accent or several, or one that cannot be drawn."""
    parts = unicodedata.normalize("NFD", letter)
    if len(parts) != 2 or parts[1] not in _ACCENTS:
        return None
    sign, size = _ACCENTS[parts[1]]
    return parts[0], sign, size, parts[1] == _BELOW


def _drawn(text: str, font: ImageFont.FreeTypeFont | ImageFont.ImageFont) -> Image.Image:
    """Return a letter drawn into a cell, at `_FINER` times the field's resolution."""
    image = Image.new("L", (CELL * _FINER, CELL * _FINER))
    ImageDraw.Draw(image).text((SPREAD * _FINER, SPREAD * _FINER), text, fill=255, font=font)
    return image


def _composed(
    base: str, sign: str, size: float, below: bool, font: ImageFont.FreeTypeFont | ImageFont.ImageFont
) -> Image.Image:
    """Return a letter with an accent, drawn as two signs into a cell."""
    image, em = _drawn(base, font), EM * _FINER
    if base in _DOTTED and not below:  # the accent stands in the place of the dot
        top = _drawn("x", font).getbbox()
        image.paste(0, (0, 0, image.width, top[1] - 1 if top else 0))
    accent = _drawn(sign, font)
    ink, letter = accent.getbbox(), image.getbbox()
    if ink is None or letter is None:
        return image
    accent = accent.crop(ink)
    if size < 0.0:
        accent = accent.transpose(Image.Transpose.FLIP_TOP_BOTTOM)
    accent = accent.resize((max(round(accent.width * abs(size)), 1), max(round(accent.height * abs(size)), 1)))
    gap = round(_ACCENT_GAP * em)
    x = (letter[0] + letter[2] - accent.width) // 2
    y = letter[3] - gap // 2 if below else max(letter[1] - gap - accent.height, 0)
    image.paste(255, (x, y), accent)
    return image


def _has(face: ImageFont.FreeTypeFont | ImageFont.ImageFont, text: str, finer: int = 1) -> bool:
    """Whether the font, `finer` times an em in size, has all letters of a text and they fit into their cells."""
    missing = face.getmask(_NO_GLYPH)
    for letter in text:
        if letter == " ":
            continue
        mask = face.getmask(letter)
        if not letter.isprintable() or (mask.size == missing.size and bytes(mask) == bytes(missing)):
            return False
        box = face.getbbox(letter)
        room = (CELL - 2 * SPREAD) * finer
        if box[2] > room or box[3] > room or box[0] < -SPREAD * finer:
            return False
    return True


def bake_field(letter: str, font: ImageFont.FreeTypeFont | ImageFont.ImageFont) -> Field:
    """Return the distance field of a letter, (112, 112), top row first: 128 at the outline, more inside; the whole
    range is `SPREAD` texels. `font` has the size of `_FINER` ems."""
    from scipy.ndimage import distance_transform_edt

    edge = SPREAD * _FINER
    parts = None if _has(font, letter, _FINER) else composition(letter)
    image = _drawn(letter, font) if parts is None else _composed(*parts, font)
    box = image.getbbox()
    field = np.zeros((CELL, CELL), np.uint8)
    if box is None:
        return field
    left, top = (max(low - edge, 0) // _FINER for low in box[:2])
    right, bottom = (min(-(-(high + edge) // _FINER), CELL) for high in box[2:])
    inside = np.asarray(image)[top * _FINER : bottom * _FINER, left * _FINER : right * _FINER] >= 128
    distance = distance_transform_edt(inside) - distance_transform_edt(~inside)
    small = distance.reshape(bottom - top, _FINER, right - left, _FINER).mean(axis=(1, 3)) / _FINER
    field[top:bottom, left:right] = np.clip(np.rint(127.5 + 127.5 * small / SPREAD), 0, 255)
    return field
