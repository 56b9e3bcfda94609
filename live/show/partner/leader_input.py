"""Answer leaders: those whom partners answer, read frame by frame of their own beats; what is decided is told."""

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
"""Frames that a leader's beats may jump by and still go on."""
AT_ONCE: Final = 2
"""Leaders read in one tick; who is next is read in the next one."""
APART: Final = 0.618
"""Frames of each next leader begin so much of a frame earlier, so that few begin at once."""
BEYOND: Final = 1.6
"""So many frames an answer goes on after its latest frame."""
KEPT: Final = 64
"""News that are kept for who tells them on."""


class AnswerLeaders:
    """The leaders of a show's partners. Thread: the show's."""

    def __init__(self, bank: AnswerBank) -> None:
        self._bank = bank
        self.read: dict[Key, ReadLeader] = {}
        """Each by the number of the partner and by who she is."""
        self.news: list[tuple[int, str, str]] = []
        """The latest units danced: number from 1, partner, label."""
        self.told = 0
        """How many there were in all."""
        self._fresh: list[str] = []

    def of(self, pair: Pair) -> ReadLeader:
        """Who leads a pair, as she is read."""
        return self.read[pair.partner, pair.leader]

    def take(self, pairs: Iterable[Pair], leaving: Iterable[Pair]) -> None:
        """Read those who lead `pairs`, and go on with those who still lead who is `leaving`; no others."""
        wanted = {(pair.partner, pair.leader) for pair in pairs}
        keep = wanted | {(pair.partner, pair.leader) for pair in leaving}
        for key in [key for key in self.read if key not in keep]:
            del self.read[key]
        for key in sorted(wanted - set(self.read)):
            self.read[key] = ReadLeader(self._bank.lores[key[0]], (len(self.read) * APART) % 1.0)

    def look(self, asked: Sequence[Asked], danced: Float64, there: Bool, tracks: Tracks, see: See) -> None:
        """Those whose next frame has begun, AT_ONCE of them, who waits longest first; see `Answering.tick`."""
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
        """The labels of units that were decided since the last call."""
        fresh, self._fresh = self._fresh, []
        return fresh


def frames_since(read: ReadLeader, danced: float) -> float:
    """How many frames have passed since the latest one, when its leader has danced so many beats."""
    return min(max(read.since(danced), 0.0), BEYOND)


def answer_at(read: ReadLeader, danced: float) -> Float64:
    """Where the answer is when its leader has danced so many beats [m], (2,)."""
    t = 2.0 * frames_since(read, danced)
    begin = int(t >= 1.0)
    t -= begin
    return np.asarray((1.0 - t) * read.root[begin, ::2] + t * read.root[begin + 1, ::2], np.float64)
