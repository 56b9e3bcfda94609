"""Patch sections for the picture: `[picture]`, `[[character]]` and `[texture]`."""

from functools import cached_property
from typing import Annotated

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
from live.show.patch.section_base import Colour, InvalidEntry, Name, Section, Share, run_check

Number = float | tuple[float, float, float]


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
