"""Input from the leaders of partners: their poses are sampled frame by frame in their own beats and matched."""

from collections.abc import Callable, Iterable, Sequence
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion.partner.point_clouds import END_JOINTS
from live.motion.partner_live.stage_partner import ReadLeader
from live.show.partner.partner_pairs import Asked, Pair
from live.show.partner.partner_sources import AnswerBank

Float32 = npt.NDArray[np.float32]
Float64 = npt.NDArray[np.float64]
Int32 = npt.NDArray[np.int32]
Bool = npt.NDArray[np.bool_]
Tracks = tuple[Float32, Float32]
See = Callable[[Int32], tuple[Float32, Float32]]
Key = tuple[int, int]

LEAP: Final = 4
"""Maximum jump of a leader's beats in frames; beyond it the present answer is held."""
AT_ONCE: Final = 2
"""Leaders read in one tick; the others wait for the next tick."""
APART: Final = 0.618
"""Phase offset between the frames of successive leaders [frames], so that few are due in the same tick."""
BEYOND: Final = 1.6
"""Frames by which an answer is extrapolated after its latest frame."""
KEPT: Final = 64
"""Number of latest news entries kept."""


class AnswerLeaders:
    """The leaders of a show's partners. Thread: the show's."""

    def __init__(self, bank: AnswerBank) -> None:
        self._bank = bank
        self.read: dict[Key, ReadLeader] = {}
        """Reader state by partner index and leader row."""
        self.news: list[tuple[int, str, str]] = []
        """Latest danced units: number from 1, partner, label."""
        self.told = 0
        """Total number of danced units."""
        self._fresh: list[str] = []

    def of(self, pair: Pair) -> ReadLeader:
        """Return the reader of a pair's leader."""
        return self.read[pair.partner, pair.leader]

    def take(self, pairs: Iterable[Pair], leaving: Iterable[Pair]) -> None:
        """Read the leaders of `pairs`, keep those of pairs that are `leaving`, and drop all others."""
        wanted = {(pair.partner, pair.leader) for pair in pairs}
        keep = wanted | {(pair.partner, pair.leader) for pair in leaving}
        for key in [key for key in self.read if key not in keep]:
            del self.read[key]
        for key in sorted(wanted - set(self.read)):
            self.read[key] = ReadLeader(self._bank.lores[key[0]], (len(self.read) * APART) % 1.0)

    def look(self, asked: Sequence[Asked], danced: Float64, there: Bool, tracks: Tracks, see: See) -> None:
        """Read up to AT_ONCE leaders whose next frame has begun, most overdue first; see `Answering.tick`."""
        due = []
        for key, read in self.read.items():
            leader = key[1]
            frames = read.due(float(danced[leader]))
            if read.line is not None and not 0 <= frames <= LEAP:
                read.hold(frames_since(read, float(danced[leader])))
            if frames and there[leader] and asked[key[0]].on:
                due.append((-frames, key))
        due.sort(key=lambda one: (one[0], one[1]))
        now = [key for _, key in due[:AT_ONCE]]
        rows = np.array([key[1] for key in now if not asked[key[0]].by_path], np.int32)
        if len(rows):
            position, _ = see(rows)
            points = position[:, END_JOINTS].astype(np.float64)
        n = 0
        for key in now:
            read, leader, one = self.read[key], key[1], asked[key[0]]
            if one.by_path:
                floor, height = read.shadows(*tracks, leader)
            else:
                floor, height = points[n, :, 2] + 1j * points[n, :, 0], points[n, :, 1]
                n += 1
            read.frame(np.ascontiguousarray(floor), np.ascontiguousarray(height), float(danced[leader]), one.window)
            if read.news:
                self._tell(one.name, read.news)

    def _tell(self, name: str, label: str) -> None:
        self.told += 1
        self.news = [*self.news[1 - KEPT :], (self.told, name, label)]
        self._fresh.append(label)

    def take_fresh(self) -> list[str]:
        """Return the labels of units recognised since the last call, and clear them."""
        fresh, self._fresh = self._fresh, []
        return fresh


def frames_since(read: ReadLeader, danced: float) -> float:
    """Return the frames since the latest one, for a leader at this danced beat."""
    return min(max(read.since(danced), 0.0), BEYOND)


def answer_at(read: ReadLeader, danced: float) -> Float64:
    """Return the position of the answer [m], (2,), for a leader at this danced beat."""
    t = 2.0 * frames_since(read, danced)
    begin = int(t >= 1.0)
    t -= begin
    return np.asarray((1.0 - t) * read.root[begin, ::2] + t * read.root[begin + 1, ::2], np.float64)
