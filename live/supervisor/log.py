"""Log: what another engine needs to go on with the show: the first line, the last snapshot and all lines since."""

import json
from collections.abc import Iterator
from typing import Any, Final

from live.show.journal.skipped_events import LEFT_OUT, SINCE, without_the_last

CHANGES: Final = ("PatchChanged", "StepsAdded", "StepsChanged")
"""Events after which a snapshot can be read only by who has seen them."""
TICK: Final = '{"tick":'
FRONT: Final = 48
"""Characters within which the second key of a line begins."""
READ: Final = (*CHANGES, '"snapshot"', f'"{LEFT_OUT}"', '"end"')
"""Lines with these words are looked into."""


class Log:
    """Takes the lines of a running show's journal and keeps as few of them as will do.

    Without snapshots that is all of them (about 3 MB an hour), and so it is once patch or steps have changed: the last
    snapshot from before is kept then, and all that came after. Lines that only say how far the ticks are, are not kept:
    only the last one counts. Times of the show mean nothing to another process, so the clock's origin is kept, too.
    """

    def __init__(self) -> None:
        self.header: str = ""
        """The journal's first line; empty before the show has begun."""
        self.tick = 0
        """The last tick that was told."""
        self.measures = 0
        self.events = 0
        self._snapshot = ""
        self._changed = False
        self._lines: list[tuple[int, str]] = []

    def take(self, line: str) -> bool:
        """Take one line of the show; True if it belongs into a journal on disk. Lines that are no JSON are refused."""
        try:
            value = json.loads(line)
        except ValueError:
            return False
        if not isinstance(value, dict):
            return False
        if "journal" in value:
            first = not self.header
            if first:
                self.header = line
            return first
        tick = value.get("tick")
        if not isinstance(tick, int):
            return False
        return self._take(value, tick, line)

    def note(self, line: str) -> None:
        """Take one line that this process has made itself, compact and in order, without reading it as JSON.

        Lines that only say how far the ticks are belong to `tick`.
        """
        if line.startswith('{"journal"'):
            self.header = self.header or line
            return
        end = line.find(",", len(TICK))
        if not line.startswith(TICK) or not line[len(TICK) : end].isdigit() or any(name in line for name in READ):
            self.take(line)
            return
        tick = int(line[len(TICK) : end])
        self.tick = max(self.tick, tick)
        event = line.find('"event"', 0, FRONT) >= 0
        self.events += event
        self.measures += not event and '"measure"' in line[:FRONT]
        self._lines.append((tick, line))

    def _take(self, value: dict[str, Any], tick: int, line: str) -> bool:
        if "snapshot" in value:
            if not self._changed:
                self._snapshot = line
                self._lines = [one for one in self._lines if one[0] > tick or (one[0] == tick and '"event"' in one[1])]
            return True
        self.tick = max(self.tick, tick)
        if isinstance(since := value.get(SINCE), int):  # who goes on from here dances anew what came since
            self._lines = [one for one in self._lines if one[0] <= since or '"measure"' not in one[1]]
            value = {key: each for key, each in value.items() if key != SINCE} | {"tick": since}
            place = sum(one[0] <= since for one in self._lines)
            self._lines.insert(place, (since, json.dumps(value, separators=(",", ":"))))
            return True
        if LEFT_OUT in value:  # who goes on from here leaves them out as well
            self._lines = without_the_last(self._lines, value[LEFT_OUT])
            return True
        if len(value) == 1:
            return False
        if "event" in value:
            self.events += 1
            event = value["event"]
            self._changed = self._changed or (isinstance(event, dict) and event.get("type") in CHANGES)
        self.measures += "measure" in value
        if not value.get("end"):
            self._lines.append((tick, line))
        return True

    def since(self) -> Iterator[str]:
        """All that a follower needs, in order; the last line says how far the ticks are."""
        if not self.header:
            return
        yield self.header
        if self._snapshot:
            yield self._snapshot
        yield from (line for _, line in self._lines)
        yield json.dumps({"tick": self.tick})
