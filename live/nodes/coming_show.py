"""A show that a node joins: its state is built in a thread, and it is then run up to the leader's tick in small pieces,
while what was drawn before goes on.

Restoring a snapshot takes some tenths of a second of processor time, and seconds if the steps have changed since the
show began. The thread releases the interpreter often (`live/show/background_work.py`), as the one that prepares an
edited patch does. It runs no tick: those are run by the thread that draws, a few in each frame.
"""

import threading
import time
from collections import deque
from collections.abc import Callable, Iterable
from functools import partial

from live.base.fault_isolation import run_once
from live.control.message_codec import PacketError
from live.show.background_work import short_switch_interval
from live.show.loader import LoadedShow
from live.supervisor.heartbeat import Heartbeat
from live.supervisor.network.peer_messages import read_line
from live.supervisor.network.show_stream import is_show_line
from live.supervisor.state_follower import StateFollower, check_show

Aside = Callable[[Callable[[], None]], None]
"""Does a task beside the thread that draws."""


def do_in_thread(task: Callable[[], None]) -> None:
    """Do a task in a thread of its own."""
    threading.Thread(target=partial(run_once, "joining a show", task), name="join", daemon=True).start()


class ComingShow:
    """A show from its snapshot on, until it can be drawn. Thread: the one that draws."""

    def __init__(
        self, loaded: LoadedShow, lines: Iterable[str], *, heartbeat: Heartbeat | None = None,
        aside: Aside = do_in_thread,
    ) -> None:  # fmt: skip
        """`lines`: as a leader sends them to who joins: the first line of the show, its last snapshot if there is one,
        and those since. `heartbeat`: of this process."""
        self.following = StateFollower(loaded, heartbeat=heartbeat, keeps_lines=False)
        """The state; not before it is `built`."""
        self.refused = 0
        """Lines that were invalid, ..."""
        self.ended = False
        """... and whether the show has ended."""
        self._waiting = deque[str]()
        self._error: Exception | None = None
        self._built = threading.Event()
        aside(partial(self._build, tuple(lines)))

    def _build(self, lines: Iterable[str]) -> None:
        """Thread: another one. Until the state has been built, nothing else uses it."""
        try:
            with short_switch_interval():
                for line in lines:
                    self._feed(line)
                check_show(self.following)
                self.following.build()
        except Exception as error:  # raised again in the thread that draws
            self._error = error
        finally:
            self._built.set()

    def _feed(self, line: str) -> None:
        try:
            self.ended |= feed(self.following, line)
        except PacketError:
            self.refused += 1

    def add_line(self, line: str) -> None:
        """Add a later line."""
        self._waiting.append(line)

    @property
    def built(self) -> bool:
        """Whether ticks can be run."""
        return self._built.is_set()

    def run_until(self, tick: int, deadline: float, *, now: Callable[[], float] = time.perf_counter) -> bool:
        """Run the ticks and lines that have come, as `StateFollower.run_until` does, once it is `built`; return whether
        all of that is done.

        PersonError if it is another show than the one loaded here, ReplayError if it cannot be run here.
        """
        if self._error is not None:
            raise self._error
        while self._waiting:
            self._feed(self._waiting.popleft())
        return self.following.run_until(tick, deadline, now=now)


def feed(following: StateFollower, line: str) -> bool:
    """Give a line from another machine to a state; return whether the show ends with it.

    PacketError if it can be no line of a show.
    """
    told = read_line(line)
    if not is_show_line(told, begun=bool(following.header), tick=following.granted):
        raise PacketError("no line of a show")
    if told.get("end"):
        return True
    following.add_line(line)
    return False
