"""Model of a patch, the description of a whole show; the TOML keys are the field names.

Units are metres, seconds, beats, bpm and degrees; measures count from 1. `patch_reader` reads it, has it checked by
`live.show.patch_checks`, and explains errors.
"""

from typing import Annotated, Any, Self, TypeVar

from pydantic import Field, ValidationInfo, model_validator

from live.base.picture_parameters import MAX_GROUPS
from live.show.patch.section_base import Name, Section, WholeFile, run_check
from live.show.patch.section_capture import MAX_GESTURES, AnswerSection, GestureSection
from live.show.patch.section_cues import CueSection, PadSection, SceneSection
from live.show.patch.section_elements import ElementSection
from live.show.patch.section_io import (
    AudienceSection,
    LinkSection,
    MidiSection,
    MocapSection,
    OscSection,
    PsnSection,
)
from live.show.patch.section_motion import GroupSection, LocomotionSection, MoodSection, MotionSection, PartnerSection
from live.show.patch.section_music import ClockSection, MusicSection, ReactSection, SoundSection
from live.show.patch.section_picture import Characters, PictureSection, TextureSection, TitleSection, WordsSection
from live.show.patch.section_score import (
    AtSection,
    CurveSection,
    EvolutionSection,
    FormationTable,
    ImproviseSection,
    RegroupSection,
    ScoreSection,
    SegmentSection,
    SequenceSection,
    SignalSection,
)
from live.show.patch.section_stage import (
    BackgroundSection,
    CameraSection,
    GateSection,
    ItemSection,
    LookSection,
    NamedLookSection,
    ObstacleSection,
    ProjectorSection,
    ScenerySection,
    StageSection,
    SteeringSection,
    ViewSection,
)


class Patch(WholeFile):
    """A whole show."""

    name: Name
    """Name of the show."""
    seed: Annotated[int, Field(ge=0, le=2**31 - 1)] = 1
    """Seed of all random choices; the same seed and events give the same show."""
    steps: str = "steps"
    """Folder of sketched steps, looked up in the patch's folder, then in the project's patches."""
    loop_measures: Annotated[int, Field(ge=1, le=100000)] | None = None
    """The score's elements repeat after so many measures; left out: never."""
    reserve: Annotated[int, Field(ge=0, le=1000)] = 4
    """Dancers who wait in the wings, for `/dance/enter`."""
    selections: dict[Name, Annotated[str, Field(min_length=1, max_length=400)]] = Field(default={})
    """Names for dancers chosen by group, attribute, number or place: `pair = "ember & 1-2"`."""
    takes: dict[str, Annotated[tuple[str, ...], Field(min_length=1, max_length=1000)]] = Field(
        default={}, max_length=2000
    )
    """Of a step with several takes, those that are danced, by their names: `walk = ["walk, textured 2"]`."""
    variations: Annotated[int, Field(ge=0, le=8)] = 0
    """Variations that are made of each step when the show starts: trunk, arms and head otherwise, feet, balance and
    momentum the same (see `live docs steps`). `[motion] arms` and `mix` dance them."""
    music: MusicSection = MusicSection()
    sound: SoundSection = SoundSection()
    clock: ClockSection = ClockSection()
    link: LinkSection = LinkSection()
    midi: MidiSection = MidiSection()
    osc: OscSection = OscSection()
    audience: AudienceSection = AudienceSection()
    stage: StageSection = StageSection()
    steering: SteeringSection = SteeringSection()
    gate: Annotated[tuple[GateSection, ...], Field(max_length=32)] = ()
    obstacle: Annotated[tuple[ObstacleSection, ...], Field(max_length=64)] = ()
    camera: CameraSection = CameraSection()
    look: LookSection = LookSection()
    item: Annotated[tuple[ItemSection, ...], Field(max_length=200)] = ()
    background: Annotated[tuple[BackgroundSection, ...], Field(max_length=8)] = ()
    scenery: Annotated[tuple[ScenerySection, ...], Field(max_length=8)] = ()
    picture: PictureSection = PictureSection()
    title: Annotated[tuple[TitleSection, ...], Field(max_length=64)] = ()
    words: WordsSection = WordsSection()
    projector: ProjectorSection | None = None
    character: Characters = ()
    view: Annotated[tuple[ViewSection, ...], Field(max_length=200)] = ()
    looks: Annotated[tuple[NamedLookSection, ...], Field(max_length=200)] = ()
    scene: Annotated[tuple[SceneSection, ...], Field(max_length=1000)] = ()
    cue: Annotated[tuple[CueSection, ...], Field(max_length=2000)] = ()
    pad: Annotated[tuple[PadSection, ...], Field(max_length=256)] = ()
    locomotion: LocomotionSection = LocomotionSection()
    motion: MotionSection = MotionSection()
    mood: MoodSection = MoodSection()
    texture: TextureSection = TextureSection()
    partner: Annotated[tuple[PartnerSection, ...], Field(max_length=16)] = ()
    react: Annotated[tuple[ReactSection, ...], Field(max_length=64)] = ()
    group: Annotated[tuple[GroupSection, ...], Field(min_length=1, max_length=MAX_GROUPS)]
    psn: PsnSection = PsnSection()
    mocap: Annotated[tuple[MocapSection, ...], Field(max_length=16)] = ()
    answer: Annotated[tuple[AnswerSection, ...], Field(max_length=16)] = ()
    gesture: Annotated[tuple[GestureSection, ...], Field(max_length=MAX_GESTURES)] = ()
    formation: Annotated[tuple[FormationTable, ...], Field(max_length=1000)] = ()
    """Formations by name: see formations.md."""
    evolution: Annotated[tuple[EvolutionSection, ...], Field(max_length=200)] = ()
    segment: Annotated[tuple[SegmentSection, ...], Field(max_length=20000)] = ()
    regroup: Annotated[tuple[RegroupSection, ...], Field(max_length=20000)] = ()
    element: Annotated[tuple[ElementSection, ...], Field(max_length=20000)] = ()
    section: Annotated[tuple[ScoreSection, ...], Field(max_length=1000)] = ()
    sequence: Annotated[tuple[SequenceSection, ...], Field(max_length=20000)] = ()
    improvise: Annotated[tuple[ImproviseSection, ...], Field(max_length=1000)] = ()
    at: Annotated[tuple[AtSection, ...], Field(max_length=20000)] = ()
    signal: Annotated[tuple[SignalSection, ...], Field(max_length=20000)] = ()
    curve: Annotated[tuple[CurveSection, ...], Field(max_length=2000)] = ()

    def to_json_values(self) -> dict[str, Any]:
        """Return the keys that were written, as values for JSON; parsed again they give the same patch.

        Keys left out stay left out, because that has a meaning in `[group.motion]` and in cues.
        """
        return self.model_dump(mode="json", exclude_unset=True)

    @property
    def dancer_count(self) -> int:
        """Number of dancers of all groups together."""
        return sum(group.dancers for group in self.group)

    def motion_of(self, group: GroupSection) -> MotionSection:
        """The motion section of a group: its own keys over the patch's."""
        return _overlay(self.motion, group.motion)

    def mood_of(self, group: GroupSection) -> MoodSection:
        """The mood section of a group: its own keys over the patch's."""
        return _overlay(self.mood, group.mood)

    def leader_of(self, group: GroupSection) -> GroupSection:
        """Return the group whose steps a group dances: the one given by `like`, or itself."""
        return next((other for other in self.group if other.name == group.like), group)

    @model_validator(mode="after")
    def _tables_fit(self, info: ValidationInfo) -> Self:
        run_check(info, "patch", self)
        return self


Overlaid = TypeVar("Overlaid", bound=Section)


def _overlay(whole: Overlaid, own: Overlaid | None) -> Overlaid:
    """Return the section of the whole patch with the keys that a group writes itself."""
    return whole if own is None else whole.model_copy(update={key: getattr(own, key) for key in own.model_fields_set})
