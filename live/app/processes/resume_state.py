"""State of a show that another process ran until now."""

from dataclasses import dataclass

from live.show.show import Show


@dataclass(frozen=True, slots=True, eq=False)
class ResumeState:
    """Everything needed to resume a show."""

    show: Show
    tick: int
    """The last tick that was run."""
    origin: float
    """Origin of the show's clock [s of perf_counter]."""
    latencies: dict[str, float]
    """Manually changed delays by name [s]."""
    from_other_machine: bool
    """Whether another machine ran the show: audio and other devices have to be started here."""
    audio_start: float | None
    """When the music began [s of the show]; None without music."""
