"""Seats: which performer a sender of live motion capture is: by the port she sends to, by her machine, or by turn."""

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Final

ALONE: Final = "live"
"""The performer's name where the patch names none."""
GONE_AFTER: Final = 2.0
"""Who has sent nothing for so long [s] leaves her place to another sender."""


@dataclass(frozen=True, slots=True)
class Seat:
    """A performer of the patch, and what is said of where she sends from."""

    name: str
    port: int = 0
    """Her own port here; 0: any."""
    sender: str = ""
    """The address of her machine; empty: any."""
    floor: bool = True
    """Whether her feet are brought down to the floor."""

    def suits(self, port: int, host: str) -> bool:
        """Whether a sender at `host` who sends to `port` may be her."""
        return self.port in (0, port) and self.sender in ("", host)

    @property
    def exactness(self) -> int:
        """How much is said: who is meant exactly comes first."""
        return 2 * bool(self.sender) + bool(self.port)


class Seats:
    """Who sits where. Thread: one."""

    def __init__(self, seats: tuple[Seat, ...]) -> None:
        """Without any there is one, `ALONE`."""
        self._seats = sorted(seats or (Seat(ALONE),), key=lambda seat: -seat.exactness)
        self._taken: dict[str, tuple[Hashable, float]] = {}

    def find(self, who: Hashable, port: int, host: str, now: float) -> Seat | None:
        """The seat of the sender `who`, at `host`, who sends to `port` at `now` [s]; None if there is none for her."""
        free = None
        for seat in self._seats:
            if not seat.suits(port, host):
                continue
            owner, last = self._taken.get(seat.name, (None, -GONE_AFTER))
            if owner == who:
                self._taken[seat.name] = who, now
                return seat
            if free is None and now - last >= GONE_AFTER:
                free = seat
        if free is not None:
            self._taken[free.name] = who, now
        return free
