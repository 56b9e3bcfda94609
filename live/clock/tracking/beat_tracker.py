"""Beat tracker: audio to beats with their position in the measure, each announced shortly before it falls."""

import math
from typing import Final

import numpy as np
import numpy.typing as npt

from live.clock.bar_pointer.bar_pointer import BarPointer
from live.clock.bar_pointer.state_space import BarPointerModel
from live.clock.beat_announcer import BeatAnnouncer
from live.clock.beat_estimate import BeatEstimate, Samples
from live.clock.silence import SilenceDetector
from live.clock.tracking.beat_network import Activation, ActivationStream
from live.clock.tracking.features import HOP
from live.clock.tracking.measure_cues import CUE_WEIGHTS, MeasureCues
from live.clock.tracking.phase_cues import PHASE_WEIGHTS, PhaseCues

TAP_MAX_AGE: Final = 6.0
"""A tap refers to the present beats if it is no further away than this [s]."""

FRESH_AFTER: Final = 1.0
"""After a silence longer than this [s] the music may continue on another grid ..."""

FRESH_TIME: Final = 12.0
"""... with a probability that grows with its length, up to one half after this time [s]."""


class BeatTracker:
    """Feeds blocks of any length, at the device's own sample rate, through features, bar pointer and beat announcer.

    Faulty samples (NaN, infinite, beyond 64) become 0 and are counted. In silence the grid is kept
    and its beats are still announced; manual settings (tempo, level, downbeat, metre) are kept as well.
    """

    def __init__(self, sample_rate: float, activation: Activation, model: BarPointerModel | None = None) -> None:
        """Raises ValueError for a sample rate [Hz] outside 16,000 to 400,000."""
        self._activations = ActivationStream(sample_rate, activation)
        self._silence = SilenceDetector(HOP)
        self._announcer = BeatAnnouncer()
        self._measure_cues = MeasureCues(CUE_WEIGHTS)
        self._phase_cues = PhaseCues(PHASE_WEIGHTS)
        self._grids = 0
        self._moment = 0.0
        self._downbeat_at = math.inf
        self.pointer = BarPointer(model)
        """The present grid."""

    @property
    def wanted(self) -> int:
        """Samples missing until the next frame is full: feed this many for minimum latency."""
        return self._activations.wanted

    @property
    def position(self) -> float:
        """Seconds of audio fed so far."""
        return self._activations.fed_seconds

    @property
    def level(self) -> float:
        """RMS of the newest frame, full scale = 1."""
        return self._activations.level

    @property
    def bad_samples(self) -> int:
        """Number of faulty samples, which became 0, since the start."""
        return self._activations.bad_samples

    @property
    def silent(self) -> bool:
        """Whether it has been silent for a while."""
        return self._silence.silent

    def feed(self, samples: Samples) -> list[BeatEstimate]:
        """Process the next samples, shape (n,), of one channel; return the beats announced in them, oldest first."""
        found: list[BeatEstimate] = []
        start = 0
        while start < samples.shape[0] or samples.ndim != 1:
            end = start + self._activations.wanted
            for frame in range(self._activations.feed(samples[start:end])):
                beat = self._process_frame(frame)
                if beat is not None:
                    found.append(beat)
            start = end
        return found

    def tap(self, bpm: float, time: float = math.nan) -> None:
        """Set the tempo [bpm] and keep its metrical level from now on; ValueError for a tempo outside the model's
        range.

        `time` [s of audio], if given, is a beat.
        """
        self.pointer.set_tempo(bpm)
        if abs(self._moment - time) <= TAP_MAX_AGE:  # not NaN
            self.pointer.set_beat((self._moment - time) / HOP)

    def set_downbeat(self, time: float) -> None:
        """Start a measure at `time` [s of audio]: a future time is kept until it comes, an old one is ignored."""
        if time > self._activations.fed_seconds or not self._silence.has_sound:
            self._downbeat_at = time
        elif abs(self._moment - time) <= TAP_MAX_AGE:
            self.pointer.set_downbeat((self._moment - time) / HOP)

    def scale(self, factor: float) -> None:
        """Set the beats to twice (2) or half (0.5) the present tempo, and keep the metrical level from now on."""
        self.pointer.scale(factor)

    def set_metre(self, beats: int) -> None:
        """Set the number of beats in a measure; 0: as detected."""
        self.pointer.set_metre(beats)

    def clear_manual(self) -> None:
        """Remove all manual settings."""
        self.pointer.clear_manual()

    def copy_manual(self, former: "BeatTracker") -> None:
        """Copy the manual tempo and metre of another tracker that this one replaces."""
        self.pointer.copy_manual(former.pointer)

    def _process_frame(self, frame: int) -> BeatEstimate | None:
        hearing, quiet, pointer = self._activations, self._silence, self.pointer
        chance = float(hearing.beat[frame])
        listened = quiet.expects_beats
        ended = quiet.step(hearing.level, chance)
        if not quiet.has_sound:
            return None
        self._moment = float(hearing.position[frame])
        if ended > FRESH_AFTER and not listened:  # in a rest that was expected the states have gone on by themselves
            pointer.resume(0.5 * min((ended - FRESH_AFTER) / FRESH_TIME, 1.0))
        elif listened and not quiet.expects_beats:
            pointer.restore_before(quiet.duration / HOP)
        downbeat = float(hearing.downbeat[frame])
        pointer.step(chance, downbeat, quiet.expects_beats)
        self._hear_cues(hearing.features[frame], chance, downbeat)
        if hearing.fed_seconds >= self._downbeat_at:
            time, self._downbeat_at = self._downbeat_at, math.inf
            self.set_downbeat(time)
        confidence = 0.0 if quiet.silent else pointer.confidence
        return self._announcer.beat(pointer, self._moment, hearing.fed_seconds, HOP, confidence)

    def _hear_cues(self, features: npt.NDArray[np.float32], beat: float, downbeat: float) -> None:
        """Pass what harmony, bass and pickups say of the last beats on to the pointer."""
        pointer = self.pointer
        if pointer.jumps != self._grids or not self._silence.expects_beats:
            self._grids = pointer.jumps
            self._measure_cues.clear()
            self._phase_cues.clear()
        elif pointer.interval > 0.0:
            since, interval = pointer.since_beat, pointer.interval
            scores = self._phase_cues.step(features, beat, since, interval)
            if scores is not None and (shift := pointer.add_phase_cue(scores)):
                self._grids = pointer.jumps
                self._phase_cues.shift(shift)
                self._measure_cues.clear()
                return
            of_measure = self._measure_cues.step(features, beat, downbeat, since, interval)
            if of_measure is not None:
                pointer.add_measure_cue(of_measure)
