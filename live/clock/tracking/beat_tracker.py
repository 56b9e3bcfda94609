"""Tracker: sound in, beats with their place in the measure out, each named shortly before it comes."""

import math
from typing import Final

from live.clock.bar_pointer.bar_pointer import BarPointer
from live.clock.bar_pointer.state_space import Model
from live.clock.beat_announcer import Announcer
from live.clock.beat_estimate import BeatEstimate, Samples
from live.clock.silence import Quiet
from live.clock.tracking.beat_network import Activation, Hearing
from live.clock.tracking.features import HOP

RECENT: Final = 6.0
"""A press is a statement about the beats of now if it is not further away than this [s]."""

FRESH_AFTER: Final = 1.0
"""After a silence longer than this [s] the music may go on with another grid ..."""

FRESH_TIME: Final = 12.0
"""... the more easily the longer it was: by half of what is possible after this time [s]."""


class Tracker:
    """Feeds blocks of any length, at the device's own sample rate, to Hearing, BarPointer and Announcer.

    Samples that are no sound (NaN, infinite, beyond full scale) become 0 and are counted. In silence the grid is kept
    and its beats are named on; what the hand sets (tempo, level, the one, metre) is kept as well.
    """

    def __init__(self, sample_rate: float, activation: Activation, model: Model | None = None) -> None:
        """Raises ValueError for a sample rate [Hz] outside 16,000 to 400,000."""
        self._hearing = Hearing(sample_rate, activation)
        self._quiet = Quiet(HOP)
        self._announcer = Announcer()
        self._moment = 0.0
        self._one_at = math.inf
        self.pointer = BarPointer(model)
        """The grid as it is believed now."""

    @property
    def sample_rate(self) -> float:
        """Samples per second [Hz]."""
        return self._hearing.sample_rate

    @property
    def wanted(self) -> int:
        """Samples missing until the next frame: feed so many to lose no time."""
        return self._hearing.wanted

    @property
    def position(self) -> float:
        """Seconds of sound fed so far."""
        return self._hearing.fed

    @property
    def level(self) -> float:
        """RMS of the newest frame, full scale = 1."""
        return self._hearing.level

    @property
    def bad_samples(self) -> int:
        """Samples that were no sound and became 0, since the start."""
        return self._hearing.bad_samples

    @property
    def silent(self) -> bool:
        """Whether nothing was to be heard for a while."""
        return self._quiet.silent

    def feed(self, samples: Samples) -> list[BeatEstimate]:
        """Hear the next samples, shape (n,), of one channel; returns the beats named in them, oldest first."""
        found: list[BeatEstimate] = []
        start = 0
        while start < samples.shape[0] or samples.ndim != 1:
            end = start + self._hearing.wanted
            for frame in range(self._hearing.feed(samples[start:end])):
                beat = self._hear(frame)
                if beat is not None:
                    found.append(beat)
            start = end
        return found

    def tap(self, bpm: float, time: float = math.nan) -> None:
        """The tempo is this [bpm], and its level is kept from now on; ValueError for one that nobody dances to.

        `time` [s of sound], where it is given, is a beat.
        """
        self.pointer.tap(bpm)
        if abs(self._moment - time) <= RECENT:  # not NaN
            self.pointer.beat_pressed((self._moment - time) / HOP)

    def one(self, time: float) -> None:
        """A measure begins at `time` [s of sound]: what lies ahead waits for it, what is long past is left out."""
        if time > self._hearing.fed or not self._quiet.heard:
            self._one_at = time
        elif abs(self._moment - time) <= RECENT:
            self.pointer.one((self._moment - time) / HOP)

    def scale(self, factor: float) -> None:
        """The beats are twice as fast (2) or half as fast (0.5) as believed; the level is kept from now on."""
        self.pointer.scale(factor)

    def set_metre(self, beats: int) -> None:
        """The measure has so many beats; 0: as heard."""
        self.pointer.set_metre(beats)

    def let_go(self) -> None:
        """Nothing is set by hand any more."""
        self.pointer.let_go()

    def obey(self, former: "Tracker") -> None:
        """Keep tempo and metre that another tracker, whose place this one takes, was told by hand."""
        self.pointer.obey(former.pointer)

    def _hear(self, frame: int) -> BeatEstimate | None:
        hearing, quiet, pointer = self._hearing, self._quiet, self.pointer
        chance = float(hearing.beat[frame])
        listened = quiet.listening
        ended = quiet.step(hearing.level, chance)
        if not quiet.heard:
            return None
        self._moment = float(hearing.position[frame])
        if ended > FRESH_AFTER:
            pointer.resume(0.5 * min((ended - FRESH_AFTER) / FRESH_TIME, 1.0))
        elif listened and not quiet.listening:
            pointer.hold(quiet.duration / HOP)
        pointer.step(chance, float(hearing.downbeat[frame]), quiet.listening)
        if hearing.fed >= self._one_at:
            time, self._one_at = self._one_at, math.inf
            self.one(time)
        confidence = 0.0 if quiet.silent else pointer.confidence
        return self._announcer.beat(pointer, self._moment, hearing.fed, HOP, confidence)
