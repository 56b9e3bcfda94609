"""Keeping how outputs are bent: into the venue's file, whole or not at all, in a thread so that no frame waits."""

import threading
from collections.abc import Callable, Mapping
from pathlib import Path

from live.base.errors import PersonError
from live.base.fault_isolation import FAULTS
from live.render.outputs.output import Output


class OutputKeeping:
    """Writes one output after the other. `keep` belongs to the main thread."""

    def __init__(self, venue: str | None, told: Callable[[str], None]) -> None:
        """`venue`: its name; without one nothing can be kept. `told` hears in words what became of it, from any
        thread."""
        self._venue, self._told = venue, told
        self._turn = threading.Lock()
        self._threads: list[threading.Thread] = []

    def keep(self, output: Output) -> None:
        """Let this output be as it is now from the next start on."""

        def text(path: Path, venue: str) -> str:
            from live.show.venue.venue_output_writer import changed_output

            return changed_output(path, venue, output)

        self._begin(text)

    def keep_values(self, values: Mapping[str, Mapping[str, object]]) -> None:
        """Let the venue say these values, by table and key, from the next start on."""

        def text(path: Path, venue: str) -> str:
            from live.show.venue.venue_file import changed_venue

            return changed_venue(path, venue, values, "# pointed at on the projector")

        self._begin(text)

    def _begin(self, text: Callable[[Path, str], str]) -> None:
        if self._venue is None:
            self._told("not kept: start with --venue NAME")
            return
        self._threads = [one for one in self._threads if one.is_alive()]
        self._threads.append(threading.Thread(target=self._write, args=(text, self._venue), name="venue"))
        self._threads[-1].start()

    def _write(self, text_of: Callable[[Path, str], str], venue: str) -> None:
        from live.app.whole_file import write_whole
        from live.show.venue.venue import venue_path

        path = venue_path(venue)
        try:
            with self._turn:
                text = text_of(path, venue)
                path.parent.mkdir(parents=True, exist_ok=True)
                write_whole(text.encode(), path, "--venue")
        except (PersonError, OSError) as error:
            self._told(f"NOT KEPT: {error}; Enter tries again")
        except Exception as error:
            FAULTS.note("the keeping of outputs", error)
            self._told(f"NOT KEPT: {type(error).__name__}: {error}; Enter tries again")
        else:
            self._told(f"kept in {path}")

    def wait(self) -> None:
        """Wait until all is written."""
        for thread in self._threads:
            thread.join()
