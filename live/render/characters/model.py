"""Data of a character file: skinned meshes in the rest pose, and materials (glTF 2.0, VRM 0.x and 1.0)."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

from live.base.arrays import Float64, Int64
from live.render.characters.expressions import Expressions
from live.render.characters.spring_reader import NO_SPRINGS, Springs

TRIANGLE_LIMIT: Final = 300_000
"""Maximum number of triangles of a character."""


@dataclass(frozen=True, slots=True)
class Material:
    """Material of a part of the surface."""

    name: str
    colour: tuple[float, float, float, float]
    """Linear RGB and opacity factors of the texture."""
    image: int | None
    """The image of the base colour; None: only the colour."""
    cutoff: float
    """Alpha cutoff: pixels with less opacity are not drawn; 0: opaque."""
    two_sided: bool
    roughness: float
    """Roughness: 0 is a mirror, 1 is matt."""
    toon_shaded: bool
    """Whether the material is unlit or toon-shaded (MToon)."""
    normal_image: int | None = None
    """The normal map (OpenGL convention: green is up); None: none."""
    normal_strength: float = 1.0
    """Strength of the normal map."""
    emission: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Emission in linear RGB."""
    emission_image: int | None = None
    """The emission's image; None: none."""

    @property
    def images(self) -> set[int]:
        """All images that the material needs."""
        return {image for image in (self.image, self.normal_image, self.emission_image) if image is not None}

    @property
    def has_extras(self) -> bool:
        """Whether the material has normals or emission."""
        return self.normal_image is not None or max(self.emission) > 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """Triangles of one material (V vertices, T triangles, K nodes per vertex)."""

    position: Float64
    """In the file's rest pose, units and axes, shape (V, 3)."""
    normal: Float64
    """Unit, shape (V, 3)."""
    uv: Float64
    """Texture coordinates, shape (V, 2)."""
    node: Int64
    """The nodes that move each vertex, shape (V, K)."""
    weight: Float64
    """Weight of each of these nodes, rows sum to 1, shape (V, K)."""
    triangle: Int64
    """Shape (T, 3)."""
    material: int
    morphs: Mapping[int, tuple[Float64, Float64]] = field(default_factory=dict)
    """For channels of the face (-1: both eyes) how far vertices and normals move, both (V, 3)."""


@dataclass(frozen=True, slots=True, eq=False)
class Model:
    """A character as read from its file (N nodes)."""

    file: str
    size: int
    """Size of the file [bytes]."""
    kind: str
    """`VRM 1.0`, `VRM 0.x` or `glTF`."""
    names: tuple[str, ...]
    """Names of all nodes."""
    parents: tuple[int, ...]
    """-1: none."""
    order: tuple[int, ...]
    """All nodes, parents first."""
    node_position: Float64
    """Position of each node in the rest pose, shape (N, 3)."""
    node_matrix: Float64
    """From each node's space to the world in the rest pose, shape (N, 4, 4)."""
    joints: frozenset[int]
    """Nodes that skins refer to."""
    bones: dict[str, int]
    """Humanoid bones of a VRM and their nodes; empty for other files."""
    parts: tuple[Part, ...]
    materials: tuple[Material, ...]
    images: tuple[bytes | None, ...]
    """Bytes of the image files; None: not used by any material."""
    springs: Springs = NO_SPRINGS
    """The springs that a VRM defines."""
    expressions: Expressions = field(default_factory=lambda: Expressions({}))
    """The blend shapes that faces move."""
    licence: dict[str, str] = field(default_factory=dict)
    """The file's metadata about author and permissions."""
    notes: tuple[str, ...] = ()
    """Notes about parts that were left out."""

    @property
    def triangle_count(self) -> int:
        """Triangles of all parts."""
        return sum(len(part.triangle) for part in self.parts)
