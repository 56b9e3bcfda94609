"""Values: what everything that has a present value is now, as the show said it last, for whoever asks or listens."""

from collections.abc import Iterator, Mapping
from typing import Final

from live.control.control import Plain
from live.control.readings import READINGS
from live.control.registry import REGISTRY

Rows = tuple[tuple[str, tuple[Plain, ...]], ...]
"""A value of all ("", numbers), or that of each group by its name."""
Changes = Mapping[str, Rows]
"""What has another value than before, by address."""

READABLE: Final = (
    *(control.address for control in REGISTRY if control.value),
    *(reading.address for reading in READINGS),
)
"""Every address that may have a present value, in the order of the registry."""


class Values:
    """The present values by address. Thread: one writes, any reads."""

    def __init__(self) -> None:
        self._rows: dict[str, Rows] = {}

    def take(self, changes: Changes) -> None:
        """These have new values."""
        self._rows.update(changes)

    def __contains__(self, address: str) -> bool:
        return address in self._rows

    def rows(self, address: str) -> Rows:
        """The value at an address; empty if it has none now."""
        return self._rows.get(address, ())

    def messages(self, address: str) -> Iterator[tuple[Plain, ...]]:
        """The values of the messages that would set an address to what it is: one, or one for each group."""
        for group, values in self.rows(address):
            yield (*values, group) if group else values

    def all(self) -> Changes:
        """Everything that has a value now: a copy."""
        return dict(self._rows)


def changed(before: Changes, now: Changes) -> dict[str, Rows]:
    """What of `now` is not equal to what was `before`."""
    return {address: rows for address, rows in now.items() if before.get(address) != rows}
