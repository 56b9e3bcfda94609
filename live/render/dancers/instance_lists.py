"""Instance lists: the dancers to draw for each list and kind of piece, refilled for every picture.

Dancers outside the picture are culled, because their bodies would cost as many vertices as visible ones.
"""

from dataclasses import dataclass
from typing import Final

import moderngl
import numpy as np

from live.base.arrays import Float32, Float64, Int32, UInt8
from live.base.stage_snapshot import Camera, StageView
from live.render.adaptive_quality import Quality
from live.render.camera import PicturePart, Size, view_matrix, world_to_clip
from live.render.dancers.group_styles import LISTS, GroupStyles
from live.render.dancers.skinning import SKINS, SkinTexture
from live.render.render_kernels import (
    CASTING,
    CLOSE,
    FAR,
    MIRRORED,
    NEAR,
    PRESENT,
    VISIBLE,
    bounding_box,
    choose_detail,
    cull_dancers,
    fill_lists,
)

BODY_REACH: Final = 0.35
"""The generated body, in any style, reaches at most this far beyond its joints [m]."""
HIP_REACH: Final = 1.35
"""Maximum distance of any joint from the hips [m]."""
_REQUIRED_BITS: Final = {
    "all": CASTING, "mirrored": MIRRORED, "particles": PRESENT, "ribbons": PRESENT, "trails": PRESENT, "xray": VISIBLE,
}  # fmt: skip
"""Visibility bits required by each list; the others need VISIBLE and CLOSE, NEAR or FAR. Effects that leave their
dancer are always drawn."""
INSTANCE_BYTES: Final = 8
_USUAL_LENS_DEG: Final = Camera().field_of_view_deg
_SKIN_LISTS: Final = {
    "coarse": ("all", "mirrored"), "near": ("near", "bodies near", "ink near"), "far": ("far", "bodies far", "ink far"),
    "close": ("close", "bodies close", "ink close"), "xray": ("xray",),
}  # fmt: skip
"""The lists that draw each skin."""


def _allowed() -> Int32:
    """Return for each visibility the bits of the lists that it allows, shape (128,)."""
    bits = {"close": CLOSE, "near": NEAR, "far": FAR}
    needs = [_REQUIRED_BITS.get(name) or VISIBLE | bits[name.split()[-1]] for name in LISTS]
    visibility = np.arange(2 * CLOSE)[:, None]
    return np.asarray(((visibility & needs) == needs) @ (1 << np.arange(len(LISTS))), np.int32)


_ALLOWED: Final = _allowed()
_DETAIL_BITS: Final = CLOSE | NEAR | FAR
_SKIN_BITS: Final = np.array([sum(1 << LISTS.index(name) for name in _SKIN_LISTS[skin]) for skin in SKINS], np.int32)
_SKIN_OF: Final = np.array(
    [next((at for at, skin in enumerate(SKINS) if name in _SKIN_LISTS[skin]), -1) for name in LISTS], np.int32
)


@dataclass(frozen=True, slots=True, eq=False)
class ViewVolume:
    """View volume of a camera, for culling."""

    forward: Float32
    """View direction, a unit vector, shape (3,)."""
    eye_distance: float
    """Position of the camera along that direction [m]."""
    planes: Float32
    """Planes of the frustum, facing inwards: n . p + d >= 0 with unit vectors n, shape (5, 4)."""
    part_planes: Float32 | None
    """The same of the part of the picture that is drawn; None: all of it is."""
    magnification: float
    """How large it shows a dancer, compared with the usual lens."""

    @staticmethod
    def of(camera: Camera, size: Size | PicturePart) -> "ViewVolume":
        """Return the view volume of a camera for a picture of `size` pixels, or for a part of it."""
        part = PicturePart.of(size)
        forward = np.ascontiguousarray(-view_matrix(camera)[2, :3], np.float32)
        start = float(forward @ np.array(camera.eye, np.float32))
        usual, now = (np.tan(0.5 * np.deg2rad(lens)) for lens in (_USUAL_LENS_DEG, camera.field_of_view_deg))
        whole = _frustum(world_to_clip(camera, (round(part.whole[0]), round(part.whole[1]))))
        planes = None if part.is_whole else _frustum(world_to_clip(camera, part))
        return ViewVolume(forward, start, whole, planes, float(usual / now))


def _frustum(rows: Float64) -> Float32:
    """Return the planes of a frustum, as in `ViewVolume`, by its matrix from world to clip space (4, 4)."""
    # Gribb and Hartmann 2001: -w <= x, x <= w, -w <= y, y <= w, -w <= z
    planes = rows[3] + np.array([rows[0], -rows[0], rows[1], -rows[1], rows[2]])
    planes /= np.linalg.norm(planes[:, :3], axis=1, keepdims=True)
    return np.ascontiguousarray(planes, np.float32)


class InstanceLists:
    """Instance lists of at most `capacity` dancers, each in `pieces` pieces of `kinds` kinds."""

    def __init__(self, ctx: moderngl.Context, capacity: int, kinds: int, pieces: int) -> None:
        self._ctx, self._capacity = ctx, capacity
        self.piece: Int32 = np.full((capacity, pieces), -1, np.int32)
        """Kinds of each dancer's pieces, -1: none, shape (capacity, pieces); set it before `fill`."""
        self._visibility = np.zeros(capacity, np.uint8)
        self._seen, self._part = self._visibility[:0], np.zeros(capacity, np.uint8)
        self._joints = np.zeros((0, 1, 3), np.float32)
        self._box = np.zeros((2, 3), np.float32)
        self._scratch, self._lists = np.zeros(capacity, np.float32), np.zeros(capacity, np.int32)
        self._instances = np.zeros((len(LISTS), kinds, capacity, 2), np.int32)
        self._count = np.zeros((len(LISTS), kinds), np.int32)
        self._places = np.zeros((len(SKINS), kinds, 2), np.int32)
        self._buffers: dict[tuple[int, int], moderngl.Buffer] = {}
        self._at = {name: at for at, name in enumerate(LISTS)}
        self._counts: list[list[int]] = self._count.tolist()

    @property
    def visibility(self) -> UInt8:
        """Bits of `render_kernels` for each dancer of this frame, shape (A,)."""
        return self._seen

    def count(self, name: str, kind: int) -> int:
        """Return the number of pieces of a kind on a list."""
        return self._counts[self._at[name]][kind]

    def buffer(self, name: str, kind: int) -> moderngl.Buffer:
        """Return the buffer of their dancers and the texels of their skins' first vertices, two int32 each."""
        return self._buffer(self._at[name], kind)

    def _buffer(self, at: int, kind: int) -> moderngl.Buffer:
        """Return that buffer, made when a list first needs it: most kinds are never on most lists."""
        if (at, kind) not in self._buffers:
            self._buffers[at, kind] = self._ctx.buffer(reserve=self._capacity * INSTANCE_BYTES, dynamic=True)
        return self._buffers[at, kind]

    def box(self, *, casting: bool = False) -> Float32:
        """Return the box around the joints of visible dancers, or of those whose shadows may be, shape (2, 3): lowest
        and highest x, y, z [m]; lowest above highest if there are none. The next call overwrites it."""
        bounding_box(self._joints, self._seen, CASTING if casting else VISIBLE, self._box)
        return self._box

    def fill(
        self,
        view: StageView,
        view_volume: ViewVolume,
        light: Float32,
        quality: Quality,
        styles: GroupStyles,
        reach: float,
        meshes: tuple[Int32, Int32],
        skin: SkinTexture,
    ) -> None:
        """Fill all lists for a moment and a view volume, and upload them.

        `light` (3,): direction towards the key light; `reach`: distance of surfaces from joints [m], if above usual;
        `meshes`: first vertex and number of vertices of each skin and kind.
        """
        seen = self._seen = self._visibility[: len(view.present)]
        joints = self._joints = view.joint_position
        radius = HIP_REACH + max(reach, BODY_REACH)
        cull_dancers(joints, view.present, view_volume.planes, light, radius, seen)
        near_to = view_volume.eye_distance + quality.far_from * view_volume.magnification
        close_to = view_volume.eye_distance + quality.close_within
        choose_detail(
            joints, view_volume.forward, near_to, quality.near_count, close_to, quality.close_count, seen, self._scratch
        )
        if view_volume.part_planes is not None:  # who is near was chosen as in the whole picture
            part = self._part[: len(seen)]
            cull_dancers(joints, view.present, view_volume.part_planes, light, radius, part)
            np.bitwise_or(part, _DETAIL_BITS, out=part)
            np.bitwise_and(seen, part, out=seen)
        used = fill_lists(
            seen, view.group, self.piece, styles.list_bits, _ALLOWED, _SKIN_OF, _SKIN_BITS, *meshes, 1 << skin.shift,
            self._instances, self._count, self._lists, self._places, skin.dancers, skin.rows,
        )  # fmt: skip
        self._counts = counts = self._count.tolist()
        for at, kind in np.argwhere(self._count).tolist():
            self._buffer(at, kind).write(self._instances[at, kind, : counts[at][kind]])
        skin.upload(used)

    def release(self) -> None:
        """Free the buffers."""
        for buffer in self._buffers.values():
            buffer.release()
