"""What a character's file holds: surfaces in the rest pose, who moves them, materials (glTF 2.0, VRM 0.x and 1.0)."""

from dataclasses import dataclass, field
from typing import Final

import numpy as np
import numpy.typing as npt

Float64 = npt.NDArray[np.float64]
Int64 = npt.NDArray[np.int64]

TRIANGLE_LIMIT: Final = 300_000
"""Triangles that a character may have."""


@dataclass(frozen=True, slots=True)
class Material:
    """How a part of the surface looks."""

    name: str
    colour: tuple[float, float, float, float]
    """Linear RGB and opacity that the texture is multiplied by."""
    image: int | None
    """The image of the base colour, None: only the colour."""
    cutoff: float
    """Where the opacity is less there is nothing; 0: it is opaque."""
    two_sided: bool
    rough: float
    """0 is a mirror, 1 is chalk."""
    drawn: bool
    """Whether the file says that it is lit like a drawing: unlit, MToon."""
    normal: int | None = None
    """The image of its normals (OpenGL's way: green is up), None: none."""
    bumps: float = 1.0
    """How strong they are."""
    glow: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Linear RGB of the light that it gives itself."""
    glow_image: int | None = None
    """The image that this is multiplied by, None: none."""

    @property
    def images(self) -> set[int]:
        """All images that it needs."""
        return {image for image in (self.image, self.normal, self.glow_image) if image is not None}

    @property
    def has_more(self) -> bool:
        """Whether it has more than colours: normals, or light of its own."""
        return self.normal is not None or max(self.glow) > 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """Triangles of one material (V vertices, T triangles, K nodes that move each vertex)."""

    position: Float64
    """In the file's rest pose, in its own metres and axes, shape (V, 3)."""
    normal: Float64
    """Unit, shape (V, 3)."""
    uv: Float64
    """Place on the image, shape (V, 2)."""
    node: Int64
    """The nodes that move each vertex, shape (V, K)."""
    weight: Float64
    """How much each of them does, rows sum to 1, shape (V, K)."""
    triangle: Int64
    """Shape (T, 3)."""
    material: int


@dataclass(frozen=True, slots=True, eq=False)
class Model:
    """A character as its file has it (N nodes)."""

    file: str
    size: int
    """Bytes of the file."""
    kind: str
    """`VRM 1.0`, `VRM 0.x` or `glTF`."""
    names: tuple[str, ...]
    """Names of all nodes."""
    parents: tuple[int, ...]
    """-1: none."""
    order: tuple[int, ...]
    """All nodes, parents first."""
    place: Float64
    """Where each node is in the rest pose, shape (N, 3)."""
    joints: frozenset[int]
    """Nodes that skins name."""
    bones: dict[str, int]
    """Humanoid bones of a VRM and their nodes; empty for other files."""
    parts: tuple[Part, ...]
    materials: tuple[Material, ...]
    images: tuple[bytes | None, ...]
    """Files of the images that materials use; None: used by none."""
    licence: dict[str, str] = field(default_factory=dict)
    """What the file says of who made it, and who may use it."""
    notes: tuple[str, ...] = ()
    """What was left out, or is strange."""

    @property
    def triangle_count(self) -> int:
        """Triangles of all parts."""
        return sum(len(part.triangle) for part in self.parts)
