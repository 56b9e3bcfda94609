"""What gateways share about phones: groups, so that one group has one voice, and which gateway a phone is at.

The table is exact. It is bounded by what each gateway may have: a gateway that tells of more is not believed.
"""

from collections.abc import Iterable
from typing import Any, Final

from live.control.audience.phone_registry import MOST_NUMBER
from live.control.shards.messages import MAX_ROWS, GroupRow, ShardOthers

SPARE_GROUPS: Final = 1024
"""A gateway may have twice as many groups as phones, and so many more: crowded ones without phones."""


class SharedGroups:
    """Groups and phones of all gateways, which are named. Thread: one."""

    def __init__(self) -> None:
        self._rows: dict[int, dict[str, tuple[int, int, float]]] = {}
        self._of: dict[str, dict[int, None]] = {}
        self._joined: dict[str, int] = {}
        self._at: dict[int, str] = {}
        self._numbers: dict[str, int] = {}
        self._due: dict[str, dict[int, None]] = {}
        self._gone: dict[str, dict[int, None]] = {}

    def update_groups(self, shard: str, rows: Iterable[GroupRow], capacity: int, latest: float) -> int:
        """Take a gateway's rows; return how many were not believed. `latest`: until then at most a group may be crowded
        [s of the show]."""
        own = self._of.setdefault(shard, {})
        refused = 0
        for key, phones, joined, until in rows:
            fits = 0 <= phones <= capacity and 0 <= joined <= capacity and until <= latest
            before = self._rows.get(key, {}).get(shard, (0, 0, -1.0))
            count = self._joined.get(shard, 0) + phones - before[0]
            full = phones > before[0] and count > capacity
            if not fits or full or (key not in own and len(own) >= 2 * capacity + SPARE_GROUPS):
                refused += 1
                continue
            self._joined[shard] = count
            there = self._rows.setdefault(key, {})
            if phones or joined or until > 0.0:
                there[shard] = (phones, joined, until)
                own[key] = None
            else:
                there.pop(shard, None)
                own.pop(key, None)
                if not there:
                    del self._rows[key]
            for other in there:
                if other != shard or len(there) > 1:
                    self._due.setdefault(other, {})[key] = None
        return refused

    def update_numbers(self, shard: str, came: Iterable[int], went: Iterable[int], capacity: int) -> int:
        """Take which phones came to a gateway and went; return how many were not believed."""
        refused = 0
        for number in went:
            if self._at.get(number) == shard:
                del self._at[number]
                self._numbers[shard] -= 1
        for number in came:
            before = self._at.get(number)
            if before == shard:
                continue
            if not 0 < number < MOST_NUMBER or self._numbers.get(shard, 0) >= capacity:
                refused += 1
                continue
            if before is not None:
                self._numbers[before] -= 1
                self._gone.setdefault(before, {})[number] = None
            self._gone.get(shard, {}).pop(number, None)
            self._at[number] = shard
            self._numbers[shard] = self._numbers.get(shard, 0) + 1
        return refused

    def remove(self, shard: str) -> None:
        """Forget a gateway."""
        self.update_groups(shard, [(key, 0, 0, -1.0) for key in list(self._of.get(shard, ()))], 0, 0.0)
        self._at = {number: at for number, at in self._at.items() if at != shard}
        tables: tuple[dict[str, Any], ...] = self._of, self._joined, self._numbers, self._due, self._gone
        for table in tables:
            table.pop(shard, None)

    def pop_others(self, shard: str) -> ShardOthers | None:
        """Return what a gateway has to know that it was not told yet, `MAX_ROWS` of each at most; None if nothing."""
        due, gone = self._due.get(shard, {}), self._gone.get(shard, {})
        if not due and not gone:
            return None
        keys, numbers = list(due)[:MAX_ROWS], list(gone)[:MAX_ROWS]
        for key in keys:
            del due[key]
        for number in numbers:
            del gone[number]
        return ShardOthers(tuple(self._others(shard, key) for key in keys), tuple(numbers))

    def _others(self, shard: str, key: int) -> GroupRow:
        there = [row for other, row in self._rows.get(key, {}).items() if other != shard]
        until = max((row[2] for row in there), default=-1.0)
        return key, sum(row[0] for row in there), sum(row[1] for row in there), until
