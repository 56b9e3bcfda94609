"""How steps are joined and varied: `[locomotion]` and `[motion]`."""

from typing import Annotated, Literal

from pydantic import Field

from live.show.patch.section_base import Section, Share


class LocomotionSection(Section):
    """`[locomotion]`: how steps are joined and how dancers are kept where the group wants them."""

    transition_beats: Annotated[float, Field(gt=0.05, le=1)] = 0.75
    """Length of the blend into the next step, before the measure line (T036)."""
    threshold_m: Annotated[float, Field(gt=0.01, le=2)] = 0.16
    """How far apart two poses may be (root of the mean squared distance) to be joined."""
    correction_m: Annotated[float, Field(ge=0, le=2)] = 0.35
    """How far a dancer may be carried beyond the step's own way within one measure."""
    turn_deg: Annotated[float, Field(ge=0, le=180)] = 50.0
    """How far she may be turned beyond it within one measure."""
    obedience: Share = 0.5
    """0: steps are danced faithfully and dancers are carried beyond them little; 1: they are carried to where the group
    wants them as far as legs reach, within the measure, too."""
    weights: dict[str, Annotated[float, Field(ge=0, le=100)]] = Field(default={})
    """How much joints count when poses are compared, by name; most count 1, hips and feet 2, hands 0.4 (T032)."""
    emphasis: Annotated[float, Field(ge=0, le=1)] = 0.5
    """How much more the pose at the measure line counts than those before it."""


class MotionSection(Section):
    """`[motion]`, or `motion` of a group for that group alone: how much dancers differ, and how motion is mended."""

    warp_beats: Annotated[float, Field(ge=0, le=1)] = 0.1
    """Dancers are ahead of the beat or behind it by this many beats at most, each in her own way (T055)."""
    warp_over: Literal["measure", "sequence"] = "measure"
    """Back on the beat at every measure line, or drifting slowly over several measures (T056)."""
    larger: Annotated[float, Field(ge=-0.7, le=0.5)] = 0.0
    """The upper body moves more than recorded by this share (below 0: less), everybody's alike."""
    amplitude: Annotated[float, Field(ge=0, le=0.5)] = 0.15
    """The upper body moves more or less than recorded by this share (T058)."""
    amplitude_over: Literal["measure", "sequence"] = "measure"
    """Drawn anew for every measure (T060), or changing slowly over several (T059)."""
    mix: Share = 0.0
    """How far another take of the same step is mixed into the whole body at most, drawn for every measure (T045)."""
    arms: Share = 0.0
    """Share of the dancers whose upper body dances another take of the same step (T044)."""
    texture: Share = 0.0
    """How far upper bodies are those of the recordings in `[texture]`, chosen beat by beat by what legs do; 0: as the
    steps have it."""
    head: Share = 0.0
    """How far heads turn to the public, as far as necks allow (T123-T125)."""
    foot_lock: bool = True
    """Feet that carry stay where they are, and no sole goes below the floor."""
    turn_on: Literal["support", "measure"] = "support"
    """Dancers turn on the foot that carries (T048-T050), or evenly over the measure."""
    face: Literal["end", "average"] = "end"
    """What is brought to the wanted heading: the end of each measure, or its average (T122)."""
    mirror: Literal["both", "never", "only"] = "both"
    """Steps and their mirror images, only as they were made, or only mirrored where there are mirror images (T042)."""
