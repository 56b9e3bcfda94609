"""MIDI time code decoder: quarter frames and full frames to seconds, and to beats at a given tempo.

After MIDI 1.0 Detailed Specification, MIDI Time Code (MMA RP-004/008): four quarter frames a frame; eight carry one
time, that of the frame at which the first of them was sent. 29.97 drop frame leaves out the numbers 0 and 1 of each
minute except every tenth. Time code has no beats: the show sets the tempo and the time code of the first measure.
"""

import math
from collections.abc import Sequence
from typing import Final

from live.clock.midi.midi_clock import ClockBeat, ClockEvent, ClockState
from live.clock.midi.pulse_train import PulseTrain

QUARTER_FRAME: Final = 0xF1
EXCLUSIVE: Final = 0xF0
FULL_FRAME: Final = (0xF0, 0x7F, None, 0x01, 0x01)
FULL_FRAME_LENGTH: Final = 10
FRAMES: Final = (24, 25, 30, 30)
"""Frames counted in a second, by the two bits of the rate: 24, 25, 30 drop frame, 30."""

SPEEDS: Final = (24.0, 25.0, 30.0 / 1.001, 30.0)
"""Actual frames a second: drop frame is for 29.97."""

DROP: Final = 2
LOST_AFTER: Final = 0.3
JUMP: Final = 8
"""Deviation in quarter frames that counts as a jump; smaller ones are renumbered and slewed."""

ESTIMATES_PER_BEAT: Final = 4
FULL_CONFIDENCE_PULSES: Final = 96.0


def frame_number(hours: int, minutes: int, seconds: int, frames: int, rate: int) -> int | None:
    """Return the frames since 0:00:00:00 at a rate (0 to 3, as in the messages); None for a time that does not
    exist."""
    base = FRAMES[rate]
    if not (hours < 24 and minutes < 60 and seconds < 60 and frames < base):
        return None
    number = ((hours * 60 + minutes) * 60 + seconds) * base + frames
    if rate != DROP:
        return number
    if seconds == 0 and frames < 2 and minutes % 10:
        return None
    whole = hours * 60 + minutes
    return number - 2 * (whole - whole // 10)


class TimeCode:
    """Assembles quarter frames into times. Pure. Thread: one at a time."""

    def __init__(self) -> None:
        self.rate = 1
        """24, 25, 29.97 drop, 30: 0 to 3."""
        self.direction = 0
        """1 forwards, -1 backwards, 0 unknown."""
        self.rejected = 0
        self._nibbles = [-1] * 8
        self._last = -1
        self._run = 0

    def add_quarter_frame(self, data: int) -> int | None:
        """Process a quarter frame's data byte; after eight in a row return the present number of quarter frames, else
        None.

        Counted from 0:00:00:00. Times that do not exist are counted as rejected.
        """
        piece, nibble = data >> 4, data & 15
        step = (piece - self._last) % 8
        direction = 1 if step == 1 else -1 if step == 7 else 0
        if direction == 0 or direction != self.direction:
            self._run = 1
        self.direction = direction
        self._run += 1
        self._last, self._nibbles[piece] = piece, nibble
        if self._run <= 8 or piece != (7 if direction == 1 else 0):
            return None
        n = self._nibbles
        rate = (n[7] >> 1) & 3
        number = frame_number(n[6] | (n[7] & 1) << 4, n[4] | n[5] << 4, n[2] | n[3] << 4, n[0] | n[1] << 4, rate)
        if number is None:
            self.rejected += 1
            return None
        self.rate = rate
        return 4 * number + 7 if direction == 1 else 4 * number

    def add_full_frame(self, message: Sequence[int]) -> int | None:
        """Return the number of quarter frames in a full frame message; None (counted as rejected) for an invalid
        time."""
        rate = (message[5] >> 5) & 3
        number = frame_number(message[5] & 31, message[6], message[7], message[8], rate)
        if number is None:
            self.rejected += 1
            return None
        self.rate, self.direction, self._run = rate, 0, 0
        return 4 * number


def is_full_frame(message: Sequence[int]) -> bool:
    """Whether an exclusive message is an MTC full frame."""
    return len(message) == FULL_FRAME_LENGTH and all(
        wanted is None or byte == wanted for byte, wanted in zip(message, FULL_FRAME, strict=False)
    )


class TimeCodeClock:
    """Beats from MIDI time code, with the same news as `MidiClock`. Pure; times [s] are given. Thread: one at a
    time."""

    def __init__(self, *, tempo: float, offset: float = 0.0, beats_per_measure: int = 4) -> None:
        """`tempo` [bpm] applies from the time code `offset` [s] on, where the first measure begins."""
        self.tempo = tempo
        self.offset = offset
        self.beats_per_measure = beats_per_measure
        self.code = TimeCode()
        self._train = PulseTrain(0.01)
        self._origin: int | None = None
        self._ticking = False
        self._jump = False
        self._reported_position: int | None = None

    @property
    def seconds(self) -> float:
        """The time code at the newest quarter frame [s]; NaN while unknown."""
        if self._origin is None or not self._train.length:
            return math.nan
        return (self._train.last - self._origin) / (4.0 * SPEEDS[self.code.rate])

    def receive(self, message: Sequence[int], time: float) -> list[ClockEvent]:
        """Process a message that arrived at `time` [s]; return the news. Messages other than time code change
        nothing."""
        if not message or not math.isfinite(time):
            return []
        if message[0] == EXCLUSIVE and is_full_frame(message):
            self.code.add_full_frame(message)
            self._origin = None
            return []
        if message[0] != QUARTER_FRAME or len(message) != 2 or message[1] > 127:
            return []
        return self._quarter(message[1], time)

    def advance(self, now: float) -> list[ClockEvent]:
        """Report time code that has ended as lost: tape machines send nothing more when they stop."""
        if self._ticking and now - self._train.last_arrival > LOST_AFTER:
            return self.handle_disconnect(now)
        return []

    def handle_disconnect(self, now: float) -> list[ClockEvent]:
        """Return the news after the port has gone or the code has ended."""
        was, self._ticking = self._ticking, False
        return [ClockState(now, "lost", "no time code")] if was else []

    def _quarter(self, data: int, time: float) -> list[ClockEvent]:
        train = self._train
        number = self.code.add_quarter_frame(data)
        if train.length and (not self._ticking or self.code.direction < 0):
            train.restart(train.last + 1)
            self._origin = None
        train.add(time)
        if number is not None and self.code.direction > 0:
            origin = train.last - number
            self._jump |= self._origin is None or abs(origin - self._origin) > JUMP
            self._origin = origin
        news: list[ClockEvent] = []
        if self._origin is None:
            return news
        if not self._ticking:
            news.append(ClockState(time, "found"))
        beat = self._estimate(time)
        self._ticking = True
        return [*news, beat] if beat is not None else news

    def _estimate(self, time: float) -> ClockBeat | None:
        train, origin = self._train, self._origin
        if origin is None or (train.unsure and not self._jump) or train.curve.count == 0:
            return None
        speed = 4.0 * SPEEDS[self.code.rate]
        per_beat = speed * 60.0 / self.tempo
        position = ((train.last - origin) / speed - self.offset) * self.tempo / 60.0
        told = math.floor(position * ESTIMATES_PER_BEAT)
        if (told == self._reported_position and not self._jump) or position < -1.0:
            return None
        self._reported_position, jump, self._jump = told, self._jump, False
        beat = math.floor(position) + 1
        curve = train.curve
        period = curve.period_at(train.last) * per_beat
        due = origin + self.offset * speed + beat * per_beat
        return ClockBeat(
            time=time,
            beat_time=curve.time_of(due) if beat >= 0 else time,
            period=period,
            confidence=0.5 + 0.5 * min(train.length / FULL_CONFIDENCE_PULSES, 1.0),
            beat=beat % self.beats_per_measure,
            measure=beat // self.beats_per_measure,
            jump=jump,
            anchored=True,
        )
