"""Audio analysis from samples to events, for live input, music playback and offline files.

The tracker is either the beat network with the bar pointer or aubio. The network's trained weights are read from the
package and passed to the core as a value.
"""

import io
from collections import deque
from collections.abc import Callable, Iterator
from functools import cache
from importlib.resources import files
from typing import Final, Literal

import numpy as np
import numpy.typing as npt

from live.clock.bar_pointer.state_space import BarPointerModel
from live.clock.beat_estimate import BeatEstimate
from live.clock.energy.music_energy import BeatEnergy, MusicEnergy
from live.clock.follower.manual_control import TrackerHint
from live.clock.map_clock import MapClock
from live.clock.silence import PauseDetector, SoundState
from live.clock.tracking.aubio_tracker import AubioTracker
from live.clock.tracking.beat_network import BeatNetwork, NetworkWeights
from live.clock.tracking.beat_tracker import BeatTracker
from live.control.events.events import BeatHeard, ControlEvent, MusicHeard, SourceChanged

WEIGHTS: Final = ("weights.npz", "weights_2.npz")
"""Files of the networks that answer together, of two trainings."""
WEIGHTS_BACKWARDS: Final = ("weights_backwards.npz",)
"""File of the network that hears music backwards, for whole pieces."""


@cache
def beat_weights(names: tuple[str, ...] = WEIGHTS) -> tuple[NetworkWeights, ...]:
    """Return the weights of networks shipped with the engine (made by `training/`), by the names of their files.

    Raises ValueError if they are damaged.
    """
    return tuple(_read_weights(files("live.clock.tracking").joinpath(name).read_bytes()) for name in names)


def _read_weights(data: bytes) -> NetworkWeights:
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
            return NetworkWeights.from_arrays({name: arrays[name] for name in arrays.files if name != "recipe"})
    except Exception as error:  # zipfile, zlib and numpy each raise their own errors for damaged data
        raise ValueError(f"the beat network's weights cannot be read: {error}") from error


TrackerName = Literal["network", "aubio"]


def make_tracker(
    name: TrackerName, sample_rate: float, model: BarPointerModel | None = None
) -> tuple[BeatTracker | AubioTracker, str]:
    """Return the tracker of that name, and a note on any deviation from the request ("" if none).

    `model`: the metres and tempi that the network's tracker expects.
    If the network's weights cannot be read, or the sample rate is too low for it, aubio is used instead. ValueError for
    an impossible sample rate.
    """
    if name == "aubio":
        return AubioTracker(sample_rate), ""
    try:
        return BeatTracker(sample_rate, BeatNetwork(*beat_weights()), model), ""
    except (OSError, ValueError) as error:
        return AubioTracker(sample_rate), f"aubio is used instead of the beat network: {error}"


TimeOf = Callable[[float], float]
"""Maps a position in the sound [s since the first sample] to the time of the show [s]."""

STATES: Final[dict[SoundState, str]] = {"sound": "found", "pause": "paused", "silence": "silent"}
"""State of a SourceChanged for each kind of sound."""

MAX_BLOCK: Final = 4096
"""Maximum samples mixed at once."""


class AudioAnalysis:
    """Feeds a tracker and turns its estimates into events with times of the show.

    Thread: one at a time, the analysing thread. Any thread may append to `seeds`.
    """

    def __init__(
        self,
        sample_rate: float,
        source: str = "audio",
        tracker: TrackerName = "network",
        seeds: deque[TrackerHint] | None = None,
        energy: bool = False,
        measures: MapClock | None = None,
        model: BarPointerModel | None = None,
    ) -> None:
        """`source`: the events' source name; `energy`: whether MusicHeard events describe each beat; `measures`: the
        known measures of the piece, which are told instead of tracked beats while there are any; `model`: the metres
        and tempi that the tracker expects.

        ValueError for an impossible sample rate.
        """
        self.tracker, self.note = make_tracker(tracker, sample_rate, model)
        self.seeds: deque[TrackerHint] = deque(maxlen=64) if seeds is None else seeds
        """Manual corrections for the tracker; they are applied and removed with the next samples."""
        self._corrected_tracker = self.tracker if isinstance(self.tracker, BeatTracker) else None
        """The tracker with the manual corrections; the previous one while aubio is used."""
        self._source = source
        self._measures = measures
        self._follows_map = False
        self.origin = 0.0
        """Position in the piece of the first sample fed [s]."""
        self._pauses = PauseDetector()
        self._sound_state: SoundState = "sound"
        self._mono = np.zeros(MAX_BLOCK, np.float32)
        self._energy = MusicEnergy(sample_rate) if energy else None

    def set_downbeat(self, position: float) -> None:
        """Set a measure start at `position` [s of the sound], known from the score before any sound is analysed."""
        if isinstance(self.tracker, BeatTracker):
            self.tracker.set_downbeat(position)

    def take_over(self, former: "AudioAnalysis") -> None:
        """Take over the manual corrections of another analysis, which this one replaces."""
        known = former._corrected_tracker
        self._corrected_tracker = self.tracker if isinstance(self.tracker, BeatTracker) else known
        if isinstance(self.tracker, BeatTracker) and known is not None:
            self.tracker.copy_manual(known)

    def feed(self, samples: npt.NDArray[np.float32], time_of: TimeOf, now: float | None = None) -> list[ControlEvent]:
        """Analyse the next samples, shape (n, channels), and return the events found in them, oldest first.

        Events are stamped with `now` [s], or without it with the time of their last sample (offline).
        """
        while self.seeds:
            self._apply_seed(self.seeds.popleft(), time_of)
        events: list[ControlEvent] = []
        start = 0
        while start < samples.shape[0]:
            taken = min(self.tracker.wanted, samples.shape[0] - start, MAX_BLOCK)
            mono = self._mono[:taken]
            with np.errstate(invalid="ignore", over="ignore"):  # the tracker detects and counts bad samples
                np.mean(samples[start : start + taken], axis=1, out=mono)
            start += taken
            for estimate in self.tracker.feed(mono):
                if self._energy is not None:
                    self._energy.set_beat(estimate.position, estimate.period)
                if self._sound_state == "sound" and not self._follows_map:  # no beats extrapolated during silence
                    events.append(self._event(estimate, time_of, now))
            hearing = self._pauses.step(self.tracker.level, self.tracker.position)
            if hearing != self._sound_state:
                self._sound_state = hearing
                time = time_of(self.tracker.position) if now is None else now
                events.append(SourceChanged(time=time, source=self._source, state=STATES[hearing]))
            if self._measures is not None:
                events += self._map_beats(self._measures, time_of, now)
            if self._energy is not None:
                events += [self._music(beat, time_of, now) for beat in self._energy.feed(mono)]
        return events

    def _music(self, beat: BeatEnergy, time_of: TimeOf, now: float | None) -> MusicHeard:
        return MusicHeard(
            time=time_of(self.tracker.position) if now is None else now,
            source=self._source,
            beat_time=time_of(beat.begin),
            loudness=beat.loudness,
            density=beat.density,
            brightness=beat.brightness,
            low=beat.low,
            build=beat.build,
            drop=beat.drop,
            loudness_db=beat.loudness_db,
        )

    def _map_beats(self, measures: MapClock, time_of: TimeOf, now: float | None) -> Iterator[ControlEvent]:
        if self._follows_map and not measures.is_known:  # a person removed all lines
            time = time_of(self.tracker.position) if now is None else now
            yield SourceChanged(time=time, source="map", state="lost")
        self._follows_map = measures.is_known
        for beat in measures.until(self.origin + self.tracker.position):
            time = time_of(beat.position - self.origin)
            yield BeatHeard(
                time=time_of(self.tracker.position) if now is None else now, source="map", beat_time=time,
                period=beat.period, confidence=1.0, beat=beat.beat, beats_per_measure=beat.beats_per_measure,
                jump=beat.jump,
            )  # fmt: skip

    def _event(self, estimate: BeatEstimate, time_of: TimeOf, now: float | None) -> BeatHeard:
        return BeatHeard(
            time=time_of(estimate.fed) if now is None else now,
            source=self._source,
            beat_time=time_of(estimate.position),
            period=estimate.period,
            confidence=estimate.confidence,
            beat=estimate.beat,
            beats_per_measure=estimate.beats_per_measure,
            runner_up=estimate.runner_up,
            runner_up_share=estimate.runner_up_share,
        )

    def _apply_seed(self, seed: TrackerHint, time_of: TimeOf) -> None:
        """Apply a correction; values outside the tracker's range (tempo, metre) are ignored."""
        tracker = self.tracker
        if not isinstance(tracker, BeatTracker):
            return
        time = seed.time - (time_of(tracker.position) - tracker.position)
        try:
            if seed.kind == "tempo":
                tracker.tap(seed.value, time)
            elif seed.kind == "one":
                tracker.set_downbeat(time)
            elif seed.kind == "scale":
                tracker.scale(seed.value)
            elif seed.kind == "metre":
                tracker.set_metre(int(seed.value))
            else:
                tracker.clear_manual()
        except ValueError:
            return


MakeAnalysis = Callable[[float], AudioAnalysis]
"""Factory of the analysis for a sample rate [Hz]."""


def make_analysis_factory(
    tracker: TrackerName,
    seeds: deque[TrackerHint],
    measures: MapClock | None = None,
    model: BarPointerModel | None = None,
) -> MakeAnalysis:
    """Return a factory of analyses with that tracker, each replacing the one before; `seeds`: manual settings;
    `measures`: the known measures of the music; `model`: the metres and tempi that the tracker expects."""
    former: AudioAnalysis | None = None

    def make(rate: float) -> AudioAnalysis:
        nonlocal former
        analysis = AudioAnalysis(rate, tracker=tracker, seeds=seeds, energy=True, measures=measures, model=model)
        if former is not None:
            analysis.take_over(former)
        former = analysis
        return analysis

    return make
