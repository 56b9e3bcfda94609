"""Numbering of arriving pulses, and the curve of their times, robust against jitter, stalls and losses.

Pulses are sent evenly and arrive with random delays. A pulse off the curve is left out and watched. Several such
pulses in a row are judged together. A constant delay of whole periods means lost pulses (their number follows from
the time). A bunch of late pulses is a temporary stall. Anything else is a new tempo, and a new curve begins there.
"""

from typing import Final

import numpy as np

from live.clock.midi.pulse_fit import NOISE_MIN, PulseFit, Times, estimate_noise, fit

CAPACITY: Final = 2048
KEPT: Final = 1024

MIN_FIT_PULSES: Final = 5
"""Pulses after which their own curve is used instead of the assumed period."""

GATE: Final = 4.0
GATE_MIN: Final = 6e-4
"""A pulse this many standard deviations and seconds off the curve is watched."""

HALF: Final = 0.45
"""So is one this share of a period off: where the scatter is large, lost pulses show as a lasting offset."""

WATCHED: Final = 4
WATCHED_NOISY: Final = 6
"""Number of consecutive watched pulses that are judged; more where the scatter exceeds a tenth of the period."""

CONTEXT_PULSES: Final = 8
"""Number of earlier pulses that are judged with the watched ones."""

BUNCH_SPACING: Final = 0.5
"""Pulses closer than this share of a period are a bunch."""

STALL_MAX: Final = 32
WHOLE_TOLERANCE: Final = 0.3
"""Maximum deviation from a whole number of periods for a step that means lost pulses."""

KNOWN_AFTER: Final = 24
"""Pulses of one curve after which its period is kept for the next train."""

MAX_GAP_PULSES: Final = 4000
"""Largest gap in pulses for a fit: after a longer loss only the period is kept."""

BUNDLE_WITHIN: Final = 400
"""Two equal steps within this many pulses indicate a clock that is sent in bundles."""

BUNDLE_NOISE: Final = 0.5
"""Scatter of such a clock as a share of the step ..."""

BUNDLE_FADES: Final = 0.999
"""... which decays by this factor at every fit."""

FIT_EVERY_PULSE_UNTIL: Final = 24
FIT_INTERVAL: Final = 3
"""The curve is fitted at every pulse up to `FIT_EVERY_PULSE_UNTIL` after a sudden change, then at every third."""


class PulseTrain:
    """Numbers pulses by count and by time, and keeps the curve through them. Pure: times [s] are given.

    Times must not go back: an earlier one counts as the last. Thread: one at a time.
    """

    def __init__(self, period: float) -> None:
        """`period` [s] is assumed for the first pulses."""
        self._number = np.zeros(CAPACITY, np.int64)
        self._time = np.zeros(CAPACITY)
        self._weight = np.zeros(CAPACITY)
        self._count = 0
        self._since = 0
        self._watched = 0
        self._noise = 10.0 * NOISE_MIN
        self._error = 0.0
        self._known: float | None = None
        self._bundle = 0.0
        self._shifted = (-(10**9), 0.0)
        self._fit = PulseFit(0, 0.0, period, 0.0, self._noise, 0)
        self.lost = 0
        """Lost pulses, counted by time (surplus pulses count negative)."""
        self.renumbered = 0
        """Number of newest pulses that the last `add` renumbered."""

    @property
    def curve(self) -> PulseFit:
        """The present curve; `count` 0 means that its period is only assumed."""
        return self._fit

    @property
    def last(self) -> int:
        """Number of the newest pulse; meaningless before the first."""
        return int(self._number[self._count - 1])

    @property
    def last_arrival(self) -> float:
        """Arrival time of the newest pulse [s]."""
        return float(self._time[self._count - 1])

    @property
    def unsure(self) -> bool:
        """Whether the newest pulses are still being judged; until then the old curve holds."""
        return self._watched > 1

    @property
    def length(self) -> int:
        """Pulses since the last sudden change."""
        return self._count - self._since

    def restart(self, number: int) -> None:
        """Begin a new train with pulse `number`; the present period is assumed for it."""
        self._known = self._fit.period if self._fit.count >= KNOWN_AFTER else None
        self._fit = PulseFit(number, 0.0, self._fit.period, 0.0, self._noise, 0)
        self._count = self._since = self._watched = 0

    def add(self, time: float) -> None:
        """Add a pulse that arrived at `time` [s]."""
        if self._count == CAPACITY:
            self._drop_oldest()
        number = self._fit.number if self._count == 0 else self.last + 1
        self.renumbered = 0
        slot = self._count
        if slot:
            time = max(time, self.last_arrival)
        self._number[slot], self._time[slot], self._weight[slot] = number, time, 1.0
        self._count += 1
        if self._fit.count == 0:
            self._assume(number, time)
        else:
            self._watch(time - self._fit.time_of(number))
        if not self.unsure:
            self._refit()

    def _assume(self, number: int, time: float) -> None:
        """Use the line of the assumed period through the first pulse until there are enough pulses."""
        if self.length == 1:
            self._fit = PulseFit(number, time, self._fit.period, 0.0, self._noise, 0)

    def _gate(self) -> float:
        few = 1.0 + 12.0 / max(self._fit.count, 1) ** 1.5 * max(1, self.last - self._fit.number)
        return float((GATE * self._noise + GATE_MIN) * few)

    def _watch(self, error: float) -> None:
        """Watch a pulse off the curve, and judge when there are enough of them."""
        gate, half = self._gate(), HALF * self._fit.period
        if abs(error) <= min(gate, half):
            self._watched = 0
            return
        if abs(error) > gate:
            self._weight[self._count - 1] = 0.0
        self._watched = self._watched + 1 if error * self._error > 0.0 else 1
        self._error = error
        noisy = self._noise > 0.1 * self._fit.period
        if self._watched < (WATCHED_NOISY if noisy else WATCHED):
            return
        heap = self._time[self._count - 1] - self._time[self._count - 2] < BUNCH_SPACING * self._fit.period
        if error > 0.0 and heap and self._watched < STALL_MAX:
            return
        self._judge()

    def _judge(self) -> None:
        """Decide between lost pulses, a shift and a new tempo, by the best fit to the watched pulses and those
        before."""
        first = self._count - self._watched
        begin = max(first - CONTEXT_PULSES, self._since)
        numbers = self._number[begin : self._count]
        errors = self._time[begin : self._count] - np.array([self._fit.time_of(float(n)) for n in numbers])
        x = np.arange(begin - first, self._count - first, dtype=np.float64)
        step = float(np.median(errors[first - begin :]))
        as_step = float(np.square(errors - step * (x >= 0.0)).sum())
        as_tempo = min(_misfit_of_ramp(errors, x - knee) for knee in np.arange(-CONTEXT_PULSES, 1.0) - 0.5)
        self._weight[first : self._count] = 1.0
        self._watched = 0
        if as_step > as_tempo:
            self._since, self._known = first, None
            return
        moved = _lost_pulses(step / self._fit.period)
        self._number[first : self._count] += moved
        self.renumbered = self._count - first if moved else 0
        self.lost += moved
        if abs(moved) > MAX_GAP_PULSES:
            self._since, self._known = first, self._fit.period
            return
        rest = step - moved * self._fit.period
        if abs(rest) > self._gate():
            self._shift(first, rest)

    def _shift(self, first: int, by: float) -> None:
        """Shift: all pulses from index `first` on are `by` [s] later than those before, at the same tempo.

        The first time, the sender has moved its phase, and the earlier pulses are moved along. The second time by the
        same
        amount, the clock is sent in bundles that drift against its pulses, and the shift counts as scatter.
        """
        number, before = self._shifted
        if self.last - number <= BUNDLE_WITHIN and abs(by - before) < 0.3 * abs(before):
            self._bundle = BUNDLE_NOISE * abs(by)
            self._time[self._since : max(self._count - (self.last - number), self._since)] -= before
            self._shifted = (self.last, 0.0)
            return
        self._time[self._since : first] += by
        self._shifted = (self.last, by)

    def _refit(self) -> None:
        if self.length < MIN_FIT_PULSES and self._fit.count == 0:
            return
        if self.length < 4 or (self.length > FIT_EVERY_PULSE_UNTIL and self.last - self._fit.number < FIT_INTERVAL):
            return
        since = max(self._since, self._count - KEPT // 4 * 3)
        self._bundle *= BUNDLE_FADES
        self._noise = max(estimate_noise(self._number[: self._count], self._time[: self._count]), self._bundle)
        numbers, times = self._number[since : self._count], self._time[since : self._count]
        self._fit = fit(numbers, times, self._weight[since : self._count], self._noise, self._known)

    def _drop_oldest(self) -> None:
        """Drop all but the newest pulses."""
        for values in (self._number, self._time, self._weight):
            values[:KEPT] = values[CAPACITY - KEPT :]
        self._count = KEPT
        self._since = max(self._since - (CAPACITY - KEPT), 0)


def _lost_pulses(periods: float) -> int:
    """Return the number of lost pulses for a step in periods; 0 if it is hardly nearer to one than to none."""
    whole = round(periods)
    return 0 if abs(whole) <= 1 and abs(periods - whole) > WHOLE_TOLERANCE else whole


def _misfit_of_ramp(errors: Times, x: Times) -> float:
    """Return the residual sum of squares for errors that grow linearly from x = 0 on."""
    ramp = np.maximum(x, 0.0)
    slope = float(ramp @ errors) / float(ramp @ ramp)
    return float(np.square(errors - slope * ramp).sum())
