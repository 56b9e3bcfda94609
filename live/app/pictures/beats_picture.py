"""A picture of what a beat tracker thought: tempo, half beat, measure line and metre over time (`--explain`).

Brighter is more likely. The line in the tempo lane is the tempo that was taken. The rows of the measure lane say by how
many beats later measures could begin than where the tracker has them. Ticks below are its beats, long ones its ones.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float64
from live.base.errors import PersonError
from live.clock.bar_pointer.metre import MAX_METRE, METRES
from live.clock.beat_estimate import BeatEstimate
from live.clock.tracking.beat_tracker import BeatTracker

if TYPE_CHECKING:
    from PIL import Image, ImageDraw

COLUMN_S: Final = 0.1
"""Seconds between two columns of the record."""
TEMPI: Final = np.geomspace(240.0, 40.0, 96)
"""Tempo of each row of the tempo lane [bpm], fastest above."""
LINES: Final = MAX_METRE
MAX_WIDTH: Final = 2400
PIXELS_PER_SECOND: Final = 24
LEFT, GAP, TICKS = 110, 16, 26
_LANES: Final = (
    ("tempo", len(TEMPI), 2),
    ("beat", 4, 14),
    ("measure", LINES, 14),
    ("metre", len(METRES), 14),
    ("sure", 1, 40),
)
"""Name, rows, and pixels of a row of each lane."""
_INK, _PAPER, _TAKEN = (225, 225, 225), (16, 18, 24), (255, 170, 60)


class HypothesesRecord:
    """What a tracker thinks, a column every COLUMN_S of sound."""

    def __init__(self, tracker: BeatTracker) -> None:
        self._tracker = tracker
        self._next = 0.0
        self._columns: dict[str, list[Float64]] = {name: [] for name, _, _ in _LANES}
        self._tempo: list[float] = []
        self._offsets: list[float] = []

    def update(self) -> None:
        """Add a column, if it is time."""
        if self._tracker.position < self._next:
            return
        self._next += COLUMN_S
        pointer = self._tracker.pointer
        bpm, share = pointer.tempo_shares()
        rows = np.argmin(np.abs(np.log(bpm)[:, None] - np.log(TEMPI)[None]), axis=1)
        self._columns["tempo"].append(np.bincount(rows, weights=share, minlength=len(TEMPI)).astype(np.float64))
        self._columns["beat"].append(np.array(pointer.phase_strength))
        lines = np.zeros(LINES)
        found = pointer.line_evidence.shares()
        lines[: found.size] = found
        self._columns["measure"].append(lines)
        self._columns["metre"].append(pointer.metre_shares())
        self._columns["sure"].append(np.array([pointer.confidence]))
        self._tempo.append(pointer.tempo)
        self._offsets.append(pointer.beat_offset)

    def lane(self, name: str) -> Float64:
        """Return a lane's values, (rows, columns), 0 to 1."""
        return np.array(self._columns[name]).T

    @property
    def tempo(self) -> Float64:
        """The tempo that was taken [bpm], 0 for none, (columns,)."""
        return np.array(self._tempo)

    @property
    def offsets(self) -> Float64:
        """How much later than the grid of the tempo lane the beats were taken to be [beats], (columns,)."""
        return np.array(self._offsets)


def write_picture(path: Path, record: HypothesesRecord, beats: Sequence[BeatEstimate]) -> None:
    """Write the picture as PNG; PersonError if it cannot be written."""
    try:
        draw_picture(record, beats).save(path, format="PNG")
    except OSError as error:
        raise PersonError(f"--explain {path} cannot be written ({error.strerror or error})") from None


def draw_picture(record: HypothesesRecord, beats: Sequence[BeatEstimate]) -> "Image.Image":
    """Return the picture of a record with the tracker's beats."""
    from PIL import Image, ImageDraw

    seconds = record.tempo.size * COLUMN_S
    width = min(max(round(seconds * PIXELS_PER_SECOND), 200), MAX_WIDTH)
    height = GAP + sum(rows * size + GAP for _, rows, size in _LANES) + TICKS
    picture = Image.new("RGB", (LEFT + width, height), _PAPER)
    draw = ImageDraw.Draw(picture)
    top = GAP
    for name, rows, size in _LANES:
        picture.paste(_heat(record.lane(name), width, rows * size), (LEFT, top))
        for row, word in enumerate(_words(name)):
            if word:
                draw.text((8, top + (row + 0.5) * size), word, fill=_INK, anchor="lm")
        if name == "tempo":
            _draw_tempo(draw, record.tempo, width, top, size)
        if name == "beat":
            _draw_offsets(draw, record.offsets * rows, width, top, size)
        top += rows * size + GAP
    for beat in beats:
        x = LEFT + beat.position / max(seconds, 1e-9) * width
        draw.line((x, top, x, top + (TICKS - 8 if beat.beat == 0 else 6)), fill=_TAKEN if beat.beat == 0 else _INK)
    for second in range(0, int(seconds), 5 if seconds < 60 else 30):
        draw.text((LEFT + second / seconds * width, height - 4), f"{second} s", fill=(120, 120, 120), anchor="ls")
    return picture


def _words(name: str) -> list[str]:
    """Return the words beside the rows of a lane."""
    if name == "tempo":
        marks = {int(np.argmin(np.abs(TEMPI - bpm))): f"{bpm} bpm" for bpm in (60, 90, 120, 180)}
        return [marks.get(row, "") for row in range(len(TEMPI))]
    if name == "beat":
        return ["on the beat", "a quarter late", "off-beat", "three quarters"]
    if name == "measure":
        return ["the one", *(f"{later} later" for later in range(1, LINES))]
    return [f"of {beats}" for beats in METRES] if name == "metre" else ["confidence"]


def _heat(values: Float64, width: int, height: int) -> "Image.Image":
    """Return values (rows, columns) of 0 to 1 as a picture; small shares stay visible by a square root."""
    from PIL import Image

    shade: npt.NDArray[np.float64] = np.sqrt(np.clip(values, 0.0, 1.0))[..., None]
    low, high = np.array((28.0, 32.0, 46.0)), np.array((120.0, 215.0, 255.0))
    colour = (low + shade * (high - low)).astype(np.uint8)
    return Image.fromarray(colour).resize((width, height), Image.Resampling.NEAREST)


def _draw_offsets(draw: "ImageDraw.ImageDraw", rows: Float64, width: int, top: int, size: int) -> None:
    """Underline the rows, (columns,), of the places that were taken for the beat."""
    x = LEFT + np.arange(rows.size + 1) / max(rows.size, 1) * width
    for k, row in enumerate(rows.tolist()):
        low = top + (row + 1.0) * size - 2
        draw.line((x[k], low, x[k + 1], low), fill=_TAKEN, width=2)


def _draw_tempo(draw: "ImageDraw.ImageDraw", tempo: Float64, width: int, top: int, size: int) -> None:
    """Draw the tempo that was taken; it breaks where it jumps."""
    row = np.interp(np.log(np.maximum(tempo, 1.0)), np.log(TEMPI[::-1]), np.arange(len(TEMPI))[::-1])
    x = LEFT + (np.arange(tempo.size) + 0.5) / max(tempo.size, 1) * width
    for k in range(1, tempo.size):
        if tempo[k] > 0.0 and abs(row[k] - row[k - 1]) < 8:
            draw.line((x[k - 1], top + row[k - 1] * size, x[k], top + row[k] * size), fill=_TAKEN, width=2)
