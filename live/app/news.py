"""What an operator without the overlay must know while the show runs: what was refused, and what has joined."""

import threading
from collections.abc import Callable, Sequence
from typing import Final

from live.base.fault_isolation import Bulkhead, keep_running, name_of

PERIOD_S: Final = 1.0
"""Seconds between two looks: whoever floods the inputs fills a terminal with a line a second, no faster."""
Words = Callable[[], str]


class News:
    """Says what is new in words that change, by a thread of its own: a stuck terminal holds no show up.

    Thread: `look` is called by the thread alone once it runs; `refused` may be read by any.
    """

    def __init__(self, refusals: Sequence[Words], others: Sequence[Words], say: Callable[[str], None]) -> None:
        """Each of `refusals` is the last refusal of one part, of `others` its last news; empty if there is none."""
        self._refusals, self._others, self._say = refusals, others, say
        self._before = [""] * (len(refusals) + len(others))
        self.refused = ""
        """The last refusal of all parts: the one whose words have changed last."""
        self._calls = Bulkhead()
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name="news", daemon=True)

    def start(self) -> None:
        """Begin to look."""
        self._thread.start()

    def stop(self) -> None:
        """End, and say what is new since the last look."""
        self._ended.set()
        if self._thread.is_alive():
            self._thread.join(timeout=2.0)
        if not self._thread.is_alive():
            self.look()

    def look(self) -> None:
        """Look once, and say what has changed."""
        for index, words in enumerate([*self._refusals, *self._others]):
            now, before = self._calls.call(f"what {name_of(words)} has to tell", words) or "", self._before[index]
            if now == before:
                continue
            self._before[index] = now
            refusal = index < len(self._refusals)
            if refusal and (now or self.refused == before):
                self.refused = now
            if now:
                self._say(f"refused: {now}" if refusal else now)

    def _run(self) -> None:
        keep_running("the news on the terminal", self._look_on, self._ended.wait)

    def _look_on(self) -> None:
        while not self._ended.wait(PERIOD_S):
            self.look()
