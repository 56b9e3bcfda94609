"""Patch sections for the picture: `[picture]`, `[[character]]` and `[texture]`."""

from functools import cached_property
from typing import Annotated, Literal

from pydantic import Field, ValidationInfo, field_validator, model_validator

from live.base.body.catalogue import BODIES, MAX_CHARACTERS
from live.base.custom_pass import (
    MAX_PASSES,
    MAX_SOURCE_LENGTH,
    PASSES,
    CustomShader,
    parse_custom_pass,
)
from live.base.errors import PersonError
from live.motion.skeleton import SKELETON
from live.show.patch.section_base import Colour, InvalidEntry, Name, Section, Share, WorldCoordinate, run_check

Number = float | tuple[float, float, float]
FontFile = Annotated[str, Field(min_length=1, max_length=400)]


class OwnPassSection(Section):
    """`[[picture.own]]`: a custom pass, filled in from the file in the patch's folder; not written by hand."""

    name: Annotated[str, Field(max_length=32)]
    """The name of its file."""
    source: Annotated[str, Field(max_length=MAX_SOURCE_LENGTH)]
    """Its source in GLSL."""


class PictureSection(Section):
    """`[picture]`: the passes of the picture."""

    passes: Annotated[tuple[Name, ...], Field(max_length=32)] = PASSES
    """Passes in drawing order; a pass left out is never drawn. `/dance/pass/...` sets the strength of each, so a pass
    named here may be invisible. Any other name than the engine's is that of a file `passes/NAME.glsl` next to the
    patch."""
    set: Annotated[dict[str, Number], Field(max_length=200)] = Field(default={})
    """Initial values of picture parameters, by the control's address, as in `"/dance/pass/ink" = 1`."""
    own: Annotated[tuple[OwnPassSection, ...], Field(max_length=MAX_PASSES)] = ()
    """Sources of the custom passes, taken from their files, so that a journal contains them."""

    @cached_property
    def own_passes(self) -> tuple[CustomShader, ...]:
        """The custom passes; PersonError if one is invalid."""
        return tuple(parse_custom_pass(one.name, one.source) for one in self.own)

    @model_validator(mode="after")
    def _passes_exist(self) -> "PictureSection":
        own = [one.name for one in self.own]
        try:
            assert self.own_passes is not None
        except PersonError as error:
            raise InvalidEntry(str(error), "passes") from None
        for name in self.passes:
            if name not in PASSES and name not in own:
                known = f"there are {', '.join(PASSES)}, and files passes/NAME.glsl beside the patch"
                raise InvalidEntry(f"there is no pass {name!r}: {known}", "passes")
            if self.passes.count(name) > 1 or (name in PASSES and name in own):
                raise InvalidEntry(f"the pass {name!r} is there twice: leave one out", "passes")
        return self

    @model_validator(mode="after")
    def _settings_are_valid(self, info: ValidationInfo) -> "PictureSection":
        run_check(info, "picture", self)
        return self


class TitleSection(Section):
    """`[[title]]`: a title, or the style of titles, shown by `/dance/title`."""

    name: Name
    """Its name for `/dance/title`."""
    text: Annotated[str, Field(max_length=250)] = ""
    """Its text; `|` begins a new line; left out: that of the call."""
    place: Literal["picture", "behind", "front"] = "picture"
    """Over the picture, or standing in the space behind or in front of the dancers."""
    at: tuple[WorldCoordinate, WorldCoordinate] | None = None
    """Its middle: shares of the picture's width and height from the upper left corner (left out: 0.5, 0.5); in the
    space x and height [m] (left out: 0, 2.2)."""
    z: WorldCoordinate | None = None
    """In the space: its depth [m]; left out: 1 behind the stage's back edge, or 0.6 before its front edge."""
    size: Annotated[float, Field(gt=0, le=50)] | None = None
    """Height of a capital letter: share of the picture's height (left out: 0.09), in the space [m] (left out: 1)."""
    tracking: Annotated[float, Field(ge=-0.2, le=2)] = 0.03
    """Space added between letters, in ems."""
    colour: Colour = (1.0, 0.96, 0.9)
    """Its colour."""
    brightness: Annotated[float, Field(ge=0, le=4)] = 1.0
    """Factor of the colour; above 1 it glows."""
    entrance: Literal["cut", "fade", "rise", "wipe", "type"] = "rise"
    """How it enters, from a beat on: at once, as a whole, letter by letter from below, from left to right, or letter by
    letter as typed."""
    measures: Annotated[float, Field(ge=0, le=64, allow_inf_nan=False)] = 1.0
    """Length of the entrance in measures."""
    hold: Annotated[float, Field(ge=0, le=1024, allow_inf_nan=False)] = 0.0
    """It fades out after so many measures; 0: when it is hidden or another title of this name is shown."""
    font: FontFile | None = None
    """A .ttf or .otf file in the patch's folder or below it; left out: the usual font."""


class WordsSection(Section):
    """`[words]`: words of the audience, shown by `/dance/word` or offered by `/dance/word/offer`."""

    form: Literal["cloud", "rain"] = "cloud"
    """They gather in a cloud behind the dancers, or fall."""
    accept: Literal["operator", "all"] = "operator"
    """Whether offered words wait for the operator, or all that are no blocked words are shown."""
    blocked: Annotated[tuple[Name, ...], Field(max_length=1000)] = ()
    """Words that no word may contain, whatever its case and accents."""
    vote: Annotated[tuple[Name, ...], Field(max_length=64)] = ()
    """Words on which phones can vote (`/dance/audience/vote word …`): the winner is shown."""
    most: Annotated[int, Field(ge=1, le=32)] = 24
    """Largest number of words at a time; the oldest fades."""
    beats: Annotated[float, Field(ge=0, le=4096, allow_inf_nan=False)] = 32.0
    """A word begins to fade after so many beats, and falls so long; 0: it stays."""
    size: Annotated[float, Field(gt=0, le=10)] = 0.42
    """Usual height of a capital letter [m]."""
    width: Annotated[float, Field(gt=0, le=200)] | None = None
    """Width of the cloud [m]; left out: 1.1 times the stage's."""
    bottom: Annotated[float, Field(ge=0, le=50)] = 0.8
    """Height of its lower edge [m]."""
    top: Annotated[float, Field(gt=0, le=60)] = 4.4
    """Height of its upper edge [m]."""
    colour: Colour = (0.55, 0.8, 1.0)
    """Their colour."""
    font: FontFile | None = None
    """A .ttf or .otf file in the patch's folder or below it; left out: the usual font."""

    @model_validator(mode="after")
    def _cloud_has_room(self) -> "WordsSection":
        if self.top <= self.bottom:
            raise ValueError(f"top {self.top:g} has to be above bottom {self.bottom:g}")
        return self


class CharacterMaterialSection(Section):
    """`[character.materials.NAME]`: changes to a material of the file."""

    colour: Colour | None = None
    """Linear RGB factor of its texture, instead of the file's."""
    sheen: Share | None = None
    """Strength of its specular reflection."""
    hidden: bool = False
    """Whether it is not drawn, such as a hat, glasses or a cloak."""


class CharacterSection(Section):
    """`[[character]]`: a model that is drawn instead of dancers' bodies, on the same skeleton."""

    name: Name
    """Its name."""
    file: Annotated[str, Field(min_length=1, max_length=400)]
    """A .glb, .gltf or .vrm file, in the patch's folder or below it: `characters/anna.vrm`."""
    groups: Annotated[tuple[Name, ...], Field(max_length=16)] = ()
    """The groups whose dancers are drawn with it; if several characters have a group, one is drawn at random."""
    dancers: Annotated[tuple[Annotated[int, Field(ge=1, le=10_000)], ...], Field(max_length=10_000)] = ()
    """Single dancers by number. With neither groups nor dancers it applies to all."""
    joints: Annotated[dict[Name, Annotated[str, Field(min_length=1, max_length=200)]], Field(max_length=22)] = Field(
        default={}
    )
    """Bones of the file that are not recognised by name: `{ hips = "Bone.003" }`. `live character FILE` lists those
    that were found."""
    materials: Annotated[dict[Name, CharacterMaterialSection], Field(max_length=64)] = Field(default={})
    """Changes of materials, by their names in the file."""

    @field_validator("joints")
    @classmethod
    def _are_joints(cls, joints: dict[str, str]) -> dict[str, str]:
        for name in joints:
            if name not in SKELETON.names:
                raise ValueError(f"{name!r} is no joint of a dancer: there are {', '.join(SKELETON.names)}")
        return joints

    @field_validator("name")
    @classmethod
    def _name_is_free(cls, name: str) -> str:
        if name in BODIES:
            raise ValueError(f"{name!r} is a body that every show has: give the character another name")
        return name


Characters = Annotated[tuple[CharacterSection, ...], Field(max_length=MAX_CHARACTERS)]


MotionPath = Annotated[str, Field(min_length=1, max_length=1000)]


class TextureSection(Section):
    """`[texture]`: recordings that give dancers' upper bodies their motion, by the share `texture` of `[motion]`."""

    recordings: Annotated[tuple[MotionPath, ...], Field(max_length=64)] = ()
    """Motion files, or folders of them, looked up in the patch's folder, then in the project's patches. Beats are those
    in TOML files there, else they are estimated from the feet."""
    fps: Annotated[float, Field(ge=1, le=10_000)] | None = None
    """Frame rate of recordings with a wrong one in the file header."""
