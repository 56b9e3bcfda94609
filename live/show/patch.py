"""Patch: what a choreographer writes for a show, as one frozen value; the TOML keys are the field names.

Metres, seconds, beats, bpm, degrees; measures count from 1. `patch_file` reads it and explains what is wrong.
"""

import re
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

Far = Annotated[float, Field(ge=-1000, le=1000, allow_inf_nan=False)]
Place = tuple[
    Annotated[float, Field(ge=-100, le=100, allow_inf_nan=False)],
    Annotated[float, Field(ge=-100, le=100, allow_inf_nan=False)],
]
Share = Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)]
Colour = tuple[Share, Share, Share]
Name = Annotated[str, Field(min_length=1, max_length=64)]
Size = tuple[
    Annotated[float, Field(ge=1, le=100, allow_inf_nan=False)],
    Annotated[float, Field(ge=1, le=100, allow_inf_nan=False)],
]

_REPEATED = re.compile(r"^(?P<step>.*?)(?:\s+x\s*(?P<times>[0-9]{1,3}))?$")


class Section(BaseModel):
    """A table of a patch: frozen, unknown keys refused."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)


class MusicSection(Section):
    """`[music]`: what is played when no `--audio` is given."""

    file: str | None = None
    """An audio file, looked up in the patch's folder, then in the project's patches."""
    bpm: Annotated[float, Field(ge=20, le=400)] | None = None
    """Its tempo if it is known: the clock starts with it."""
    one_at_s: Annotated[float, Field(ge=0, le=3600, allow_inf_nan=False)] | None = None
    """Where its first downbeat is, if that is known."""


class SoundSection(Section):
    """`[sound]`: what a film of `live render` is heard with beside the music (T130)."""

    click: bool = False
    """A click on every beat, another one on the first of each measure."""
    taps: bool = False
    """The sound of tap shoes wherever a foot comes down."""


class ClockSection(Section):
    """`[clock]`: musical time while nothing is heard."""

    bpm: Annotated[float, Field(ge=20, le=400)] = 112.0
    """Tempo of the internal clock."""
    beats_per_measure: Annotated[int, Field(ge=1, le=16)] = 4
    """Beats of a measure; all steps must have it."""


class StageSection(Section):
    """`[stage]`: size of the floor."""

    width: Annotated[float, Field(ge=2, le=200)] = 12.0
    """Metres from side to side."""
    depth: Annotated[float, Field(ge=2, le=200)] = 8.0
    """Metres from back to front."""


class CameraSection(Section):
    """`[camera]`: where the picture is seen from [m], vertical field of view [degrees]."""

    eye: tuple[Far, Far, Far] = (0.0, 3.4, 11.5)
    """Where the camera stands: x, y (up), z [m]."""
    target: tuple[Far, Far, Far] = (0.0, 0.9, 0.0)
    """What it looks at [m]."""
    field_of_view_deg: Annotated[float, Field(ge=5, le=120)] = 40.0
    """Vertical angle of view."""

    @model_validator(mode="after")
    def _look_somewhere(self) -> "CameraSection":
        if sum((a - b) ** 2 for a, b in zip(self.eye, self.target, strict=True)) < 1e-6:
            raise ValueError("eye and target are the same point: the camera looks nowhere")
        return self


class LookSection(Section):
    """`[look]`: light and colour (linear RGB from 0 to 1); what is left out keeps its default."""

    background: Colour | None = None
    """Colour of the dark behind the stage."""
    floor: Colour | None = None
    """Colour of the floor."""
    key_light: Colour | None = None
    """Colour of the light from the front, which casts the shadows."""
    rim_light: Colour | None = None
    """Colour of the light from behind."""
    ambient: Share | None = None
    """Strength of the light from everywhere."""
    haze: Annotated[float, Field(ge=0, le=1)] | None = None
    """How fast the depth of the stage fades [1/m]."""


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
    weights: dict[str, Annotated[float, Field(ge=0, le=100)]] = {}
    """How much joints count when poses are compared, by name; most count 1, hips and feet 2, hands 0.4 (T032)."""
    emphasis: Annotated[float, Field(ge=0, le=1)] = 0.5
    """How much more the pose at the measure line counts than those before it."""


class MotionSection(Section):
    """`[motion]`, or `motion` of a group for that group alone: how much dancers differ, and how motion is mended."""

    warp_beats: Annotated[float, Field(ge=0, le=1)] = 0.1
    """Dancers are ahead of the beat or behind it by this many beats at most, each in her own way (T055)."""
    warp_over: Literal["measure", "sequence"] = "measure"
    """Back on the beat at every measure line, or drifting slowly over several measures (T056)."""
    amplitude: Annotated[float, Field(ge=0, le=0.5)] = 0.15
    """The upper body moves more or less than recorded by this share (T058)."""
    amplitude_over: Literal["measure", "sequence"] = "measure"
    """Drawn anew for every measure (T060), or changing slowly over several (T059)."""
    mix: Share = 0.0
    """How far another take of the same step is mixed into the whole body at most, drawn for every measure (T045)."""
    arms: Share = 0.0
    """Share of the dancers whose upper body dances another take of the same step (T044)."""
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


class GroupSection(Section):
    """`[[group]]`: some dancers who dance alike."""

    name: Name
    """Every group needs its own."""
    dancers: Annotated[int, Field(ge=1, le=4000)]
    """How many dancers it has."""
    colour: Colour | None = None
    """Colour of their clothes."""
    steps: Annotated[tuple[str, ...], Field(min_length=1, max_length=10000)]
    """Steps in order, one after the other and again from the start; "groove x4" repeats one. With
    `choose = "random"` the set from which steps are drawn."""
    choose: Literal["sequence", "random"] = "sequence"
    """Steps in their order, or drawn by seeded chance, never the same twice in a row."""
    travel_step: str | None = None
    """The step danced instead when the way is farther than the step in turn can go."""
    facing: Literal["public", "path", "centre"] = "public"
    """Where dancers face when a measure ends: the public, along their way, or the group's centre."""
    formation: Literal["grid", "line", "circle"] = "grid"
    """The shape in which the group begins."""
    centre: Place = (0.0, 0.0)
    """Its middle (x, z) [m]."""
    size: Size = (8.0, 5.0)
    """Width and depth of the formation [m]."""
    motion: MotionSection | None = None
    """Keys as in `[motion]`, for this group alone; what is left out is as there."""

    @field_validator("steps")
    @classmethod
    def _known_form(cls, steps: tuple[str, ...]) -> tuple[str, ...]:
        for entry in steps:
            name, times = parse_entry(entry)
            if not name or times < 1:
                raise ValueError(f"{entry!r} is no step: write a step's name, or 'groove x4' to repeat it")
        return steps


class ElementSection(Section):
    """`[[element]]`: an attractor, repulsor or spreader of the score, in measures from 1 (T132)."""

    kind: Literal["attract", "repel", "spread"]
    """Gather at a place, leave it, or spread over the stage."""
    measure: Annotated[float, Field(ge=1, le=100000)]
    """The measure at which it begins."""
    measures: Annotated[float, Field(gt=0, le=10000)] = 4.0
    """How many measures it lasts; it fades in and out over a beat."""
    at: Place = (0.0, 0.0)
    """Where it is (x, z) [m]; a spreader is everywhere."""
    strength: Annotated[float, Field(ge=0, le=10)] = 1.0
    """1 is as fast as the steps can travel."""


class Patch(Section):
    """A whole show."""

    name: Name
    """What the show is called."""
    seed: Annotated[int, Field(ge=0, le=2**31 - 1)] = 1
    """Seed of all chance; the same seed and events give the same show."""
    steps: str = "steps"
    """Folder of sketched steps, looked up in the patch's folder, then in the project's patches."""
    loop_measures: Annotated[int, Field(ge=1, le=100000)] | None = None
    """The score's elements come again after so many measures; never if left out."""
    music: MusicSection = MusicSection()
    sound: SoundSection = SoundSection()
    clock: ClockSection = ClockSection()
    stage: StageSection = StageSection()
    camera: CameraSection = CameraSection()
    look: LookSection = LookSection()
    locomotion: LocomotionSection = LocomotionSection()
    motion: MotionSection = MotionSection()
    group: Annotated[tuple[GroupSection, ...], Field(min_length=1, max_length=16)]
    element: Annotated[tuple[ElementSection, ...], Field(max_length=20000)] = ()

    @property
    def dancer_count(self) -> int:
        """Dancers of all groups together."""
        return sum(group.dancers for group in self.group)

    def motion_of(self, group: GroupSection) -> MotionSection:
        """The motion section of a group: its own keys over the patch's."""
        own = group.motion
        return (
            self.motion
            if own is None
            else self.motion.model_copy(update={k: getattr(own, k) for k in own.model_fields_set})
        )

    @model_validator(mode="after")
    def _elements_come(self) -> "Patch":
        for number, element in enumerate(self.element, start=1):
            if self.loop_measures is not None and element.measure >= self.loop_measures + 1:
                raise ValueError(
                    f"element {number} begins in measure {element.measure:g}, but the score begins again after "
                    f"{self.loop_measures} (loop_measures): it would never come"
                )
        return self

    @model_validator(mode="after")
    def _names_differ(self) -> "Patch":
        names = [group.name for group in self.group]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ValueError(f"two groups are called {twice[0]!r}: give each its own name")
        return self


def parse_entry(entry: str) -> tuple[str, int]:
    """Step name and number of repeats of an entry like "groove x4"; repeats are 1 if none are given."""
    match = _REPEATED.match(entry.strip())
    if match is None:
        return entry.strip(), 1
    return match["step"].strip(), int(match["times"] or 1)
