"""Records: what a running show writes down: its journal, and a line of figures a second.

Memory: how much of the machine's this process holds.
"""

from collections.abc import Callable
from pathlib import Path

import psutil
from rich.console import Console

from live.app.launch_options import Wish
from live.app.processes.resume_state import Resumed
from live.app.session_audio import Sound
from live.base.errors import PersonError
from live.show.engine import Engine
from live.show.journal.journal import JournalError, JournalWriter, trouble_of
from live.show.loader import LoadedShow
from live.show.status import Status, StatusFile
from live.supervisor.journal_relay import RelaySink
from live.supervisor.supervisor_link import Lifeline


class Records:
    """The journal goes to the supervisor, where there is one; its disk is there. Thread: the one that runs the show."""

    def __init__(
        self, wish: Wish, loaded: LoadedShow, sound: Sound, *, lifeline: Lifeline | None, resumed: Resumed | None
    ) -> None:
        """Nothing is written yet; `resumed`: the show that is gone on with, whose records are."""
        self._wish, self._loaded, self._sound = wish, loaded, sound
        self._lifeline, self._resumed = lifeline, resumed
        self._journal: JournalWriter | None = None
        self._relay: RelaySink | None = None
        self._status_file: StatusFile | None = None

    def open_status(self, status: Status) -> None:
        """Begin the lines of figures, if they are asked for; PersonError if they cannot be written."""
        if self._wish.status_json is None:
            return
        try:
            self._status_file = StatusFile(self._wish.status_json, status, more=self._resumed is not None)
        except OSError as error:
            raise PersonError(f"cannot write --status-json {self._wish.status_json}: {error.strerror}") from None

    def open_journal(
        self, engine: Engine, status: Status, *, tempo: float | None, origin: float, begun: float | None
    ) -> None:
        """Begin the journal, last of all: a start that is refused leaves an old one of its name where it is.

        `tempo` [bpm]: what the show began with; `origin` [s of perf_counter]: of its clock; `begun` [s of the show]:
        when its sound did.
        """
        header = self._loaded.header(engine.show, tempo=tempo, music=self._sound.path)
        if self._lifeline is not None:
            self._relay = RelaySink(self._lifeline, self._wish.journal)
            header |= {"origin": origin, "begun": begun}
            self._journal = JournalWriter(Path(), None if self._resumed else header, sink=self._relay)
        elif self._wish.journal is not None:
            try:
                self._journal = JournalWriter(self._wish.journal, header)
            except JournalError as error:
                raise PersonError(str(error)) from None
        else:
            return
        self._journal.prepare(engine.show)
        status.more["journal"] = self._journal.facts
        engine.journal = self._journal

    def problem(self) -> str:
        """What is wrong with the journal."""
        if self._journal is None:
            return ""
        disk = {} if self._lifeline is None else self._lifeline.facts.get("disk", {})
        return self._journal.problem or trouble_of(disk)

    def frame(self, time: float) -> None:
        """After a frame that began at `time` [s]: the figures, and what was sealed for the supervisor."""
        if self._status_file is not None:
            self._status_file.frame(time)
        if self._relay is not None:
            self._relay.flush()

    def close(self, tick: int, time: float, *, ended: bool = True) -> None:
        """Write what waits: the last `tick`, and the figures of `time` [s]. `ended`: the show has, as it should."""
        if self._journal is not None:
            self._journal.close(tick, ended=ended)
        if self._status_file is not None:
            self._status_file.close(time)

    def warnings(self) -> list[str]:
        """What went wrong and did not stop the show, in words."""
        told = []
        if self._journal is not None and self._journal.kept is not None:
            told.append(f"the journal that was there is now {self._journal.kept}")
        if self._journal is not None and self._journal.dropped:
            told.append(f"{self._journal.dropped} lines of the journal could not be written: a replay leaves a gap")
        if self._status_file is not None and self._status_file.dropped:
            told.append(f"{self._status_file.dropped} status lines could not be written")
        return told

    def tell(self) -> None:
        """Tell the warnings on the terminal."""
        console = Console(stderr=True, highlight=False)
        for warning in self.warnings():
            console.print(f"note: {warning}", style="yellow", soft_wrap=True, markup=False)


def resident_megabytes() -> Callable[[], float]:
    """A function that tells this process' resident memory [MB]."""
    process = psutil.Process()
    return lambda: float(process.memory_info().rss / 1e6)
