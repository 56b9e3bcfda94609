"""Parts: what runs beside a show (Link, click, MIDI, OSC, its audience): one row that starts, follows and ends."""

from collections import Counter
from collections.abc import Callable
from typing import Any, Protocol

from live.base.part_faults import FAULTS, Bulkhead, name_of, run_once
from live.cli.audience_part import AudiencePart


class Part(Protocol):
    """Something beside the show that has a device or a network of its own."""

    def start(self) -> None:
        """Open what it needs; PersonError if that is refused."""
        ...

    def stop(self) -> None:
        """Let go of it; whether it was started or not."""
        ...

    def frame(self) -> None:
        """After each frame: how the show runs."""
        ...

    def status(self) -> dict[str, Any]:
        """For the status line."""
        ...


class Parts:
    """The parts of one show, in the order in which they start. Thread: the one that runs the show."""

    def __init__(self) -> None:
        self._parts: list[Part] = []
        self.bulkhead = Bulkhead()
        """Keeps errors of each part away from the frame and from the others."""
        self.refused: list[Callable[[], Counter[str]]] = []
        """What was refused by parts that refuse, by reason."""
        self.early: list[Callable[[], None]] = []
        """What is done before each frame: taking up what shall act in it."""
        self.audience: AudiencePart | None = None
        """The one that the audience's phones play through, if they may."""
        self.refusals: list[Callable[[], str]] = []
        """The last refusal of each of them, in words."""

    def add(self, part: Part) -> None:
        """One more; before `start`."""
        self._parts.append(part)

    def start(self, *, forgiving: bool = False) -> None:
        """Start all of them; the first that refuses ends it. `forgiving`: a show that is gone on with is not ended by a
        part that cannot go on; it is left out, and told."""
        for part in list(self._parts):
            try:
                part.start()
            except Exception as error:
                if not forgiving:
                    raise
                FAULTS.note(f"the start of {name_of(part.start)}", error)
                self._parts.remove(part)
                run_once(f"the end of {name_of(part.stop)}", part.stop)

    def before_frame(self) -> None:
        """Before each frame."""
        for take in self.early:
            self.bulkhead.call(f"{name_of(take)}, before a frame", take)

    def frame(self) -> None:
        """After each frame."""
        for part in self._parts:
            self.bulkhead.call(name_of(part.frame), part.frame)

    def stop(self) -> None:
        """Stop all of them, for good: nothing is sent or played from here any more."""
        for part in self._parts:
            run_once(f"the end of {name_of(part.stop)}", part.stop)
        self._parts.clear()
        self.early.clear()
