"""The leader's clock as a node estimates it: offset and rate from exchanges of four time stamps.

An exchange is that of NTP (RFC 5905, section 8): sent and arrived on this clock, received and answered on the other.
Its offset is wrong by half the difference of the two ways at most. That is half of what its round trip exceeds the
shortest one, if the shortest goes as fast both ways. So of each second only the exchange with the shortest round trip
counts (the minimum filter of RFC 5905, section 10), and a line is fitted through these, weighted by that bound. Its
slope is the difference of the two clocks' rates.

Both clocks are monotonic ones, so the date that a machine believes in has no effect. A disciplined clock (NTP, PTP)
runs at the right rate, which the slope shows.
"""

from collections import deque
from dataclasses import dataclass
from typing import Final

SECONDS: Final = 60
"""Seconds that are remembered: clocks of machines that warm up change their rates over minutes."""
FEWEST: Final = 6
"""Exchanges after which the estimate is used."""
RATE_SPREAD: Final = 1e-4
"""Usual difference of two clocks' rates: crystals are within 100 ppm."""
STAMP_ERROR: Final = 2e-4
"""Usual error of an exchange with the shortest round trip [s]: when the processes ran."""
STEP: Final = 0.01
"""An exchange that differs from the estimate by more than this beyond its bound [s] is of a clock that jumped, ..."""
STEPS: Final = 4
"""... after so many in a row."""
LONGEST_ROUND_TRIP: Final = 1.0
"""Exchanges that took longer [s] say nothing."""


@dataclass(frozen=True, slots=True)
class Exchange:
    """One exchange, reduced to what counts."""

    local: float
    """Its middle on this clock [s]."""
    offset: float
    """The leader's clock minus this one [s]."""
    round_trip: float
    """Time on the way, both ways [s]."""

    @classmethod
    def of(cls, sent: float, received: float, answered: float, arrived: float) -> "Exchange":
        """`sent`, `arrived`: on this clock; `received`, `answered`: on the leader's [s]."""
        offset = 0.5 * ((received - sent) + (answered - arrived))
        return cls(0.5 * (sent + arrived), offset, (arrived - sent) - (answered - received))


class LeaderClock:
    """Estimate of the leader's clock. Thread: one."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Forget everything: another leader, or a clock that has jumped."""
        self._best: deque[Exchange] = deque(maxlen=SECONDS)
        self._count = self._against = 0
        self._at = self._offset = self.rate = 0.0
        self.error = 0.0
        """Standard error of the offset [s], from the spread that is left."""

    @property
    def ready(self) -> bool:
        """Whether there are enough exchanges."""
        return self._count >= FEWEST

    @property
    def round_trip(self) -> float:
        """The shortest round trip remembered [s]."""
        return min((each.round_trip for each in self._best), default=0.0)

    def offset(self, local: float) -> float:
        """Return the leader's clock minus this one at `local` [s]."""
        return self._offset + self.rate * (local - self._at)

    def leader(self, local: float) -> float:
        """Return the time on the leader's clock at `local` on this one [s]."""
        return local + self.offset(local)

    def add(self, found: Exchange) -> None:
        """Add an exchange; one that cannot be is ignored."""
        if not 0.0 <= found.round_trip <= LONGEST_ROUND_TRIP:
            return
        if self.ready:
            bound = 0.5 * max(found.round_trip - self.round_trip, 0.0) + STEP
            self._against = self._against + 1 if abs(found.offset - self.offset(found.local)) > bound else 0
            if self._against:
                if self._against < STEPS:
                    return
                self.reset()
        self._count += 1
        last = self._best[-1] if self._best else None
        if last is not None and int(last.local) == int(found.local):
            if found.round_trip >= last.round_trip:
                return
            self._best.pop()
        self._best.append(found)
        self._fit()

    def _fit(self) -> None:
        """Fit the line by weighted least squares; the usual spread of rates bounds its slope over a short span."""
        shortest = self.round_trip
        self._at = self._best[-1].local
        base = self._best[-1].offset
        total = mean_t = mean_o = 0.0
        rows = []
        for each in self._best:
            weight = 1.0 / (STAMP_ERROR + 0.5 * (each.round_trip - shortest)) ** 2
            t, o = each.local - self._at, each.offset - base
            rows.append((weight, t, o))
            total, mean_t, mean_o = total + weight, mean_t + weight * t, mean_o + weight * o
        mean_t, mean_o = mean_t / total, mean_o / total
        spread = sum(w * (t - mean_t) ** 2 for w, t, _ in rows) + 1.0 / RATE_SPREAD**2
        self.rate = sum(w * (t - mean_t) * (o - mean_o) for w, t, o in rows) / spread
        self._offset = base + mean_o - self.rate * mean_t
        self.error = (1.0 / total + mean_t**2 / spread) ** 0.5
