"""The dancers' clock over what is heard: the show's own follower, run offline, written 64 times a second as CSV."""

import contextlib
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import Final, TextIO

from live.base.errors import PersonError
from live.clock.estimate import BeatEstimate
from live.clock.follower.timeline_follower import TimelineFollower
from live.clock.pauses import Hearing, Pauses

RATE: Final = 64
"""Lines a second: the show's ticks."""

HEADING: Final = "time_s,beat,measure,phase,bpm,confidence,state\n"


class TimelineFile:
    """Tells a TimelineFollower what a tracker named and writes where its beats are. A context manager."""

    def __init__(self, path: Path) -> None:
        """PersonError if the file cannot be written, now or later (the disk is full)."""
        self._path = path
        with self._writable():
            self._out: TextIO = path.open("w", encoding="ascii")
            self._out.write(HEADING)
        self._follower = TimelineFollower(follow_metre=True)
        self._ticks = 0
        self._pauses = Pauses()
        self._hearing: Hearing = "sound"

    def __enter__(self) -> "TimelineFile":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        with self._writable():
            self._out.close()

    @contextlib.contextmanager
    def _writable(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise PersonError(f"--timeline {self._path} cannot be written ({error.strerror or error})") from None

    def one(self, time: float) -> None:
        """Somebody pressed "this is the one" at `time` [s]."""
        self._follower.one(time)

    def heard(self, beats: list[BeatEstimate], level: float, position: float) -> None:
        """What was named in the sound up to `position` [s], and how loud it is there (RMS)."""
        self._run(position)
        follower = self._follower
        before, self._hearing = self._hearing, self._pauses.step(level, position)
        if self._hearing != before:
            told = {"sound": follower.found, "pause": follower.paused, "silence": follower.silent}
            told[self._hearing](position, "audio")
        if self._hearing != "sound":
            return
        for beat in beats:
            follower.heard(
                beat.position,
                beat.period,
                beat.confidence,
                beat.heard,
                beat=beat.beat,
                beats_per_measure=beat.beats_per_measure,
            )

    def _run(self, until: float) -> None:
        """The ticks up to `until` [s]."""
        while self._ticks / RATE < until:
            time = self._ticks / RATE
            timeline = self._follower.advance(time)
            with self._writable():
                self._out.write(
                    f"{time:.6f},{timeline.beat_at(time):.5f},{timeline.measure_at(time) + 1},"
                    f"{timeline.phase_at(time):.5f},{self._follower.tempo:.3f},{self._follower.confidence:.3f},"
                    f"{self._follower.state}\n"
                )
            self._ticks += 1
