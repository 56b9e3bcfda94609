"""Input from the leaders of partners: their poses are sampled frame by frame in their own beats and matched."""

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from live.base.arrays import Bool, Float32, Float64, Int32
from live.motion.partner.point_clouds import LEADER_JOINTS
from live.motion.partner_live.stage_partner import LeaderReader
from live.show.partner.partner_pairs import Pair, PartnerSettings

if TYPE_CHECKING:
    from live.show.partner.example_bank import ExampleBank


Tracks = tuple[Float32, Float32]
PoseSource = Callable[[Int32], tuple[Float32, Float32]]
Key = tuple[int, int]

MAX_FRAME_JUMP: Final = 4
"""Maximum jump of a leader's beats in frames; beyond it the present answer is held."""
MAX_READS_PER_TICK: Final = 2
"""Leaders read in one tick; the others wait for the next tick."""
FRAME_PHASE_STEP: Final = 0.618
"""Phase offset between the frames of successive leaders [frames], so that few are due in the same tick."""
MAX_EXTRAPOLATION: Final = 1.6
"""Frames by which an answer is extrapolated after its latest frame."""
MAX_NEWS: Final = 64
"""Number of latest news entries kept."""


class LeaderReaders:
    """The leaders of a show's partners. Thread: the show's."""

    def __init__(self, bank: "ExampleBank") -> None:
        self._bank = bank
        self.readers: dict[Key, LeaderReader] = {}
        """Reader state by partner index and leader row."""
        self.recent_units: list[tuple[int, str, str]] = []
        """Latest danced units: number from 1, partner, label."""
        self.unit_count = 0
        """Total number of danced units."""
        self._new_labels: list[str] = []
        self._styles: list[str] = []

    def reader(self, pair: Pair) -> LeaderReader:
        """Return the reader of a pair's leader."""
        return self.readers[pair.partner, pair.leader]

    def set_examples(self, bank: "ExampleBank", styles: Sequence[str]) -> None:
        """Answer from the examples of this bank from now on, and each partner in its own of `styles`, which exists.

        Raises ValueError if the examples are read in other frames; then nothing has changed.
        """
        for key, read in self.readers.items():
            if not bank.example_sets[key[0]].fits(read.examples):
                raise ValueError("the new examples are led in another way")
        self._bank, self._styles = bank, list(styles)
        for key, read in self.readers.items():
            read.continue_with(bank.example_sets[key[0]], styles[key[0]])

    def update(self, pairs: Iterable[Pair], leaving: Iterable[Pair]) -> None:
        """Read the leaders of `pairs`, keep those of pairs that are `leaving`, and drop all others."""
        wanted = {(pair.partner, pair.leader) for pair in pairs}
        keep = wanted | {(pair.partner, pair.leader) for pair in leaving}
        for key in [key for key in self.readers if key not in keep]:
            del self.readers[key]
        for key in sorted(wanted - set(self.readers)):
            self.readers[key] = LeaderReader(
                self._bank.example_sets[key[0]], (len(self.readers) * FRAME_PHASE_STEP) % 1.0, self._styles[key[0]]
            )

    def read_due(
        self,
        settings: Sequence[PartnerSettings],
        danced_beats: Float64,
        present: Bool,
        tracks: Tracks,
        poses_of: PoseSource,
    ) -> None:
        """Read up to AT_ONCE leaders whose next frame has begun, most overdue first; see `PartnerResponse.tick`."""
        due = []
        for key, read in self.readers.items():
            leader = key[1]
            frames = read.frames_due(float(danced_beats[leader]))
            if read.frame_index is not None and not 0 <= frames <= MAX_FRAME_JUMP:
                read.hold(frames_since(read, float(danced_beats[leader])))
            if frames and present[leader] and settings[key[0]].on:
                due.append((-frames, key))
        due.sort(key=lambda one: (one[0], one[1]))
        now = [key for _, key in due[:MAX_READS_PER_TICK]]
        rows = np.array([key[1] for key in now if not settings[key[0]].by_path], np.int32)
        if len(rows):
            position, _ = poses_of(rows)
            points = position[:, LEADER_JOINTS].astype(np.float64)
        n = 0
        for key in now:
            read, leader, one = self.readers[key], key[1], settings[key[0]]
            if one.by_path:
                floor, height = read.path_cloud(*tracks, leader)
            else:
                floor, height = points[n, :, 2] + 1j * points[n, :, 0], points[n, :, 1]
                n += 1
            read.process_frame(
                np.ascontiguousarray(floor), np.ascontiguousarray(height), float(danced_beats[leader]), one.window
            )
            if read.decided_label:
                self._record_unit(one.name, read.decided_label)

    def _record_unit(self, name: str, label: str) -> None:
        self.unit_count += 1
        self.recent_units = [*self.recent_units[1 - MAX_NEWS :], (self.unit_count, name, label)]
        self._new_labels.append(label)

    def pop_new_labels(self) -> list[str]:
        """Return the labels of units recognised since the last call, and clear them."""
        fresh, self._new_labels = self._new_labels, []
        return fresh


def frames_since(read: LeaderReader, danced_beats: float) -> float:
    """Return the frames since the latest one, for a leader at this danced beat."""
    return min(max(read.frames_since(danced_beats), 0.0), MAX_EXTRAPOLATION)


def answer_position(read: LeaderReader, danced_beats: float) -> Float64:
    """Return the position of the answer [m], (2,), for a leader at this danced beat."""
    t = 2.0 * frames_since(read, danced_beats)
    begin = int(t >= 1.0)
    t -= begin
    return np.asarray((1.0 - t) * read.root[begin, ::2] + t * read.root[begin + 1, ::2], np.float64)
