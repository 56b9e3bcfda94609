"""What a soak is asked to run, and what came of it."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from live.rehearse.failure import Failure

GROWTH_MB: Final = 20.0
"""So much memory may change after the first hour (or the first third of a shorter run)."""


@dataclass(frozen=True, slots=True)
class Plan:
    """What is run."""

    patch: Path
    seed: int = 0
    hours: float = 1.0
    fps: float = 16.0
    """Frames per second of the show, on the average."""
    players: int = 8
    calls: float = 6.0
    """What each player does in a minute."""
    faults: float = 1.0
    """How often things go wrong; 1: about once a minute."""


@dataclass(slots=True)
class Report:
    """What came of it."""

    plan: Plan
    seconds: float = 0.0
    """Of the show."""
    took: float = 0.0
    """Of the machine [s]."""
    measures: int = 0
    leapt: int = 0
    frames: int = 0
    skipped: int = 0
    problems: list[str] = field(default_factory=list)
    count: int = 0
    """Problems in all."""
    events: dict[str, int] = field(default_factory=dict)
    refused: dict[str, int] = field(default_factory=dict)
    faults: dict[str, int] = field(default_factory=dict)
    band: dict[str, int] = field(default_factory=dict)
    edits: dict[str, int] = field(default_factory=dict)
    frames_ms: list[dict[str, float]] = field(default_factory=list)
    """In real time: CPU time of frames [ms], late frames and memory, in rows of some seconds."""
    memory: list[tuple[float, float]] = field(default_factory=list)
    """Seconds of the show, resident memory [MB]."""
    objects: list[tuple[float, int]] = field(default_factory=list)
    journal: dict[str, Any] = field(default_factory=dict)
    failures: list[dict[str, Any]] = field(default_factory=list)
    """Exceptions, each with its place and its whole traceback (`Failure.facts`)."""
    replay: dict[str, Any] = field(default_factory=dict)
    status: dict[str, Any] = field(default_factory=dict)
    """The last figures of the show."""

    def fail(self, failure: Failure, what: str = "") -> None:
        """Note an exception: a line among the problems, all of it beside them."""
        self.count += 1
        self.problems.append(f"{what}{failure}")
        self.failures.append(failure.facts())

    @property
    def growth(self) -> float | None:
        """Largest change of memory [MB] after the first hour, or the first third of a shorter run."""
        begin = min(3600.0, self.seconds / 3.0)
        later = [size for time, size in self.memory if time >= begin]
        return max(abs(size - later[0]) for size in later) if later else None

    @property
    def ok(self) -> bool:
        """Whether nothing went wrong."""
        grown = self.growth
        different = self.replay.get("different", 0) or self.replay.get("problems")
        return not self.count and not different and (grown is None or grown <= GROWTH_MB)

    def as_json(self) -> dict[str, Any]:
        """For `--report`."""
        plan = {"patch": str(self.plan.patch), "seed": self.plan.seed, "hours": self.plan.hours, "fps": self.plan.fps}
        facts = {name: getattr(self, name) for name in self.__dataclass_fields__ if name != "plan"}
        speed = self.seconds / self.took if self.took else None
        return {"ok": self.ok, **plan, "speed": speed, "memory_growth_mb": self.growth, **facts}
