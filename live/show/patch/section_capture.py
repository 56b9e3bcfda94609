"""Patch sections for what seen and captured performers bring about: gestures and answers to recognised steps."""

from typing import Annotated, Final, Literal

from pydantic import Field, model_validator

from live.motion.recognition.recognition_names import GESTURE_NAMES, MAX_MOMENTS
from live.show.patch.section_base import Name, Section

MAX_GESTURES: Final = 64
"""Most `[[gesture]]` tables of a patch."""
BuiltIn = Literal[GESTURE_NAMES]  # type: ignore[valid-type]
PackedPose = Annotated[str, Field(min_length=192, max_length=192)]
"""A pose as `live.motion.capture.packed_pose` packs it, which is slow to import."""
Words = Annotated[str, Field(min_length=1, max_length=250)]
AnswerHow = Literal["same", "next", "other", "map"]
Second = Annotated[float, Field(ge=0, le=36000, allow_inf_nan=False)]


class GestureSection(Section):
    """`[[gesture]]`: a movement of a performer that gives a signal, for `[[react]] on`; see `live docs gestures`."""

    name: Name
    """Name of the signal; several tables may share one: then each of them is an example of it, or gives it, too."""
    movement: BuiltIn | None = None
    """A movement that is known: both arms up, left arm up, right arm up, arms wide, crouch, kneel, lie, bow, point
    left, point right, jump, turn or clap; left and right are the performer's own."""
    example: Annotated[str, Field(min_length=1, max_length=250)] | None = None
    """Or a motion file with an example of it, such as a BVH file, looked up in the patch's folder."""
    span_s: tuple[Second, Second] | None = None
    """Where the gesture begins and ends in that file [s]; left out: the whole file."""
    poses: Annotated[tuple[PackedPose, ...], Field(max_length=MAX_MOMENTS)] = ()
    """Or the example itself, 16 packed poses a second, as `/dance/gesture/learn` writes it to NAME.gestures.toml; of a
    file they are filled in when it is read."""
    background: Annotated[tuple[PackedPose, ...], Field(max_length=MAX_MOMENTS)] = ()
    """Poses without the gesture, which keep the example from being found everywhere."""
    performer: Name | None = None
    """The `[[mocap]]` performer who makes it; left out: anybody."""

    @model_validator(mode="after")
    def _one_thing(self) -> "GestureSection":
        if (self.movement is None) == (self.example is None and not self.poses):
            raise ValueError(f"gesture {self.name!r}: either movement, or example, expected")
        if self.span_s is not None and self.example is None:
            raise ValueError(f"gesture {self.name!r}: span_s belongs to an example")
        if self.span_s is not None and self.span_s[1] <= self.span_s[0]:
            raise ValueError(f"gesture {self.name!r}: span_s ends before it begins; write [begin, end]")
        return self


class AnswerSection(Section):
    """`[[answer]]`: call and response with a captured performer: each step that is recognised is answered by dancers;
    see `live docs learn-this`."""

    name: Name
    """Name of the answer, as in `/dance/answer/on`."""
    performer: Name
    """The captured performer, by its name in `[[mocap]]`; `live` if there is none."""
    group: Words = "*"
    """Dancers who answer, such as `mist` or `mist & 13-16`; `*` is all."""
    how: AnswerHow = "same"
    """`same`: the same step in the next measure, recognised before the measure is over; `next`: the same step a measure
    later, as a canon, recognised in the whole measure; `other`: another step of the group; `map`: the step in `map`."""
    map: dict[Name, Name] = Field(default={}, max_length=200)
    """For `how = "map"` the answers by recognised step: `map = { groove = "kick" }`; others are not answered."""
    sure: Annotated[float, Field(ge=0, le=1)] = 0.3
    """Least confidence with which a step is answered."""
    on: bool = True
    """Whether steps are answered from the beginning."""
