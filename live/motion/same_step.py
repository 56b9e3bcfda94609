"""Clips of the same step are aligned by construction: where the samples of one lie in the other (T044, T045)."""

import numpy as np
import numpy.typing as npt

from live.motion.step_clip import StepClip

Float = npt.NDArray[np.floating]


def check_same_step(a: StepClip, b: StepClip) -> None:
    """ValueError, in words for a person, unless both are the same step of the same measures (T040)."""
    if a.step != b.step:
        raise ValueError(f"{a.step!r} and {b.step!r} are different steps; only clips of one step are aligned")
    for field, words in (("measures", "measures"), ("beats_per_measure", "beats in a measure")):
        one, other = getattr(a, field), getattr(b, field)
        if one != other:
            raise ValueError(f"the clips {a.clip.name!r} and {b.clip.name!r} have {one} and {other} {words}")


def check_same_structure(a: StepClip, b: StepClip) -> None:
    """ValueError unless both are the same step in the same structural variation (T046): foot and poses at both ends.

    Where nobody has said which foot leads, a mirrored clip is taken for the other foot.
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


def samples_in(other: StepClip, of: StepClip) -> Float:
    """For each sample of `of`, where the same moment of the step lies in `other`, in fractional samples (T,)."""
    own = np.arange(of.clip.sample_count) - of.first
    return np.asarray(other.first + own * (other.samples_per_measure / of.samples_per_measure))
