"""Keeps gestures that were learned while a show runs: a thread writes them next to the patch, which then has them."""

import threading
from pathlib import Path
from typing import Any

from live.base.errors import PersonError
from live.base.fault_isolation import FAULTS
from live.show.capture.gesture_learning import LearnedGesture
from live.show.show import Show


class GestureService:
    """Writes each newly learned example to NAME.gestures.toml. Thread: the show's."""

    def __init__(self, show: Show, patch: Path) -> None:
        """`patch`: its file."""
        self._show, self._patch = show, patch
        self._count = show.gestures.learned_count  # those before a resumed show are written already
        self._lock = threading.Lock()
        self._threads: list[threading.Thread] = []
        self.message = ""
        """The result of the last writing, in words; empty before the first."""

    def start(self) -> None:
        """Nothing to open."""

    def stop(self) -> None:
        """Wait until everything is written."""
        for thread in self._threads:
            thread.join()

    def frame(self) -> None:
        """Have the examples written that were learned since the last frame."""
        gestures = self._show.gestures
        new = gestures.learned_count - self._count
        if not new:
            return
        self._count = gestures.learned_count
        learned = tuple(gestures.learned[-new:])
        self._threads = [one for one in self._threads if one.is_alive()]
        self._threads.append(threading.Thread(target=self._write, args=(learned,), name="gestures"))
        self._threads[-1].start()

    def status(self) -> dict[str, Any]:
        """Return the result of the last writing."""
        return {"message": self.message}

    def notice(self) -> str:
        """Return the result of the last writing, in words; empty before the first."""
        return self.message

    def _write(self, learned: tuple[LearnedGesture, ...]) -> None:
        from live.library.whole_file import write_atomically
        from live.show.patch.gesture_files import updated_gestures_text
        from live.show.patch.patch_search_path import gestures_path

        names, path = ", ".join(one.name for one in learned), gestures_path(self._patch)
        try:
            with self._lock:
                text = updated_gestures_text(self._patch, [one.table for one in learned])
                write_atomically(text.encode(), path, "gestures")
        except (PersonError, OSError) as error:
            self.message = f"gesture {names}: NOT SAVED for the next show: {error}"
        except Exception as error:
            FAULTS.record("saving a gesture", error)
            self.message = f"gesture {names}: NOT SAVED for the next show: {type(error).__name__}: {error}"
        else:
            self.message = f"gesture {names}: saved in {path}"
