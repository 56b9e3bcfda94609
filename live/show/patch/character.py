"""Users' own characters: `[[character]]`."""

from typing import Annotated

from pydantic import Field, field_validator

from live.base.bodies import BODIES
from live.base.character import MOST
from live.motion.skeleton import SKELETON
from live.show.patch.section_base import Colour, Name, Section, Share


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
