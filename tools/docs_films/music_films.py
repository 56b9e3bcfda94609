"""The film of the beat clock: what the tracker hears in music, and the timeline that follows it."""

import csv
import math
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
import numpy.typing as npt

from live.app.offline.beats_report import BeatListener, ManualInputs, TimelineFile
from live.clock.beat_estimate import BeatEstimate
from live.clock.tracking.beat_network import ActivationStream, BeatNetwork
from live.control.audio.analysis import beat_weights
from live.control.audio.music_file import read_music
from tools.docs_films.film_file import FPS, SIZE, Picture
from tools.docs_films.floor_plan import EDGE, FAINT, FLOOR, GROUND, INK, Canvas, mixed
from tools.docs_films.stage_play import ROOT

Float64 = npt.NDArray[np.float64]

MUSIC: Final = ROOT / "patches" / "music" / "first_show.ogg"
BEGIN_S: Final = 27.8
SECONDS: Final = 10.0
GAP: Final = (32.2, 34.4)
"""From where to where the music is silenced [s]."""
FADE_S: Final = 0.03
PIXELS_PER_SECOND: Final = 92.0
NOW: Final = 330.0
"""Where the present is in the picture [pixels]; what is to come is on its right."""
RIGHT: Final = 496.0
"""The scrolling lanes end here."""
WAVE: Final = (40.0, 150.0)
"""Upper and lower edge of the waveform [pixels]."""
HEARD: Final = (168.0, 238.0)
BEATS: Final = (256.0, 330.0)
MUSIC_COLOUR: Final = (126, 170, 214)
HEARD_COLOUR: Final = (120, 208, 160)
BEAT_COLOUR: Final = (255, 170, 60)


@dataclass(frozen=True, slots=True, eq=False)
class Hearing:
    """What was heard of the music, and what became of it."""

    samples: npt.NDArray[np.float32]
    rate: float
    moment: Float64
    """Middle of each frame of the network [s], (F,)."""
    strength: Float64
    """How likely a beat is there, (F,)."""
    beats: list[BeatEstimate]
    time: Float64
    """Ticks of the timeline [s], (T,)."""
    beat: Float64
    phase: Float64
    """Beats into the measure, (T,)."""
    tempo: Float64
    """[bpm], (T,)."""


def hear() -> Hearing:
    """Play the music, with its gap, to tracker and follower as a show would."""
    music = read_music(MUSIC)
    samples = music.samples.mean(axis=1, dtype=np.float32)[: round((BEGIN_S + SECONDS + 1.0) * music.sample_rate)]
    time = np.arange(len(samples)) / music.sample_rate
    loud = np.clip(np.maximum(GAP[0] - time, time - GAP[1]) / FADE_S, 0.0, 1.0)
    samples = (samples * loud).astype(np.float32)
    beats: list[BeatEstimate] = []
    moment, strength = [], []
    stream = ActivationStream(music.sample_rate, BeatNetwork(*beat_weights()))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "timeline.csv"
        with TimelineFile(path) as timeline:
            listener = BeatListener(music.sample_rate, "network", ManualInputs(), timeline)
            at = 0
            while at < len(samples):
                block = samples[at : at + stream.wanted]
                at += len(block)
                beats += listener.feed(block)
                for frame in range(stream.feed(block)):
                    moment.append(float(stream.position[frame]))
                    strength.append(float(stream.beat[frame]))
        with path.open(encoding="ascii") as lines:
            rows = list(csv.DictReader(lines))
    ticks = {key: np.array([float(row[key]) for row in rows]) for key in ("time_s", "beat", "phase", "bpm")}
    return Hearing(
        samples, music.sample_rate, np.array(moment), np.array(strength), beats,
        ticks["time_s"], ticks["beat"], ticks["phase"], ticks["bpm"],
    )  # fmt: skip


def draw_beat_clock() -> list[Picture]:
    """Music scrolls by; the tracker's beats and the timeline's measure lines appear; in a gap the clock goes on."""
    heard = hear()
    return [_draw_moment(heard, BEGIN_S + frame / FPS) for frame in range(round(SECONDS * FPS))]


def _draw_moment(heard: Hearing, now: float) -> Picture:
    canvas = Canvas()
    for top, bottom in (WAVE, HEARD, BEATS):
        canvas.box((0.0, top, RIGHT, bottom), FLOOR)
    _draw_waveform(canvas, heard, now)
    _draw_strength(canvas, heard, now)
    _draw_beats(canvas, heard, now)
    canvas.line(((NOW, WAVE[0] - 12), (NOW, BEATS[1] + 12)), INK, 1.5)
    canvas.polygon(((NOW - 6, WAVE[0] - 20), (NOW + 6, WAVE[0] - 20), (NOW, WAVE[0] - 11)), INK)
    canvas.box((RIGHT, 0.0, float(SIZE[0]), float(SIZE[1])), GROUND)
    _draw_dial(canvas, heard, now)
    return canvas.picture()


def _at(time: float, now: float) -> float:
    return NOW + (time - now) * PIXELS_PER_SECOND


def _draw_waveform(canvas: Canvas, heard: Hearing, now: float) -> None:
    middle, half = (WAVE[0] + WAVE[1]) / 2, (WAVE[1] - WAVE[0]) / 2 - 4
    step = round(heard.rate * 2.0 / PIXELS_PER_SECOND)  # a column every two pixels, always of the same samples
    first = max(0, int((now - NOW / PIXELS_PER_SECOND) * heard.rate / step))
    for column in range(first, int(now * heard.rate / step)):
        piece = np.abs(heard.samples[column * step : (column + 1) * step])
        x, loud = _at((column + 0.5) * step / heard.rate, now), float(piece.max(initial=0.0)) * half
        canvas.line(((x, middle - max(loud, 0.5)), (x, middle + max(loud, 0.5))), MUSIC_COLOUR, 1.3)


def _draw_strength(canvas: Canvas, heard: Hearing, now: float) -> None:
    seen = (heard.moment > now - NOW / PIXELS_PER_SECOND) & (heard.moment <= now)
    x = NOW + (heard.moment[seen] - now) * PIXELS_PER_SECOND
    y = HEARD[1] - 4 - heard.strength[seen] * (HEARD[1] - HEARD[0] - 12)
    if len(x) > 1:
        area = [(float(x[0]), HEARD[1] - 3), *zip(x.tolist(), y.tolist(), strict=True), (float(x[-1]), HEARD[1] - 3)]
        canvas.polygon(area, mixed(HEARD_COLOUR, FLOOR, 0.6))
        canvas.line(np.stack([x, y], axis=1), HEARD_COLOUR, 1.6)


def _draw_beats(canvas: Canvas, heard: Hearing, now: float) -> None:
    """Draw beats as the timeline has them, those to come as it expects them now, and what the tracker said."""
    tick = int(np.searchsorted(heard.time, now, side="right")) - 1
    beat, phase, tempo = heard.beat[tick], heard.phase[tick], heard.tempo[tick]
    past = np.arange(math.ceil(heard.beat[0]), math.floor(beat) + 1)
    times = [float(np.interp(number, heard.beat, heard.time)) for number in past]
    times += [now + (math.floor(beat) + k - beat) * 60.0 / tempo for k in range(1, 6)]
    first = round(beat - phase)  # of this measure
    for number, time in zip([*past, *range(math.floor(beat) + 1, math.floor(beat) + 6)], times, strict=True):
        x, line = _at(time, now), (int(number) - first) % 4 == 0
        colour = INK if time <= now else mixed(INK, FLOOR, 0.5)
        if 0.0 <= x <= RIGHT:
            canvas.line(((x, BEATS[0] + (4 if line else 36)), (x, BEATS[1] - 4)), colour, 3.0 if line else 1.5)
            if line:
                canvas.line(((x, WAVE[0]), (x, HEARD[1])), mixed(colour, FLOOR, 0.72), 1.0)
    for said in heard.beats:
        x = _at(said.position, now)
        if said.fed <= now and 0.0 <= x <= RIGHT:
            canvas.disc((x, BEATS[0] + 20), 6.5 if said.beat == 0 else 4.5, BEAT_COLOUR)


def _draw_dial(canvas: Canvas, heard: Hearing, now: float) -> None:
    """Draw the phase in the measure as a hand that goes round, and the tempo."""
    middle, radius = ((RIGHT + SIZE[0]) / 2 + 4, 150.0), 54.0
    tempo = float(np.interp(now, heard.time, heard.tempo))
    tick = int(np.searchsorted(heard.time, now, side="right")) - 1
    turn = (heard.phase[tick] + (now - heard.time[tick]) * tempo / 60.0) / 4.0
    canvas.disc(middle, radius, FLOOR, EDGE)
    for quarter in range(4):
        angle = quarter * math.pi / 2
        at = (middle[0] + radius * math.sin(angle), middle[1] - radius * math.cos(angle))
        lit = 1.0 - min(1.0, ((turn * 4.0 - quarter) % 4.0) * 1.6)
        canvas.disc(at, 9.0 if quarter == 0 else 6.5, mixed(EDGE, INK, max(0.0, lit)))
    hand = (
        middle[0] + 0.8 * radius * math.sin(2 * math.pi * turn),
        middle[1] - 0.8 * radius * math.cos(2 * math.pi * turn),
    )
    canvas.line((middle, hand), INK, 3.0)
    canvas.disc(middle, 4.0, INK)
    canvas.text((middle[0], 262.0), f"{tempo:.1f}", INK, 30.0, "mm")
    canvas.text((middle[0], 286.0), "bpm", FAINT, 14.0, "mm")
