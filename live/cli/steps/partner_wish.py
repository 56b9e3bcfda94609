"""What is asked of `live partner`."""

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True)
class Wish:
    """The options of the command, checked one by one."""

    leader: Path | None
    examples: Path
    out: Path
    path: Path | None
    online: bool
    stretch: float | None
    k: float | None
    beam: float | None
    rate: float | None
    cluster: float | None
    fps: float | None
    drop_frames: int | None
    bpm: float | None
    first_beat: float | None
    smoothing: str
    hold_feet: bool
    truth: Path | None
    report: Path | None
    transcript: Path | None
    seed: int
    smooth: float | None = None
