"""`[picture]`: which passes draw the picture, in which order, and where its parameters begin.

How dancers are drawn, as a patch says it: `[group.draw]` and `draw` of `[[looks]]`.

Users' own characters: `[[character]]`.

What upper bodies are textured with: `[texture]`.
"""

from collections.abc import Mapping
from functools import cached_property
from typing import Annotated, Final

from pydantic import Field, field_validator, model_validator

from live.base.body_catalogue import BODIES, MOST
from live.base.custom_pass import MOST_CHARACTERS, MOST_PASSES, OwnPass, own_numbers, read_own_pass
from live.base.errors import PersonError
from live.base.picture_parameters import BY_ADDRESS, OF_GROUPS, STYLE_OF_GROUP
from live.base.stage_snapshot import PASSES
from live.motion.skeleton import SKELETON
from live.show.desk.parameter_table import check_setting, numbers_of, split
from live.show.patch.section_base import Amiss, Colour, Name, Section, Share

Number = float | tuple[float, float, float]


class OwnPassSection(Section):
    """`[[picture.own]]`: a pass of the patch's own, as it stands in its folder: nobody need write this."""

    name: Annotated[str, Field(max_length=32)]
    """What it is called: the name of its file."""
    source: Annotated[str, Field(max_length=MOST_CHARACTERS)]
    """Its text in GLSL."""


class PictureSection(Section):
    """`[picture]`: the passes of the picture."""

    passes: Annotated[tuple[Name, ...], Field(max_length=32)] = PASSES
    """Passes in the order in which they are done; one that is left out is never drawn. What each does is set by
    `/dance/pass/...`, so one that is named here need not be seen. A name that is none of the engine's is that of a file
    `passes/NAME.glsl` beside the patch."""
    set: Annotated[dict[str, Number], Field(max_length=200)] = Field(default={})
    """Where parameters of the picture begin, by the control's address, as in `"/dance/pass/ink" = 1`."""
    own: Annotated[tuple[OwnPassSection, ...], Field(max_length=MOST_PASSES)] = ()
    """The texts of the patch's own passes, taken from their files, so that a journal holds them."""

    @cached_property
    def own_passes(self) -> tuple[OwnPass, ...]:
        """The patch's own passes; PersonError if one is none."""
        return tuple(read_own_pass(one.name, one.source) for one in self.own)

    @model_validator(mode="after")
    def _passes_are_there(self) -> "PictureSection":
        own = [one.name for one in self.own]
        try:
            assert self.own_passes is not None
        except PersonError as error:
            raise Amiss(str(error), "passes") from None
        for name in self.passes:
            if name not in PASSES and name not in own:
                known = f"there are {', '.join(PASSES)}, and files passes/NAME.glsl beside the patch"
                raise Amiss(f"there is no pass {name!r}: {known}", "passes")
            if self.passes.count(name) > 1 or (name in PASSES and name in own):
                raise Amiss(f"the pass {name!r} is there twice: leave one out", "passes")
        return self

    @model_validator(mode="after")
    def _can_be_set(self) -> "PictureSection":
        own = own_numbers(self.own_passes)
        for address, value in self.set.items():
            if address in own:
                known = own[address]
                if not isinstance(value, float) or not known.low <= value <= known.high:
                    raise Amiss(f"{address!r} = {value!r}: {known.low:g} to {known.high:g} expected", "set", address)
                continue
            if address not in BY_ADDRESS:
                raise Amiss(f"{address!r} is no parameter of the picture; docs/osc.md lists them", "set", address)
            try:
                numbers_of(address, value)
            except PersonError as error:
                raise Amiss(str(error), "set", address) from None
        return self

    def start(self) -> tuple[tuple[str, tuple[float, ...]], ...]:
        """Addresses and the numbers with which they begin."""
        return tuple(
            (address, value if isinstance(value, tuple) else (float(value),)) for address, value in self.set.items()
        )


def _key(address: str) -> str:
    return address.removeprefix(STYLE_OF_GROUP).replace("/", "_")


KEYS: Final = tuple(_key(address) for address in OF_GROUPS if address.startswith(STYLE_OF_GROUP))
"""All keys."""
Setting = float | bool | str | tuple[float, float, float]
Draw = Annotated[dict[str, Setting], Field(max_length=400)]
"""Values by the control's address without `/dance/draw/`, words joined by `_` or `/`: `ink_width`."""


def drawn(said: Mapping[str, Setting]) -> dict[str, Setting]:
    """The same values by the addresses of their controls, a group's name kept behind."""
    settings = {}
    for key, value in said.items():
        name, space, group = key.strip().partition(" ")
        settings[STYLE_OF_GROUP + name.replace("_", "/") + space + group] = value
    return settings


def check_drawn(said: Mapping[str, Setting], where: str) -> None:
    """ValueError, which begins with `where`, for a key that there is not or a value that it cannot have."""
    for key, value in drawn(said).items():
        address = split(key)[0]
        if address not in OF_GROUPS or not address.startswith(STYLE_OF_GROUP):
            raise ValueError(f"{where}: nothing is drawn by {_key(address)!r}; there are: {', '.join(KEYS)}")
        try:
            check_setting(key, value)
        except PersonError as error:
            raise ValueError(f"{where}: {error}") from None


class CharacterMaterialSection(Section):
    """`[character.materials.NAME]`: what is changed of a material of the file."""

    colour: Colour | None = None
    """Linear RGB that its image is multiplied by, in place of the file's."""
    sheen: Share | None = None
    """How much it shines in the light."""
    hidden: bool = False
    """It is left out: a hat, glasses, a cloak."""


class CharacterSection(Section):
    """`[[character]]`: a model that is drawn in the place of dancers' bodies, on the same skeleton."""

    name: Name
    """What it is called."""
    file: Annotated[str, Field(min_length=1, max_length=400)]
    """A .glb, .gltf or .vrm file, in the patch's folder or below it: `characters/anna.vrm`."""
    groups: Annotated[tuple[Name, ...], Field(max_length=16)] = ()
    """The groups whose dancers are drawn as it; where several characters have a group, by chance."""
    dancers: Annotated[tuple[Annotated[int, Field(ge=1, le=4000)], ...], Field(max_length=4000)] = ()
    """Single dancers by number. With neither groups nor dancers it is everybody's."""
    joints: Annotated[dict[Name, Annotated[str, Field(min_length=1, max_length=200)]], Field(max_length=22)] = Field(
        default={}
    )
    """Bones of the file where their names do not say what they are: `{ hips = "Bone.003" }`. `live character FILE`
    tells which were found."""
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
    def _is_its_own(cls, name: str) -> str:
        if name in BODIES:
            raise ValueError(f"{name!r} is a body that every show has: give the character another name")
        return name


Characters = Annotated[tuple[CharacterSection, ...], Field(max_length=MOST)]


Place = Annotated[str, Field(min_length=1, max_length=1000)]


class TextureSection(Section):
    """`[texture]`: recordings whose upper bodies dancers take over, as far as `texture` of `[motion]` says."""

    recordings: Annotated[tuple[Place, ...], Field(max_length=64)] = ()
    """Motion files, or folders of them, looked up in the patch's folder, then in the project's patches. What TOML files
    there say of their beats is true; else beats are guessed from the feet."""
    fps: Annotated[float, Field(ge=1, le=10_000)] | None = None
    """True frame rate of those whose headers lie."""
