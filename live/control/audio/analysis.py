"""AudioAnalysis: sound in, events out; the same for a live input, a music file that plays and one read offline.

The beat network's trained weights, read from the package; the core is given them as a value.

Which tracker listens: our network under the bar pointer, or aubio.
"""

import io
from collections import deque
from collections.abc import Callable
from functools import cache
from importlib.resources import files
from typing import Final, Literal

import numpy as np
import numpy.typing as npt

from live.clock.beat_estimate import BeatEstimate
from live.clock.energy.music_energy import BeatEnergy, MusicEnergy
from live.clock.follower.manual_control import Seed
from live.clock.silence import Hearing, Pauses
from live.clock.tracking.aubio_tracker import AubioTracker
from live.clock.tracking.beat_network import Network, Weights
from live.clock.tracking.beat_tracker import Tracker
from live.control.events.events import BeatHeard, ControlEvent, MusicHeard, SourceChanged


@cache
def beat_weights() -> Weights:
    """The weights that come with the engine (`training/` makes them). Raises ValueError where they are damaged."""
    data = files("live.clock.tracking").joinpath("weights.npz").read_bytes()
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
            return Weights.of({name: arrays[name] for name in arrays.files if name != "recipe"})
    except Exception as error:  # zipfile, zlib and numpy each have errors of their own for what is damaged
        raise ValueError(f"the beat network's weights cannot be read: {error}") from error


TrackerName = Literal["network", "aubio"]


def make_tracker(name: TrackerName, sample_rate: float) -> tuple[Tracker | AubioTracker, str]:
    """The tracker of that name, and words on what is different from what was asked for ("" if nothing is).

    Where the network's weights cannot be read, or at sample rates below what it can hear, aubio listens instead.
    ValueError for a sample rate that no sound has.
    """
    if name == "aubio":
        return AubioTracker(sample_rate), ""
    try:
        return Tracker(sample_rate, Network(beat_weights())), ""
    except (OSError, ValueError) as error:
        return AubioTracker(sample_rate), f"aubio listens instead of the beat network: {error}"


TimeOf = Callable[[float], float]
"""Time of the show [s] for a position in the sound [s since the first sample]."""

STATES: Final[dict[Hearing, str]] = {"sound": "found", "pause": "paused", "silence": "silent"}
"""What a SourceChanged says of it."""

LONGEST: Final = 4096
"""Samples mixed at once."""


class AudioAnalysis:
    """Feeds a tracker and turns what it finds into events with the times of the show.

    Thread: one at a time; it belongs to the thread that analyses. `seeds` may be filled by any thread.
    """

    def __init__(
        self,
        sample_rate: float,
        source: str = "audio",
        tracker: TrackerName = "network",
        seeds: deque[Seed] | None = None,
        energy: bool = False,
    ) -> None:
        """`source` is the name that the events carry; `energy`: whether MusicHeard tells what each beat was like.

        ValueError for a sample rate that no sound has.
        """
        self.tracker, self.note = make_tracker(tracker, sample_rate)
        self.seeds: deque[Seed] = deque(maxlen=64) if seeds is None else seeds
        """What people said by hand and the tracker is to know; taken up, and removed, with the next samples."""
        self._obeyed = self.tracker if isinstance(self.tracker, Tracker) else None
        """The tracker that knows what was told by hand: where aubio listens, the one before it."""
        self._source = source
        self._pauses = Pauses()
        self._hearing: Hearing = "sound"
        self._mono = np.zeros(LONGEST, np.float32)
        self._energy = MusicEnergy(sample_rate) if energy else None

    def know_one(self, position: float) -> None:
        """A measure begins at `position` [s of the sound]: so says the music's score, before anything is heard."""
        if isinstance(self.tracker, Tracker):
            self.tracker.one(position)

    def succeed(self, former: "AudioAnalysis") -> None:
        """Take the place of another analysis: what its tracker was told by hand holds on."""
        known = former._obeyed
        self._obeyed = self.tracker if isinstance(self.tracker, Tracker) else known
        if isinstance(self.tracker, Tracker) and known is not None:
            self.tracker.obey(known)

    def feed(self, samples: npt.NDArray[np.float32], time_of: TimeOf, now: float | None = None) -> list[ControlEvent]:
        """Analyse the next samples, shape (n, channels), and return the events found in them, oldest first.

        Events are stamped with `now` [s], or without it with the time at which their last sample is heard (offline).
        """
        while self.seeds:
            self._take(self.seeds.popleft(), time_of)
        events: list[ControlEvent] = []
        start = 0
        while start < samples.shape[0]:
            taken = min(self.tracker.wanted, samples.shape[0] - start, LONGEST)
            mono = self._mono[:taken]
            with np.errstate(invalid="ignore", over="ignore"):  # bad samples are the tracker's to find and to count
                np.mean(samples[start : start + taken], axis=1, out=mono)
            start += taken
            for estimate in self.tracker.feed(mono):
                if self._energy is not None:
                    self._energy.beat(estimate.position, estimate.period)
                if self._hearing == "sound":  # the beats that a tracker counts on in silence are nothing heard
                    events.append(self._event(estimate, time_of, now))
            hearing = self._pauses.step(self.tracker.level, self.tracker.position)
            if hearing != self._hearing:
                self._hearing = hearing
                time = time_of(self.tracker.position) if now is None else now
                events.append(SourceChanged(time=time, source=self._source, state=STATES[hearing]))
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

    def _event(self, estimate: BeatEstimate, time_of: TimeOf, now: float | None) -> BeatHeard:
        return BeatHeard(
            time=time_of(estimate.heard) if now is None else now,
            source=self._source,
            beat_time=time_of(estimate.position),
            period=estimate.period,
            confidence=estimate.confidence,
            beat=estimate.beat,
            beats_per_measure=estimate.beats_per_measure,
        )

    def _take(self, seed: Seed, time_of: TimeOf) -> None:
        """Tell the tracker; what it cannot take (a tempo nobody dances to, a metre it does not know) is left out."""
        tracker = self.tracker
        if not isinstance(tracker, Tracker):
            return
        time = seed.time - (time_of(tracker.position) - tracker.position)
        try:
            if seed.kind == "tempo":
                tracker.tap(seed.value, time)
            elif seed.kind == "one":
                tracker.one(time)
            elif seed.kind == "scale":
                tracker.scale(seed.value)
            elif seed.kind == "metre":
                tracker.set_metre(int(seed.value))
            else:
                tracker.let_go()
        except ValueError:
            return


MakeAnalysis = Callable[[float], AudioAnalysis]
"""Makes the analysis for a sample rate [Hz]."""
