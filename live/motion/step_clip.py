"""Step clips: one danced step of whole measures with its lead-in (T039, T040, T042), and measurements of it.

Measurements: travel (T040, T131), contacts per beat, foot slide. Clips of the same step are aligned by construction
(T044, T045).
"""

import itertools
import math
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from live.base.arrays import Float, Float64
from live.motion.clip import Clip
from live.motion.forward_kinematics import forward_kinematics
from live.motion.skeleton import SKELETON

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
"""The nine directions of T131 from the dancer's point of view: the dancer's right, not the audience's."""

LeadingFoot = Literal["", "left", "right"]
"""The foot that begins a step; "" if unknown."""


@dataclass(frozen=True, slots=True, eq=False)
class StepClip:
    """One variation of a step: `measures` whole measures of `clip`, preceded by a lead-in for the transition."""

    step: str
    """Name of the step; clips of one name form a cluster (T041)."""
    clip: Clip
    first: float
    """Sample at which the first measure begins; earlier samples are the lead-in."""
    samples_per_measure: float
    measures: int = 1
    beats_per_measure: int = 4
    bpm: float = 120.0
    """Original tempo of the clip."""
    direction: str = "in place"
    """One of DIRECTIONS, as annotated, else as measured."""
    distance_m: float = 0.0
    """Distance travelled from the first to the last measure line [m], as annotated, else as measured."""
    mirrored: bool = False
    """True if this is the mirror image of the recording or sketch (T042)."""
    leading_foot: LeadingFoot = ""
    """Structural variation (T042, T046)."""
    begin_pose: str = ""
    """Name of the pose in which the step begins (T136); "" may follow any pose."""
    end_pose: str = ""
    """Name of the pose in which the step ends (T136); "" may lead to any pose."""
    weight_transfer: bool = False
    """True if the weight ends on the other foot, so that a repeat must be mirrored (T135)."""
    author: str = ""
    """The dancer or author."""
    style: str = ""
    """Stylistic variation in one word."""
    tags: tuple[str, ...] = ()
    mood: tuple[float, ...] = ()
    """The mood in which it was danced, from -1 to 1 in the order of MOODS: an example of the mood, never danced itself
    (T143). Empty: none."""
    recorded: bool = False
    """True if it was cut out of a recording: it is danced near its `bpm` only (`editing/tempo_forms.py`)."""
    tempo_form: Literal["", "half time", "double time"] = ""
    """How a recorded step was changed for a show of another tempo."""
    in_stream: bool = False
    """True for a measure of an unsegmented recording (T037): its neighbours are not takes of the same step."""
    variation: int = 0
    """Number of the made variation (T142) that it is: a take that is only mixed into its step; 0 for a step itself."""
    hands: tuple[tuple[float, str, str], ...] = ()
    """Hand shapes (`live.base.body.hand_shapes`): beat from its start, shape of the left and of the right hand, in the
    order of beats; each stays until the next, "" is no shape of its own."""

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
    def unjoined(self) -> bool:
        """Whether it is never danced by itself: a variation, or an example of a mood."""
        return self.variation > 0 or bool(self.mood)

    @property
    def beats(self) -> int:
        """Length in beats."""
        return self.measures * self.beats_per_measure


def moved_shapes(
    hands: tuple[tuple[float, str, str], ...], *, scale: float = 1.0, by: float = 0.0
) -> tuple[tuple[float, str, str], ...]:
    """Return hand shapes at `scale` times their beats and `by` beats later.

    One that would begin before beat 0 begins there, unless the next one has begun by then.
    """
    moved = [(scale * beat + by, left, right) for beat, left, right in hands]
    begun = [(0.0, *shapes) for beat, *shapes in moved if beat <= 0.0][-1:]
    return (*begun, *(each for each in moved if each[0] > 0.0))  # type: ignore[arg-type]


IN_PLACE_DISTANCE: Final = 0.15
"""A step that travels less than this per measure [m] counts as in place."""
LONG_DISTANCE: Final = 0.55
"""A step that travels farther than this per measure [m] counts as long (T131: sketches travel 0.35 or 0.75)."""
FEET: Final = tuple((SKELETON.index(f"{side}Foot"), SKELETON.index(f"{side}Toes")) for side in ("left", "right"))
"""Ankle and toes of the left and the right foot, as joints of the skeleton."""


def travel(step: StepClip) -> Float64:
    """Return the travel of the hips (x, z) [m] from the first to the last measure line, in the clip's axes, shape
    (2,)."""
    ends = np.array((step.first, step.first + step.measures * step.samples_per_measure))
    low = np.clip(ends.astype(np.int64), 0, step.clip.sample_count - 1)
    high = np.minimum(low + 1, step.clip.sample_count - 1)
    part = (ends - low)[:, None]
    root = step.clip.root_position.astype(np.float64)
    begin, end = ((1.0 - part) * root[low] + part * root[high])[:, (0, 2)]
    return np.asarray(end - begin, np.float64)


def measured_distance(step: StepClip) -> float:
    """Return the length of `travel` [m]."""
    return float(np.hypot(*travel(step)))


def measured_direction(step: StepClip) -> str:
    """Return the DIRECTIONS entry (T131) nearest to the travel; clips begin facing +z, the dancer's left is +x."""
    x, z = travel(step)
    distance = math.hypot(x, z) / step.measures
    if distance < IN_PLACE_DISTANCE:
        return "in place"
    size = "short" if distance < LONG_DISTANCE else "long"
    if abs(z) >= abs(x):
        return f"{size} {'forward' if z > 0 else 'back'}"
    return f"{size} {'left' if x > 0 else 'right'}"


def beat_contacts(step: StepClip) -> Float64:
    """Return the share of each beat in which the left and the right foot are in contact, 0 to 1, shape (beats, 2)."""
    per_beat = step.samples_per_measure / step.beats_per_measure
    edges = np.round(step.first + np.arange(step.beats + 1) * per_beat).astype(np.int64)
    edges = np.clip(edges, 0, step.clip.sample_count - 1)
    return np.stack(
        [step.clip.contact[low : max(high, low + 1)].mean(axis=0) for low, high in itertools.pairwise(edges)]
    )


def foot_slide(step: StepClip) -> float | None:
    """Return the mean horizontal speed [m/s] of the feet in contact; None without contact.

    The slower of heel and ball counts, as in the report of a film.
    """
    first, last = int(step.first), math.ceil(step.first + step.measures * step.samples_per_measure)
    part = slice(first, last + 1)
    position, _ = forward_kinematics(
        step.clip.root_position[part].astype(np.float64), step.clip.rotation[part].astype(np.float64)
    )
    feet = position[:, np.array(FEET)]  # (T, foot, heel or ball, 3)
    moved = np.hypot(*np.diff(feet, axis=0)[..., (0, 2)].transpose(3, 0, 1, 2)) * step.clip.sample_rate
    stands = step.clip.contact[part][1:] & step.clip.contact[part][:-1]
    speed = moved.min(axis=-1)[stands]
    return float(speed.mean()) if len(speed) else None


def check_same_step(a: StepClip, b: StepClip) -> None:
    """Raise ValueError with a readable message unless both are the same step of equal measures (T040)."""
    if a.step != b.step:
        raise ValueError(f"{a.step!r} and {b.step!r} are different steps; only clips of one step are aligned")
    for field, words in (("measures", "measures"), ("beats_per_measure", "beats in a measure")):
        one, other = getattr(a, field), getattr(b, field)
        if one != other:
            raise ValueError(f"the clips {a.clip.name!r} and {b.clip.name!r} have {one} and {other} {words}")


def check_same_structure(a: StepClip, b: StepClip) -> None:
    """Raise ValueError unless both are the same step in the same structural variation (T046): foot and end poses.

    If a leading foot is unknown, `mirrored` is compared instead.
    """
    check_same_step(a, b)
    fields = ["begin_pose", "end_pose", "weight_transfer"]
    fields.insert(0, "leading_foot" if a.leading_foot and b.leading_foot else "mirrored")
    for field in fields:
        one, other = getattr(a, field), getattr(b, field)
        if one != other:
            words = field.replace("_", " ")
            raise ValueError(
                f"the clips {a.clip.name!r} and {b.clip.name!r} differ in structure: {words} is {one!r} and {other!r}; "
                "interpolate clips that begin on the same foot and share their poses"
            )


def corresponding_samples(other: StepClip, step: StepClip) -> Float:
    """For each sample of `step`, return the corresponding fractional sample of `other`, (T,)."""
    own = np.arange(step.clip.sample_count) - step.first
    return np.asarray(other.first + own * (other.samples_per_measure / step.samples_per_measure))
