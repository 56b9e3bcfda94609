"""MIDI beat clock decoder: predicts beats from 24 pulses a beat, start, stop, continue and song position.

After the MIDI 1.0 Detailed Specification (4.2.1), system common and real time messages. A start or continue takes
effect at the next pulse. The song position counts sixteenths, six pulses each. A sender with active sensing is lost
after 330 ms without any message.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Protocol

from live.clock.midi.pulse_train import PulseTrain

PULSES_PER_BEAT: Final = 24
PULSES_PER_SIXTEENTH: Final = 6
PULSES_PER_ESTIMATE: Final = 6
"""Pulses between two estimates."""

LOST_AFTER: Final = 0.5
"""Seconds without a pulse, at least `LOST_PULSES` periods, after which a running clock counts as lost."""

LOST_PULSES: Final = 4.0
SENSING_TIMEOUT: Final = 0.33
"""Maximum silence of a sender with active sensing [s]."""

RESTART_GAP: Final = 8.0
"""Periods without a pulse after which a clock that is stopped or cued begins a new train."""

FULL_CONFIDENCE_PULSES: Final = 48.0
"""Pulses of one steady stretch after which an estimate has full confidence."""

BEAT_MIN_S: Final = 0.12
BEAT_MAX_S: Final = 4.0
"""Beat periods outside these bounds are not reported."""

CLOCK, START, CONTINUE, STOP, SENSING, RESET = 0xF8, 0xFA, 0xFB, 0xFC, 0xFE, 0xFF
SONG_POSITION: Final = 0xF2


@dataclass(frozen=True, slots=True)
class ClockBeat:
    """A coming beat, as known at `time` [s]. It replaces all earlier estimates."""

    time: float
    beat_time: float
    period: float
    """Beat period from now on [s]."""
    confidence: float
    beat: int
    """Beat of its measure, from 0; -1 if unknown."""
    measure: int
    """From 0, by the song position; -1 if unknown."""
    jump: bool
    """Whether the position jumped here: start, continue, song position."""
    anchored: bool
    """False while the clock has not been started: beats are counted from an arbitrary pulse."""


@dataclass(frozen=True, slots=True)
class ClockState:
    """A change of state: "found" or "lost" for the source, "started" or "stopped" for the song."""

    time: float
    state: str
    detail: str = ""


ClockEvent = ClockBeat | ClockState


class MessageClock(Protocol):
    """A clock made of the messages of one sender. Pure: messages come with their times [s]. Thread: one at a time."""

    beats_per_measure: int

    def receive(self, message: Sequence[int], time: float) -> list[ClockEvent]:
        """Process a message that arrived at `time`; return the news. Other messages than its own change nothing."""
        ...

    def advance(self, now: float) -> list[ClockEvent]:
        """Return the news at `now` due to missing messages."""
        ...

    def handle_disconnect(self, now: float) -> list[ClockEvent]:
        """Return the news after the port has gone."""
        ...


class MidiClock:
    """Decodes one sender. Pure: messages come with their times [s]. Thread: one at a time."""

    def __init__(self, *, beats_per_measure: int = 4, tempo: float = 120.0) -> None:
        """`tempo` [bpm] is assumed until pulses define it; MIDI does not transmit the number of beats in a measure."""
        self.beats_per_measure = beats_per_measure
        self.running = False
        """Whether the song is running (started or continued, and not stopped)."""
        self.rejected = 0
        """Number of invalid messages: wrong lengths, data bytes above 127, non-finite times."""
        self.train = PulseTrain(60.0 / (tempo * PULSES_PER_BEAT))
        self._origin = 0
        self._cue: int | None = None
        self._stopped_position = 0
        self._cued_for = 0
        self._reported_sixteenth: int | None = None
        self._started = False
        self._ticking = False
        self._received_at = -math.inf
        self._sensing = False

    @property
    def position(self) -> int:
        """Pulses from the beginning of the song to the newest pulse; while stopped, to the next pulse."""
        return self.train.last - self._origin if self.running and self._cue is None else self._stopped_position

    def receive(self, message: Sequence[int], time: float) -> list[ClockEvent]:
        """Process a message that arrived at `time` [s]; return the news. Other messages than a clock's change
        nothing."""
        if not math.isfinite(time) or not message or not 0x80 <= message[0] <= 0xFF:
            self.rejected += 1
            return []
        self._received_at = time
        status = message[0]
        if status == CLOCK:
            return self._pulse(time)
        if status == START:
            return self._start(0, time)
        if status == CONTINUE:
            return self._start(self._stopped_position if not self.running else self.position + 1, time)
        if status == STOP:
            return self._stop(time)
        if status == SONG_POSITION:
            return self._locate(message)
        if status == SENSING:
            self._sensing = True
        if status == RESET:
            self._stopped_position = 0
            return self._stop(time)
        return []

    def advance(self, now: float) -> list[ClockEvent]:
        """Return the news at `now` [s] due to missing messages; call it a few times a second."""
        silent_for = now - self._received_at
        if self._sensing and silent_for > SENSING_TIMEOUT:
            self._sensing = False
            return self._lose(now, "active sensing ended")
        if not self._ticking:
            return []
        if now - self.train.last_arrival > max(LOST_AFTER, LOST_PULSES * self.train.curve.period):
            if self._started and not self.running:  # a stopped song may send no pulses: nothing is lost
                self._ticking = False
                return []
            return self._lose(now, "no clock")
        return []

    def handle_disconnect(self, now: float) -> list[ClockEvent]:
        """Return the news after the port has gone."""
        self._sensing = False
        return self._lose(now, "port gone") if self._ticking else []

    def _lose(self, now: float, detail: str) -> list[ClockEvent]:
        self._ticking = False
        return [ClockState(now, "lost", detail)]

    def _start(self, position: int, time: float) -> list[ClockEvent]:
        was = self.running
        self.running = self._started = True
        self._cue = self._stopped_position = position
        return [] if was else [ClockState(time, "started")]

    def _stop(self, time: float) -> list[ClockEvent]:
        if not self.running:
            return []
        self._stopped_position = self.position + 1 if self._cue is None else self._cue
        self.running, self._cue, self._reported_sixteenth = False, None, None
        return [ClockState(time, "stopped")]

    def _locate(self, message: Sequence[int]) -> list[ClockEvent]:
        if len(message) != 3 or max(message[1:]) > 127:
            self.rejected += 1
            return []
        position = (message[1] + 128 * message[2]) * PULSES_PER_SIXTEENTH
        if not self.running:
            self._stopped_position = position
        elif abs(position - (self.position + 1)) >= PULSES_PER_SIXTEENTH or self._cue is not None:
            self._cue = self._stopped_position = position
        return []

    def _pulse(self, time: float) -> list[ClockEvent]:
        news: list[ClockEvent] = []
        if not self._ticking:
            self._ticking = True
            news.append(ClockState(time, "found"))
        train = self.train
        fresh = not self.running or self._cue is not None
        if train.length and fresh and time - train.last_arrival > RESTART_GAP * train.curve.period:
            train.restart(train.last + 1)
        lost = train.lost
        train.add(time)
        self._cued_for += 1
        jump = self._cue is not None
        if self._cue is not None:
            self._origin, self._cue, self._cued_for = train.last - self._cue, None, 1
        elif train.renumbered >= self._cued_for:  # the pulse that began the song was itself renumbered
            self._origin += train.lost - lost
        beat = self._estimate(time, jump)
        return [*news, beat] if beat is not None else news

    def _estimate(self, time: float, jump: bool) -> ClockBeat | None:
        """Return the estimate at this pulse, if one is due: at each sixteenth, at a jump, and soon after a sudden
        change."""
        train = self.train
        position = train.last - self._origin
        sixteenth = position // PULSES_PER_ESTIMATE
        soon = train.length in (5, 8, 12)
        if (sixteenth == self._reported_sixteenth and not soon and not jump) or (train.unsure and not jump):
            return None
        if not self.running and train.curve.count == 0:  # neither tempo nor position is known
            return None
        self._reported_sixteenth = sixteenth
        beats = -(-position // PULSES_PER_BEAT) if jump else position // PULSES_PER_BEAT + 1
        curve = train.curve
        period = curve.time_of(train.last + PULSES_PER_BEAT) - curve.time_of(train.last)
        if not BEAT_MIN_S <= period <= BEAT_MAX_S:
            return None
        anchored = self.running
        return ClockBeat(
            time=time,
            beat_time=curve.time_of(beats * PULSES_PER_BEAT + self._origin),
            period=period,
            confidence=self._confidence(),
            beat=beats % self.beats_per_measure if anchored else -1,
            measure=beats // self.beats_per_measure if anchored else -1,
            jump=jump,
            anchored=anchored,
        )

    def _confidence(self) -> float:
        curve = self.train.curve
        if curve.count == 0:
            return 0.2
        length = min(self.train.length / FULL_CONFIDENCE_PULSES, 1.0)
        return (0.4 + 0.6 * length) / (1.0 + curve.noise / curve.period)
