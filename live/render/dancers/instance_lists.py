"""Instance lists: the dancers to draw for each list and body, refilled for every picture.

Dancers outside the picture are culled, because their bodies would cost as many vertices as visible ones.
"""

from dataclasses import dataclass
from typing import Final

import moderngl
import numpy as np

from live.base.arrays import Float32, Int32, UInt8
from live.base.stage_snapshot import Camera, StageView
from live.render.adaptive_quality import Quality
from live.render.camera import view_matrix, world_to_clip
from live.render.dancers.group_styles import LISTS, GroupStyles
from live.render.dancers.skinning import SKINS, SkinTexture
from live.render.render_kernels import (
    CASTING,
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
"""Visibility bits required by each list; the others need VISIBLE and NEAR or FAR. Effects that leave their dancer are
always drawn."""
INSTANCE_BYTES: Final = 8
_SKIN_LISTS: Final = {
    "coarse": ("all", "mirrored"), "near": ("near", "bodies near", "ink near"), "far": ("far", "bodies far", "ink far"),
    "xray": ("xray",),
}  # fmt: skip
"""The lists that draw each skin."""


def _allowed() -> Int32:
    """Return for each visibility the bits of the lists that it allows, shape (64,)."""
    needs = [_REQUIRED_BITS.get(name, VISIBLE | (NEAR if name.endswith("near") else FAR)) for name in LISTS]
    visibility = np.arange(2 * PRESENT)[:, None]
    return np.asarray(((visibility & needs) == needs) @ (1 << np.arange(len(LISTS))), np.int32)


_ALLOWED: Final = _allowed()
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

    @staticmethod
    def of(camera: Camera, size: tuple[int, int]) -> "ViewVolume":
        """Return the view volume of a camera for a picture of `size` pixels."""
        forward = np.ascontiguousarray(-view_matrix(camera)[2, :3], np.float32)
        rows = world_to_clip(camera, size)
        # Gribb and Hartmann 2001: -w <= x, x <= w, -w <= y, y <= w, -w <= z
        planes = rows[3] + np.array([rows[0], -rows[0], rows[1], -rows[1], rows[2]])
        planes /= np.linalg.norm(planes[:, :3], axis=1, keepdims=True)
        start = float(forward @ np.array(camera.eye, np.float32))
        return ViewVolume(forward, start, np.ascontiguousarray(planes, np.float32))


class InstanceLists:
    """Instance lists of at most `capacity` dancers, whose bodies are `body` (A,), 0 to `bodies` - 1."""

    def __init__(self, ctx: moderngl.Context, capacity: int, body: Int32, bodies: int) -> None:
        self._body = body
        self._visibility = np.zeros(capacity, np.uint8)
        self._seen = self._visibility[:0]
        self._joints = np.zeros((0, 1, 3), np.float32)
        self._box = np.zeros((2, 3), np.float32)
        self._scratch, self._lists = np.zeros(capacity, np.float32), np.zeros(capacity, np.int32)
        self._instances = np.zeros((len(LISTS), bodies, capacity, 2), np.int32)
        self._count = np.zeros((len(LISTS), bodies), np.int32)
        self._places = np.zeros((len(SKINS), bodies, 2), np.int32)
        self._buffers = {
            (name, kind): ctx.buffer(reserve=capacity * INSTANCE_BYTES, dynamic=True)
            for name in LISTS
            for kind in range(bodies)
        }
        self._rows = [
            (at, kind, self._instances[at, kind], self._buffers[name, kind])
            for at, name in enumerate(LISTS)
            for kind in range(bodies)
        ]
        self._at = {name: at for at, name in enumerate(LISTS)}
        self._counts: list[list[int]] = self._count.tolist()

    @property
    def visibility(self) -> UInt8:
        """Bits of `render_kernels` for each dancer of this frame, shape (A,)."""
        return self._seen

    def count(self, name: str, body: int) -> int:
        """Return the number of dancers with a body on a list."""
        return self._counts[self._at[name]][body]

    def buffer(self, name: str, body: int) -> moderngl.Buffer:
        """Return the buffer of their numbers and the texels of their skins' first vertices, two int32 each."""
        return self._buffers[name, body]

    def box(self) -> Float32:
        """Return the box around the joints of visible dancers, shape (2, 3): lowest and highest x, y, z [m]; lowest
        above highest if there are none."""
        bounding_box(self._joints, self._seen, self._box)
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
        `meshes`: first vertex and number of vertices of each skin and body.
        """
        seen = self._seen = self._visibility[: len(view.present)]
        joints = self._joints = view.joint_position
        cull_dancers(joints, view.present, view_volume.planes, light, HIP_REACH + max(reach, BODY_REACH), seen)
        near_to = view_volume.eye_distance + quality.far_from
        choose_detail(joints, view_volume.forward, near_to, quality.near_count, seen, self._scratch)
        used = fill_lists(
            seen, view.group, self._body, styles.list_bits, _ALLOWED, _SKIN_OF, _SKIN_BITS, *meshes, 1 << skin.shift,
            self._instances, self._count, self._lists, self._places, skin.dancers, skin.rows,
        )  # fmt: skip
        self._counts = counts = self._count.tolist()
        for at, kind, instances, buffer in self._rows:
            count = counts[at][kind]
            if count:
                buffer.write(instances[:count])
        skin.upload(used)

    def release(self) -> None:
        """Free the buffers."""
        for buffer in self._buffers.values():
            buffer.release()
