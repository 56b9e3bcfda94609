"""Records of a running show: its journal and its status file."""

from collections.abc import Callable
from pathlib import Path

import psutil
from rich.console import Console

from live.app.launch_options import LaunchOptions
from live.app.processes.resume_state import ResumeState
from live.app.session_audio import AudioChoice
from live.base.errors import PersonError
from live.show.engine import Engine
from live.show.journal.journal import JournalError, JournalWriter, disk_problem
from live.show.loader import LoadedShow
from live.show.view.status import Status, StatusFile
from live.supervisor.journal_relay import RelaySink
from live.supervisor.supervisor_link import SupervisorLink


class SessionRecords:
    """Journal and status file of a show. With a supervisor, the supervisor writes the journal. Thread: the show's."""

    def __init__(
        self,
        options: LaunchOptions,
        loaded: LoadedShow,
        sound: AudioChoice,
        *,
        lifeline: SupervisorLink | None,
        resumed: ResumeState | None,
    ) -> None:
        """Write nothing yet. `resumed`: the show that is resumed and whose records already exist."""
        self._options, self._loaded, self._sound = options, loaded, sound
        self._lifeline, self._resumed = lifeline, resumed
        self._journal: JournalWriter | None = None
        self._relay: RelaySink | None = None
        self._status_file: StatusFile | None = None

    def open_status(self, status: Status) -> None:
        """Open the status file, if there is to be one; raise PersonError if it cannot be written."""
        if self._options.status_json is None:
            return
        try:
            self._status_file = StatusFile(self._options.status_json, status, append=self._resumed is not None)
        except OSError as error:
            raise PersonError(f"cannot write --status-json {self._options.status_json}: {error.strerror}") from None

    def open_journal(
        self, engine: Engine, status: Status, *, tempo: float | None, origin: float, audio_start: float | None
    ) -> None:
        """Open the journal. Call this last, so that a failed start does not replace an older journal of that name.

        `tempo` [bpm]: the starting tempo; `origin` [s of perf_counter]: of the show's clock; `audio_start` [s of the
        show]: when the sound began.
        """
        header = self._loaded.header(engine.show, tempo=tempo, music=self._sound.path)
        if self._lifeline is not None:
            self._relay = RelaySink(self._lifeline, self._options.journal)
            header |= {"origin": origin, "begun": audio_start}
            self._journal = JournalWriter(Path(), None if self._resumed else header, sink=self._relay)
        elif self._options.journal is not None:
            try:
                self._journal = JournalWriter(self._options.journal, header)
            except JournalError as error:
                raise PersonError(str(error)) from None
        else:
            return
        self._journal.prepare(engine.show)
        status.extra_figures["journal"] = self._journal.facts
        engine.journal = self._journal

    def problem(self) -> str:
        """Return the problem with the journal; empty if there is none."""
        if self._journal is None:
            return ""
        disk = {} if self._lifeline is None else self._lifeline.facts.get("disk", {})
        return self._journal.problem or disk_problem(disk)

    def frame(self, time: float) -> None:
        """Write the status and flush the journal to the supervisor, after a frame that began at `time` [s]."""
        if self._status_file is not None:
            self._status_file.frame(time)
        if self._relay is not None:
            self._relay.flush()

    def close(self, tick: int, time: float, *, ended: bool = True) -> None:
        """Write the last `tick` and the status of `time` [s]. `ended`: the show has ended normally."""
        if self._journal is not None:
            self._journal.close(tick, ended=ended)
        if self._status_file is not None:
            self._status_file.close(time)

    def warnings(self) -> list[str]:
        """Return the problems that did not stop the show, in words."""
        told = []
        if self._journal is not None and self._journal.older_journal is not None:
            told.append(f"the older journal is now {self._journal.older_journal}")
        if self._journal is not None and self._journal.dropped:
            told.append(f"{self._journal.dropped} lines of the journal could not be written: a replay has a gap")
        if self._status_file is not None and self._status_file.dropped:
            told.append(f"{self._status_file.dropped} status lines could not be written")
        return told

    def print_warnings(self) -> None:
        """Print the warnings on the terminal."""
        console = Console(stderr=True, highlight=False)
        for warning in self.warnings():
            console.print(f"note: {warning}", style="yellow", soft_wrap=True, markup=False)


def resident_megabytes() -> Callable[[], float]:
    """Return a function that measures this process' resident memory [MB]."""
    process = psutil.Process()
    return lambda: float(process.memory_info().rss / 1e6)
