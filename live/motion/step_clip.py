"""StepClip: a clip that holds one danced step of whole measures, with the lead-in before it (T039, T040, T042)."""

from dataclasses import dataclass
from typing import Final, Literal

from live.motion.clip import Clip

DIRECTIONS: Final = (
    "in place",
    "short forward",
    "short right",
    "short left",
    "short back",
    "long forward",
    "long right",
    "long left",
    "long back",
)
"""The nine directions of T131, as the dancer sees them: her right, not the audience's."""

LeadingFoot = Literal["", "left", "right"]
"""The foot that begins a step; "" where nobody has said."""


@dataclass(frozen=True, slots=True, eq=False)
class StepClip:
    """One variation of a step: `measures` whole measures of `clip`, preceded by a lead-in for the transition."""

    step: str
    """Name of the step; clips of one name form a cluster (T041)."""
    clip: Clip
    first: float
    """Sample at which the first measure begins; the samples before it are the lead-in."""
    samples_per_measure: float
    measures: int = 1
    beats_per_measure: int = 4
    bpm: float = 120.0
    """Tempo at which the clip plays at its own speed."""
    direction: str = "in place"
    """One of DIRECTIONS: as written, else as measured."""
    distance_m: float = 0.0
    """Length of the way from the first to the last measure line [m], as written, else as measured."""
    mirrored: bool = False
    """True if this is the mirror image of what was recorded or sketched (T042)."""
    leading_foot: LeadingFoot = ""
    """Structural variation (T042, T046)."""
    begin_pose: str = ""
    """Name of the pose in which it begins (T136); "" follows any."""
    end_pose: str = ""
    """Name of the pose in which it ends (T136); "" leads to any."""
    weight_transfer: bool = False
    """True if the weight ends on the other foot, so that a repeat must be danced on the other side (T135)."""
    author: str = ""
    """Who danced or wrote it."""
    style: str = ""
    """Stylistic variation in a word: how it is danced."""
    tags: tuple[str, ...] = ()
    in_stream: bool = False
    """True for a measure of a recording that nobody has cut into steps (T037): its neighbours are no takes of it."""

    def __post_init__(self) -> None:
        end = self.first + self.measures * self.samples_per_measure
        if self.first < 0 or self.measures < 1 or self.samples_per_measure <= 0:
            raise ValueError(f"step {self.step!r}: first {self.first}, {self.measures} measures")
        if end > self.clip.sample_count - 1 + 1e-6:
            raise ValueError(
                f"step {self.step!r}: {self.measures} measures end at sample {end:.1f}, "
                f"but the clip {self.clip.name!r} ends at {self.clip.sample_count - 1}"
            )

    @property
    def beats(self) -> int:
        """Length in beats."""
        return self.measures * self.beats_per_measure
