"""Latencies: the delays of a venue as the running show uses them, changed by hand while it runs."""

from dataclasses import dataclass

from live.clock.ticks import TICK
from live.show.venue.venue import Venue


@dataclass(slots=True)
class Latencies:
    """Delays [s]. Thread: the show's; single values may be read from any."""

    input: float = 0.0
    """From the sound that is heard to its samples here."""
    output: float | None = None
    """From samples handed over to the sound that is heard; None: as the device says."""
    display: float = TICK
    """From a picture drawn to the display."""
    projector: float = 0.0

    @classmethod
    def of(cls, venue: Venue | None) -> "Latencies":
        """Those of a venue; the usual ones without."""
        if venue is None:
            return cls()
        one = venue.latency
        return cls(
            one.input_ms / 1000.0,
            None if one.output_ms is None else one.output_ms / 1000.0,
            one.display_ms / 1000.0,
            one.projector_ms / 1000.0,
        )

    @property
    def lead(self) -> float:
        """How far ahead of the clock a picture must be when it is drawn [s]: it is seen so much later."""
        return self.display + self.projector

    def set(self, what: str, seconds: float) -> None:
        """Change one by its name; names there are not are left alone (replays of other versions)."""
        if what in ("input", "output", "display", "projector"):
            setattr(self, what, seconds)

    def facts(self) -> dict[str, float | None]:
        """In milliseconds, for the status."""
        names = ("input", "output", "display", "projector", "lead")
        values = {name: getattr(self, name) for name in names}
        return {f"{name}_ms": None if value is None else round(1000.0 * value, 2) for name, value in values.items()}
