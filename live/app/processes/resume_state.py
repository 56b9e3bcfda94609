"""Resumed: a show that another process danced until now."""

from dataclasses import dataclass, field

from live.show.show import Show


@dataclass(frozen=True, slots=True, eq=False)
class Resumed:
    """Where it stands, and what is needed to go on with it."""

    show: Show
    tick: int
    """The last tick that was run."""
    origin: float
    """Of the show's clock [s of perf_counter]."""
    latencies: dict[str, float] = field(default_factory=dict)
    """Delays that were changed by hand, by name [s]."""
    calm: bool = False
    """Without sound and other clocks: too much went wrong."""
    elsewhere: bool = False
    """Whether another machine danced it: sound and other devices are to be begun here."""
    begun: float | None = None
    """When the music began [s of the show]; None if none plays."""
