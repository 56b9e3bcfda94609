"""Keeping what MIDI controllers were taught: beside the patch, whole or not at all, in a thread: no frame waits."""

import threading
from collections.abc import Callable, Sequence
from pathlib import Path

from live.base.errors import PersonError
from live.base.fault_isolation import FAULTS
from live.control.midi.midi_binding import Binding


class MidiKeeping:
    """Writes one change after the other. `keep` belongs to the show's thread."""

    def __init__(self, patch: Path, told: Callable[[str], None]) -> None:
        """`patch`: its file. `told` hears in words what became of it, from any thread."""
        self._patch, self._told = patch, told
        self._turn = threading.Lock()
        self._threads: list[threading.Thread] = []

    def keep(self, learned: Sequence[Binding], forgotten: Sequence[str] = ()) -> None:
        """Let the patch have these, and nothing for the controls `forgotten`."""
        self._threads = [one for one in self._threads if one.is_alive()]
        self._threads.append(threading.Thread(target=self._write, args=(learned, forgotten), name="midi map"))
        self._threads[-1].start()

    def _write(self, learned: Sequence[Binding], forgotten: Sequence[str]) -> None:
        from live.app.whole_file import write_whole
        from live.show.patch.learned_midi import changed_learned
        from live.show.patch.patch_search_path import learned_path

        path = learned_path(self._patch)
        try:
            with self._turn:
                write_whole(changed_learned(self._patch, learned, forgotten).encode(), path, "MIDI map")
        except (PersonError, OSError) as error:
            self._told(f"MIDI: NOT KEPT for the next show: {error}")
        except Exception as error:
            FAULTS.note("the keeping of what MIDI was taught", error)
            self._told(f"MIDI: NOT KEPT for the next show: {type(error).__name__}: {error}")
        else:
            self._told(f"MIDI: kept in {path}")

    def wait(self) -> None:
        """Wait until all is written."""
        for thread in self._threads:
            thread.join()
