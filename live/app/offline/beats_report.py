"""Beat tracking of a file for `live beats`, with output as table, JSON, CSV or sound with clicks.

The follower's timeline can be written 64 times a second as CSV.
"""

import contextlib
import json
import wave
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Final, TextIO

import numpy as np

from live.app.pictures.beats_picture import HypothesesRecord
from live.base.errors import PersonError
from live.clock.bar_pointer.state_space import BarPointerModel
from live.clock.beat_estimate import BeatEstimate, Samples
from live.clock.follower.timeline_follower import TimelineFollower
from live.clock.silence import PauseDetector, SoundState
from live.clock.tracking.beat_tracker import BeatTracker
from live.control.audio.analysis import TrackerName, make_tracker
from live.control.audio.music_file import Music

BLOCK = 512


@dataclass(frozen=True, slots=True)
class ManualInputs:
    """Manual inputs and their times [s]; None: not given."""

    tap_bpm: float | None = None
    tap_at: float | None = None
    one_at: float | None = None


class BeatListener:
    """Feeds a tracker with sound, and with manual inputs at their times."""

    def __init__(
        self,
        sample_rate: float,
        name: TrackerName,
        seeds: ManualInputs,
        timeline: "TimelineFile | None" = None,
        model: BarPointerModel | None = None,
    ) -> None:
        """`model`: the metres and tempi that the network's tracker expects."""
        self.tracker, self.note = make_tracker(name, sample_rate, model)
        self._tap_at, self._one_at = seeds.tap_at, seeds.one_at
        self._tap_bpm = seeds.tap_bpm or 0.0
        self._timeline = timeline
        self.record: HypothesesRecord | None = None
        """What the tracker thinks is recorded here, if there is one."""

    def feed(self, samples: Samples) -> list[BeatEstimate]:
        """Return the beats announced during these samples, shape (n,)."""
        beats = self.tracker.feed(samples)
        heard = self.tracker.position
        if self._tap_at is not None and heard >= self._tap_at:
            if isinstance(self.tracker, BeatTracker):
                self.tracker.tap(self._tap_bpm)
            self._tap_at = None
        if self._one_at is not None and heard >= self._one_at:
            if isinstance(self.tracker, BeatTracker):
                self.tracker.set_downbeat(self._one_at)
            if self._timeline is not None:
                self._timeline.one(self._one_at)
            self._one_at = None
        if self.record is not None:
            self.record.update()
        if self._timeline is not None:
            self._timeline.add_beats(beats, self.tracker.level, heard)
        return beats


def track_file(listener: BeatListener, music: Music) -> list[BeatEstimate]:
    """Return all beats of a file in time order; of a beat that was corrected before it came, the last estimate."""
    mono = music.samples.mean(axis=1, dtype=np.float32)
    kept: list[BeatEstimate] = []
    for beat in (beat for at in range(0, mono.size, BLOCK) for beat in listener.feed(mono[at : at + BLOCK])):
        if beat.replaces == beat.replaces and kept and kept[-1].position == beat.replaces:
            kept.pop()
        kept.append(beat)
    return sorted(kept, key=lambda beat: beat.position)


def lines_of(beat: BeatEstimate) -> str:
    """Return the lines that `live beats --stdin` prints for one estimate."""
    text = f"R {beat.replaces:.5f} {beat.fed:.5f}\n" if beat.replaces == beat.replaces else ""
    place = f" {beat.beat + 1}" if beat.beat >= 0 else ""
    return f"{text}B {beat.position:.5f} {beat.fed:.5f}{place}\n"


RATE: Final = 64
"""Lines per second: the show's tick rate."""

CSV_HEADING: Final = "time_s,beat,measure,phase,bpm,confidence,state\n"


class TimelineFile:
    """Feeds a tracker's beats to a TimelineFollower and writes its timeline. A context manager."""

    def __init__(self, path: Path) -> None:
        """Open the file. Every method raises PersonError if it cannot be written (full disk)."""
        self._path = path
        with self._writable():
            self._out: TextIO = path.open("w", encoding="ascii")
            self._out.write(CSV_HEADING)
        self._follower = TimelineFollower(follow_metre=True)
        self._ticks = 0
        self._pauses = PauseDetector()
        self._sound_state: SoundState = "sound"

    def __enter__(self) -> "TimelineFile":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        with self._writable():
            self._out.close()

    @contextlib.contextmanager
    def _writable(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise PersonError(f"--timeline {self._path} cannot be written ({error.strerror or error})") from None

    def one(self, time: float) -> None:
        """Handle "this is the one" at `time` [s]."""
        self._follower.set_downbeat(time)

    def add_beats(self, beats: list[BeatEstimate], level: float, position: float) -> None:
        """Handle beats announced in the sound up to `position` [s], and its level there (RMS)."""
        self._run(position)
        follower = self._follower
        before, self._sound_state = self._sound_state, self._pauses.step(level, position)
        if self._sound_state != before:
            told = {"sound": follower.found, "pause": follower.paused, "silence": follower.silent}
            told[self._sound_state](position, "audio")
        if self._sound_state != "sound":
            return
        for beat in beats:
            follower.observe(
                beat.position,
                beat.period,
                beat.confidence,
                beat.fed,
                beat=beat.beat,
                beats_per_measure=beat.beats_per_measure,
                runner_up=beat.runner_up,
                runner_up_share=beat.runner_up_share,
            )

    def _run(self, until: float) -> None:
        """Run the ticks up to `until` [s]."""
        while self._ticks / RATE < until:
            time = self._ticks / RATE
            timeline = self._follower.advance(time)
            with self._writable():
                self._out.write(
                    f"{time:.6f},{timeline.beat_at(time):.5f},{timeline.measure_at(time) + 1},"
                    f"{timeline.phase_at(time):.5f},{self._follower.tempo:.3f},{self._follower.confidence:.3f},"
                    f"{self._follower.state}\n"
                )
            self._ticks += 1


CLICK_S = 0.03
"""Length of a click [s]; it decays to 1/e in a fifth of it."""

CLICK_HZ = (1000.0, 1600.0)
"""Pitch of a click [Hz], and of a downbeat's click."""


def as_json(file: Path, tracker: str, music: Music, beats: list[BeatEstimate]) -> str:
    """Return {file, tracker, seconds, bpm, beats_per_measure, beats: [{time_s, named_s, beat, …}]} as JSON."""
    return json.dumps(
        {
            "file": file.name,
            "tracker": tracker,
            "seconds": round(music.duration, 3),
            "bpm": _tempo(beats),
            "beats_per_measure": _metre(beats),
            "beats": [
                {
                    "time_s": round(beat.position, 4),
                    "named_s": round(beat.fed, 4),
                    "beat": beat.beat + 1 if beat.beat >= 0 else None,
                    "beats_per_measure": beat.beats_per_measure or None,
                    "bpm": round(60.0 / beat.period, 2),
                    "confidence": round(beat.confidence, 3),
                }
                for beat in beats
            ],
        }
    )


def as_csv(beats: list[BeatEstimate]) -> str:
    """Return a heading and a line for each beat: time_s, named_s, beat, beats_per_measure, bpm, confidence."""
    lines = ["time_s,named_s,beat,beats_per_measure,bpm,confidence"]
    for beat in beats:
        place = f"{beat.beat + 1},{beat.beats_per_measure}" if beat.beat >= 0 else ","
        lines.append(f"{beat.position:.4f},{beat.fed:.4f},{place},{60.0 / beat.period:.2f},{beat.confidence:.3f}")
    return "\n".join(lines)


def print_table(file: Path, music: Music, beats: list[BeatEstimate], note: str) -> None:
    """Print a summary, and a line for each measure (or each fourth beat) with its time and tempo."""
    from rich.console import Console

    console = Console(highlight=False, soft_wrap=True, markup=False)
    if note:
        console.print(note)
    if not beats:
        console.print(f"{file}: no beat was detected in {music.duration:.1f} s")
        return
    metre = _metre(beats)
    known = f"{metre} beats a measure" if metre is not None else "measures unknown"
    console.print(f"{file.name}: {len(beats)} beats in {music.duration:.1f} s, {_tempo(beats):g} bpm, {known}")
    for index, beat in enumerate(beats):
        if beat.beat == 0 or (beat.beat < 0 and index % 4 == 0):
            console.print(f"  {beat.position:9.3f} s  {60.0 / beat.period:6.2f} bpm  confidence {beat.confidence:.2f}")


def write_click(path: Path, music: Music, beats: list[BeatEstimate]) -> None:
    """Write the sound, mixed to mono, with a click on each beat: 16-bit WAV at the sound's sample rate."""
    rate = music.sample_rate
    sound = 0.6 * music.samples.mean(axis=1, dtype=np.float32)
    time = np.arange(int(CLICK_S * rate)) / rate
    for beat in beats:
        start = round(beat.position * rate)
        if not 0 <= start < sound.size:
            continue
        tone = 0.5 * np.exp(-5.0 * time / CLICK_S) * np.sin(2.0 * np.pi * CLICK_HZ[beat.beat == 0] * time)
        part = sound[start : start + tone.size]
        part += tone[: part.size].astype(np.float32)
    data = (np.clip(sound, -1.0, 1.0) * 32767.0).astype("<i2").tobytes()
    try:
        with wave.open(str(path), "wb") as out:
            out.setnchannels(1)
            out.setsampwidth(2)
            out.setframerate(rate)
            out.writeframes(data)
    except OSError as error:
        raise PersonError(f"--click {path} cannot be written ({error.strerror or error})") from None


def _tempo(beats: list[BeatEstimate]) -> float | None:
    """Return the median tempo [bpm]; None without beats."""
    return round(60.0 / float(np.median([beat.period for beat in beats])), 2) if beats else None


def _metre(beats: list[BeatEstimate]) -> int | None:
    """Return the most frequent metre; None if none is known."""
    heard = Counter(beat.beats_per_measure for beat in beats if beat.beats_per_measure)
    return heard.most_common(1)[0][0] if heard else None
