"""Mapping of a device's sample numbers to show time (after Ableton Link's HostTimeFilter), and a check of its sample
rate.
"""

from typing import Final

import numpy as np

RATE_TOLERANCE: Final = 3e-4
"""Maximum error of a device's sample rate: 300 ppm; real ones stay within 100."""

SPAN_FOR_RATE: Final = 8.0
"""Seconds of observations before the true rate is estimated; until then the nominal one holds."""

BIN_SECONDS: Final = 0.15
BIN_COUNT: Final = 4
"""A bin is full after this many seconds of samples, and at least this many observations."""

MAX_BINS: Final = 80
"""Full bins that are kept (12 s)."""

RECENT_BINS: Final = 20
"""The newest of these set the line's present offset (3 s) ..."""

LINE_QUANTILE: Final = 0.25
"""... at this quantile of their earliest observations."""

SLACK: Final = 0.003
"""Observations this much earlier than the line [s] move it at once; bins this much later do after `LATE_BINS`."""

LATE_BINS: Final = 3
"""This many full bins (half a second) that are wholly late mean that samples were lost."""


class SampleClock:
    """A robust straight line below (frames counted, time of the callback that delivered them).

    The time stamps of sound servers are unusable (90 ms of scatter over PulseAudio). Callbacks may be late, by a lot on
    a busy machine, and come in bunches, but none comes before its samples exist. The line therefore follows the
    earliest observation of each bin of time. If all are late for half a second, samples were lost.
    Thread: one at a time.
    """

    def __init__(self, sample_rate: float) -> None:
        self.sample_rate = sample_rate
        self.jumps = 0
        """Number of times the line was moved because samples were lost, or had wrongly been taken for lost."""
        self._frame = np.zeros(MAX_BINS)
        self._late = np.zeros(MAX_BINS)
        self._full_bins = 0
        self._rate_error = 0.0
        self._offset = 0.0
        self._middle = 0.0
        self._observed = 0
        self._bin_from = 0.0
        self._bin_count = 0
        self._bin_frame = 0.0
        self._bin_late = np.inf
        self._bin_over = np.inf
        self._late_by = np.full(LATE_BINS, -np.inf)

    def observe(self, frame: float, time: float) -> None:
        """Record that frame number `frame` was delivered at `time` [s]."""
        late = time - frame / self.sample_rate
        if not self._observed:
            self._offset, self._middle, self._bin_from = late, frame, frame
        self._observed += 1
        over = late - self._lateness(frame)
        if not self._full_bins:
            self._offset += min(over, 0.0)
        elif over < -SLACK:
            self._shift(over)
            over = 0.0
        self._bin_count += 1
        if over < self._bin_over:
            self._bin_over, self._bin_late, self._bin_frame = over, late, frame
        if self._bin_count >= BIN_COUNT and frame - self._bin_from >= BIN_SECONDS * self.sample_rate:
            self._close_bin(frame)

    def time_of(self, frame: float) -> float:
        """Return the show time [s] of a frame number."""
        return frame / self.sample_rate + self._lateness(frame)

    def frame_at(self, time: float) -> float:
        """Return the frame number at a show time [s]."""
        guess = (time - self._offset) * self.sample_rate
        return (time - self._lateness(guess)) * self.sample_rate

    def _lateness(self, frame: float) -> float:
        return self._offset + self._rate_error * (frame - self._middle) / self.sample_rate

    def _shift(self, by: float) -> None:
        """Move the line and its bins: samples were lost, or were wrongly taken for lost."""
        self._offset += by
        self._late += by
        self._late_by[:] = -np.inf
        self.jumps += 1

    def _close_bin(self, frame: float) -> None:
        slot = self._full_bins % MAX_BINS
        self._frame[slot], self._late[slot] = self._bin_frame, self._bin_late
        self._full_bins += 1
        self._late_by[:-1] = self._late_by[1:]
        self._late_by[-1] = self._bin_over
        lost = float(self._late_by.min())
        if lost > SLACK and self._full_bins > LATE_BINS:
            newest = [(self._full_bins - 1 - back) % MAX_BINS for back in range(LATE_BINS)]
            kept = self._late[newest]
            self._shift(lost)
            self._late[newest] = kept
        self._bin_from, self._bin_count = frame, 0
        self._bin_over = self._bin_late = np.inf
        self._fit()

    def _fit(self) -> None:
        known = min(self._full_bins, MAX_BINS)
        frame, late = self._frame[:known], self._late[:known]
        middle = float(np.median(frame))
        if float(np.ptp(frame)) >= SPAN_FOR_RATE * self.sample_rate:
            newer = frame > middle
            rise = float(np.median(late[newer]) - np.median(late[~newer]))
            run = float(np.median(frame[newer]) - np.median(frame[~newer])) / self.sample_rate
            self._rate_error = min(max(rise / run, -RATE_TOLERANCE), RATE_TOLERANCE)
        recent = [(self._full_bins - 1 - back) % MAX_BINS for back in range(min(known, RECENT_BINS))]
        level = self._late[recent] - self._rate_error * (self._frame[recent] - middle) / self.sample_rate
        self._middle, self._offset = middle, float(np.quantile(level, LINE_QUANTILE))


WINDOW: Final = 2.0
"""Seconds over which samples are counted."""

WINDOWS: Final = 3
"""Number of consecutive windows that must agree."""

TOLERANCE: Final = 0.03
"""Relative error at which a rate counts as wrong: callbacks come in bunches, and 44.1 and 48 kHz lie 9 % apart."""

AGREEMENT: Final = 0.02
"""Maximum relative difference of the windows; occasional lost samples cause larger ones."""

RATES: Final = np.array([
    8_000.0, 11_025.0, 16_000.0, 22_050.0, 24_000.0, 32_000.0, 44_100.0, 48_000.0, 88_200.0, 96_000.0, 176_400.0,
    192_000.0,
])  # fmt: skip
"""Usual sample rates of devices [Hz]."""


class RateEstimator:
    """Measures a device's sample rate, and reports it if it differs from the nominal one."""

    def __init__(self, sample_rate: float) -> None:
        self.sample_rate = sample_rate
        """The rate in use [Hz]."""
        self._since: tuple[float, float] | None = None
        self._rates: list[float] = []

    def observe(self, frame: float, time: float) -> float | None:
        """Record frame number `frame` at `time` [s]; return the true rate [Hz] if it differs from the present one, else
        None."""
        if self._since is None:
            self._since = (frame, time)
            return None
        frames, seconds = frame - self._since[0], time - self._since[1]
        if seconds < WINDOW:
            return None
        self._since = (frame, time)
        rate = frames / seconds
        if seconds > 2.0 * WINDOW or abs(rate / self.sample_rate - 1.0) <= TOLERANCE:
            self._rates.clear()  # as expected, or the machine stalled, which gives no information
            return None
        self._rates = [*self._rates[1 - WINDOWS :], rate]
        low, high = min(self._rates), max(self._rates)
        if len(self._rates) < WINDOWS or high > low * (1.0 + AGREEMENT):
            return None
        self._rates.clear()
        rate = float(np.median([low, rate, high]))
        nearest = float(RATES[np.argmin(np.abs(np.log(RATES / rate)))])
        self.sample_rate = nearest if abs(nearest / rate - 1.0) <= TOLERANCE else rate
        return self.sample_rate
