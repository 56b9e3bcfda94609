"""AudioAnalysis: sound in, events out; the same for a live input, a music file that plays and one read offline."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from live.clock.aubio_tracker import AubioTracker
from live.control.events import BeatHeard, ControlEvent, SourceChanged


class AudioAnalysis:
    """Feeds a AubioTracker and turns what it finds into events with the times of the show.

    Thread: one at a time; it belongs to the thread that analyses.
    """

    def __init__(self, sample_rate: float, source: str = "audio") -> None:
        """`source` is the name that the events carry; ValueError for a sample rate that no sound has."""
        self.tracker = AubioTracker(sample_rate)
        self._source = source
        self._silent = False
        self._mono = np.zeros(self.tracker.hop, np.float32)

    def feed(
        self, samples: npt.NDArray[np.float32], time_of: Callable[[float], float], now: float | None = None
    ) -> list[ControlEvent]:
        """Analyse the next samples, shape (n, channels), and return the events found in them, oldest first.

        `time_of` gives the time of the show [s] for a position in the sound [s since the first sample]. Events are
        stamped with `now` [s], or without it with the time at which their last sample is heard (offline).
        """
        events: list[ControlEvent] = []
        start = 0
        while start < samples.shape[0]:
            taken = min(self.tracker.wanted, samples.shape[0] - start)
            mono = self._mono[:taken]
            with np.errstate(invalid="ignore", over="ignore"):  # bad samples are the tracker's to find and to count
                np.mean(samples[start : start + taken], axis=1, out=mono)
            start += taken
            for estimate in self.tracker.feed(mono):
                events.append(
                    BeatHeard(
                        time=time_of(estimate.heard) if now is None else now,
                        source=self._source,
                        beat_time=time_of(estimate.position),
                        period=estimate.period,
                        confidence=estimate.confidence,
                    )
                )
            if self.tracker.silent != self._silent:
                self._silent = self.tracker.silent
                time = time_of(self.tracker.position) if now is None else now
                state = "silent" if self._silent else "found"
                events.append(SourceChanged(time=time, source=self._source, state=state))
        return events
