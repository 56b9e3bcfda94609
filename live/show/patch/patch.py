"""Model of a patch, the description of a whole show; the TOML keys are the field names.

Units are metres, seconds, beats, bpm and degrees; measures count from 1. `patch_reader` reads it and explains errors.
"""

from typing import Annotated, Any

from pydantic import Field, model_validator

from live.base.errors import PersonError
from live.base.projector_perspective import camera_from_corners
from live.show.patch.name_checks import check_call_names, check_cues, check_trackers
from live.show.patch.score_checks import check_score
from live.show.patch.section_base import InvalidEntry, Name, WholeFile
from live.show.patch.section_cues import CueSection, NamedLookSection, SceneSection, ViewSection
from live.show.patch.section_elements import ElementSection
from live.show.patch.section_io import (
    AudienceSection,
    LinkSection,
    MidiSection,
    MocapSection,
    OscSection,
    PsnSection,
)
from live.show.patch.section_motion import GroupSection, LocomotionSection, MotionSection, PartnerSection, parse_facing
from live.show.patch.section_music import ClockSection, MusicSection, ReactSection, SoundSection
from live.show.patch.section_picture import Characters, PictureSection, TextureSection
from live.show.patch.section_score import (
    AtSection,
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
    ObstacleSection,
    ProjectorSection,
    StageSection,
    SteeringSection,
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
    picture: PictureSection = PictureSection()
    projector: ProjectorSection | None = None
    character: Characters = ()
    view: Annotated[tuple[ViewSection, ...], Field(max_length=200)] = ()
    looks: Annotated[tuple[NamedLookSection, ...], Field(max_length=200)] = ()
    scene: Annotated[tuple[SceneSection, ...], Field(max_length=1000)] = ()
    cue: Annotated[tuple[CueSection, ...], Field(max_length=2000)] = ()
    locomotion: LocomotionSection = LocomotionSection()
    motion: MotionSection = MotionSection()
    texture: TextureSection = TextureSection()
    partner: Annotated[tuple[PartnerSection, ...], Field(max_length=16)] = ()
    react: Annotated[tuple[ReactSection, ...], Field(max_length=64)] = ()
    group: Annotated[tuple[GroupSection, ...], Field(min_length=1, max_length=16)]
    psn: PsnSection = PsnSection()
    mocap: Annotated[tuple[MocapSection, ...], Field(max_length=16)] = ()
    formation: Annotated[tuple[FormationTable, ...], Field(max_length=1000)] = ()
    """Formations by name: see formations.md."""
    segment: Annotated[tuple[SegmentSection, ...], Field(max_length=20000)] = ()
    regroup: Annotated[tuple[RegroupSection, ...], Field(max_length=20000)] = ()
    element: Annotated[tuple[ElementSection, ...], Field(max_length=20000)] = ()
    section: Annotated[tuple[ScoreSection, ...], Field(max_length=1000)] = ()
    sequence: Annotated[tuple[SequenceSection, ...], Field(max_length=20000)] = ()
    improvise: Annotated[tuple[ImproviseSection, ...], Field(max_length=1000)] = ()
    at: Annotated[tuple[AtSection, ...], Field(max_length=20000)] = ()
    signal: Annotated[tuple[SignalSection, ...], Field(max_length=20000)] = ()

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
        own = group.motion
        return (
            self.motion
            if own is None
            else self.motion.model_copy(update={k: getattr(own, k) for k in own.model_fields_set})
        )

    @model_validator(mode="after")
    def _names_differ(self) -> "Patch":  # must come first: the validators below look things up by name
        formations = [str(table["name"]) for table in self.formation]
        things = {"group": [group.name for group in self.group], "formation": formations}
        things |= {"view": [view.name for view in self.view], "looks": [look.name for look in self.looks]}
        things |= {"scene": [scene.name for scene in self.scene], "cue": [cue.name for cue in self.cue]}
        things["mocap"] = [performer.name for performer in self.mocap]
        things["background"] = [background.name for background in self.background]
        things |= {"character": [each.name for each in self.character]}
        things["partner"] = [partner.name for partner in self.partner]
        things |= {"gate": [gate.name for gate in self.gate], "obstacle": [item.name for item in self.obstacle]}
        for what, names in things.items():
            known: set[str] = set()
            for index, name in enumerate(names):
                folded = name.casefold().strip()
                if folded in known:
                    words = f"two {what.removesuffix('s')}s are called {name[:60]!r}: give each its own name"
                    raise InvalidEntry(words, what, index, "name")
                known.add(folded)
        return self

    @model_validator(mode="after")
    def _trackers_exist(self) -> "Patch":
        check_trackers(self.psn, self.mocap)
        return self

    @model_validator(mode="after")
    def _projector_sees_the_floor(self) -> "Patch":
        if self.projector is not None:
            try:
                camera_from_corners(self.projector.at, self.projector.corners, (self.stage.width, self.stage.depth),
                        self.projector.aspect)  # fmt: skip
            except PersonError as error:
                raise InvalidEntry(str(error), "projector", "corners") from None
        return self

    @model_validator(mode="after")
    def _characters_are_assigned(self) -> "Patch":
        groups = {group.name.casefold() for group in self.group}
        for index, each in enumerate(self.character):
            for name in each.groups:
                if name.casefold() not in groups:
                    raise InvalidEntry(
                        f"character {each.name!r}: no group is called {name!r}", "character", index, "groups"
                    )
            if each.dancers and max(each.dancers) > self.dancer_count:
                words = f"character {each.name!r}: there is no dancer {max(each.dancers)}, only {self.dancer_count}"
                raise InvalidEntry(words, "character", index, "dancers")
        return self

    @model_validator(mode="after")
    def _elements_begin(self) -> "Patch":
        for number, element in enumerate(self.element, start=1):
            if self.loop_measures is not None and element.measure >= self.loop_measures + 1:
                raise InvalidEntry(
                    f"element {number} begins in measure {element.measure:g}, but the score begins again after "
                    f"{self.loop_measures} (loop_measures): it would never begin",
                    *("element", number - 1, "measure"),
                )
        return self

    def leader_of(self, group: GroupSection) -> GroupSection:
        """Return the group whose steps a group dances: the one given by `like`, or itself."""
        return next((other for other in self.group if other.name == group.like), group)

    @model_validator(mode="after")
    def _leaders_exist(self) -> "Patch":
        names = {group.name: group for group in self.group}
        for index, group in enumerate(self.group):
            if group.like is None:
                continue
            leader, place = names.get(group.like), ("group", index, "like")
            if leader is None or leader is group:
                raise InvalidEntry(
                    f"group {group.name!r} is like {group.like!r}: no other group is called that", *place
                )
            if leader.like is not None:
                words = f"group {group.name!r}: name {leader.like!r}, which {leader.name!r} is like itself"
                raise InvalidEntry(words, *place)
        return self

    @model_validator(mode="after")
    def _facings_are_valid(self) -> "Patch":
        names = tuple(group.name.casefold() for group in self.group)
        for index, group in enumerate(self.group):
            try:
                parse_facing(group.facing, dancers=self.dancer_count + self.reserve, groups=names)
            except PersonError as error:
                raise InvalidEntry(f"group {group.name!r}: {error}", "group", index, "facing") from None
        return self

    @model_validator(mode="after")
    def _regroup_targets_exist(self) -> "Patch":
        names = {group.name.casefold() for group in self.group}
        for index, section in enumerate(self.regroup):
            if section.group.casefold() not in names:
                words = f"regroup in measure {section.measure}: no group is called {section.group!r}"
                raise InvalidEntry(words, "regroup", index, "group")
        return self

    @model_validator(mode="after")
    def _score_is_valid(self) -> "Patch":
        check_score(self)
        return self

    @model_validator(mode="after")
    def _cue_names_exist(self) -> "Patch":
        check_cues(self)
        check_call_names(self)
        return self
