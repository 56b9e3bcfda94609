"""The ways that dancers have taken in a show's last measures, as an evolution with few points (T145, T146).

Flocks that elements moved become material that can be edited, transformed and danced again (Kwon et al. 2008).
"""

from collections import deque
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from live.agents.material.ways import fit_ways
from live.base.arrays import Float32, Float64
from live.base.errors import PersonError
from live.show.show import Show

KEPT_MEASURES: Final = 64
"""Number of past measures whose places are remembered."""
SAMPLES: Final = 16
"""Places that are remembered of each measure."""
MAX_DANCERS: Final = 2000
"""Of larger shows no places are remembered."""
MAX_WAYS: Final = 400
"""Most ways that are kept as one evolution."""


@dataclass(slots=True)
class WalkedMeasure:
    """Where all dancers were in one measure."""

    number: int
    """Of the show, from 0."""
    share: list[float] = field(default_factory=list)
    """How much of the measure was over, 0 to 1, ascending."""
    places: list[Float32] = field(default_factory=list)
    """Places at these moments, each (A, 2) [m]."""

    @property
    def is_whole(self) -> bool:
        """Whether it was seen from its beginning to its end."""
        return len(self.share) > 1 and self.share[0] < 2.0 / SAMPLES and self.share[-1] > 1.0 - 2.0 / SAMPLES


class WayRecorder:
    """Remembers where dancers were in the last measures of a show. Thread: the show's."""

    def __init__(self, show: Show) -> None:
        self._show = show
        self._measures: deque[WalkedMeasure] = deque(maxlen=KEPT_MEASURES + 1)

    def frame(self) -> None:
        """Note where all are now; call once in each frame."""
        show = self._show
        number = show.span.number
        if number < 0 or len(show.state.position) > MAX_DANCERS:
            return
        if not self._measures or self._measures[-1].number != number:
            self._measures.append(WalkedMeasure(number))
        measure = self._measures[-1]
        share = min(max(show.span.fraction(show.timeline.beat_at(show.time)), 0.0), 1.0)
        if not measure.share or int(share * SAMPLES) > int(measure.share[-1] * SAMPLES):
            measure.share.append(share)
            measure.places.append(show.state.position.copy())

    def last(self, count: int, group: str) -> Float64:
        """Return the places of a group at even times over the last whole measures, at most `count`, (S, D, 2) [m].

        PersonError if no whole measure was danced, or there is nobody, or too many.
        """
        show = self._show
        if len(show.state.position) > MAX_DANCERS:
            raise PersonError(f"ways are remembered of {MAX_DANCERS} dancers at most")
        who = np.flatnonzero(show.casting.select(group, show.state.position) & show.motion.present)
        if not 0 < len(who) <= MAX_WAYS:
            words = f"nobody is {group!r} now" if not len(who) else f"{len(who)} dancers; {MAX_WAYS} at most"
            raise PersonError(words, "name a group or a selection")
        kept: list[WalkedMeasure] = []
        for measure in reversed(self._measures):
            if measure.number == show.span.number:
                continue
            if len(kept) == count or not measure.is_whole or (kept and kept[-1].number != measure.number + 1):
                break
            kept.append(measure)
        if not kept:
            raise PersonError("no whole measure was danced yet", "wait for the next measure line")
        kept.reverse()
        times = [row + share for row, measure in enumerate(kept) for share in measure.share]
        places = [each[who] for measure in kept for each in measure.places]
        after = self._measures[-1]
        if after.number == kept[-1].number + 1 and after.share:  # its first place is the end
            times.append(len(kept) + after.share[0])
            places.append(after.places[0][who])
        return even_places(np.array(times), np.array(places, np.float64), SAMPLES * len(kept) + 1, float(len(kept)))


def even_places(times: Float64, places: Float64, moments: int, length: float) -> Float64:
    """Return `places` (N, D, 2) at ascending `times` (N,) as they are at `moments` even times from 0 to `length`."""
    even = np.linspace(0.0, length, moments)
    after = np.clip(np.searchsorted(times, even), 1, len(times) - 1)
    share = np.clip((even - times[after - 1]) / np.maximum(times[after] - times[after - 1], 1e-9), 0.0, 1.0)
    return np.asarray(places[after - 1] + share[:, None, None] * (places[after] - places[after - 1]))


def evolution_table(name: str, places: Float64) -> dict[str, Any]:
    """Return the table of an evolution whose ways follow recorded `places` (S, D, 2) [m] at even times."""
    return {"name": name, "ways": [[list(point) for point in way] for way in fit_ways(places).ways]}
