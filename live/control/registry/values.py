"""Values: what everything that has a present value is now, as the show said it last, for whoever asks or listens."""

from collections.abc import Iterator, Mapping
from typing import Final

from live.control.registry.control import Plain
from live.control.registry.readings import READINGS
from live.control.registry.registry import REGISTRY

Rows = tuple[tuple[str, tuple[Plain, ...]], ...]
"""A value of all ("", numbers), or that of each group, or of each that a control names, by its name."""
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
        return bool(self.rows(address))

    def rows(self, address: str) -> Rows:
        """The value at an address; empty if it has none now."""
        rows = self._rows.get(address)
        if rows is not None:
            return rows
        kept, whose = REGISTRY.kept_at(address)
        return tuple(("", values) for name, values in self._rows.get(kept, ()) if name == whose) if whose else ()

    def messages(self, address: str) -> Iterator[tuple[str, tuple[Plain, ...]]]:
        """Addresses and values of the messages that would set an address to what it is: one, or one for each group or
        name."""
        control = REGISTRY.find(address)
        for name, values in self.rows(address):
            if control is None or not control.named:
                yield address, (*values, name) if name else values
            elif (own := control.address_of(name)) is not None:
                yield own, values
            else:
                yield address, (name, *values)

    def all(self) -> Changes:
        """Everything that has a value now: a copy."""
        return dict(self._rows)


def changed(before: Changes, now: Changes) -> dict[str, Rows]:
    """What of `now` is not equal to what was `before`."""
    return {address: rows for address, rows in now.items() if before.get(address) != rows}
