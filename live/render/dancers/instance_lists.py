"""Instance lists: the dancers to draw for each list and body, refilled for every picture.

Dancers outside the picture are culled, because their bodies would cost as many vertices as visible ones.
"""

from dataclasses import dataclass
from typing import Final

import moderngl
import numpy as np

from live.base.arrays import Float32, Int32
from live.base.stage_snapshot import Camera, StageView
from live.render.adaptive_quality import Quality
from live.render.camera import view_matrix, world_to_clip
from live.render.dancers.group_styles import LISTS, GroupStyles
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
"""Visibility bits required by each list; the others need SEEN and NEAR or FAR. Effects that leave their dancer are
always drawn."""


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
        self.drawn = np.zeros(capacity, np.bool_)
        """Whether each dancer is on any list, shape (capacity,)."""
        self.box = np.zeros((2, 3), np.float32)
        """Box around the joints of visible dancers: lowest and highest x, y, z [m]; lowest above highest if none."""
        self._scratch = np.zeros(capacity, np.float32)
        self._numbers = np.zeros((len(LISTS), bodies, capacity), np.float32)
        self._count = np.zeros((len(LISTS), bodies), np.int32)
        self._needs = np.array(
            [_REQUIRED_BITS.get(name, VISIBLE | (NEAR if name.endswith("near") else FAR)) for name in LISTS], np.uint8
        )
        self._buffers = {
            (name, kind): ctx.buffer(reserve=capacity * 4, dynamic=True) for name in LISTS for kind in range(bodies)
        }
        self._rows = [
            (at, kind, self._numbers[at, kind], self._buffers[name, kind])
            for at, name in enumerate(LISTS)
            for kind in range(bodies)
        ]
        self._at = {name: at for at, name in enumerate(LISTS)}
        self._counts: list[list[int]] = self._count.tolist()

    def count(self, name: str, body: int) -> int:
        """Return the number of dancers with a body on a list."""
        return self._counts[self._at[name]][body]

    def buffer(self, name: str, body: int) -> moderngl.Buffer:
        """Return the buffer of their numbers, float32."""
        return self._buffers[name, body]

    def fill(
        self,
        view: StageView,
        view_volume: ViewVolume,
        light: Float32,
        quality: Quality,
        styles: GroupStyles,
        reach: float,
    ) -> bool:
        """Fill all lists for a moment and a view volume; return whether any list has dancers.

        `light` (3,): direction towards the key light; `reach`: distance of surfaces from joints [m], if above usual.
        """
        here = self._visibility[: len(view.present)]
        cull_dancers(
            view.joint_position, view.present, view_volume.planes, light, HIP_REACH + max(reach, BODY_REACH), here
        )
        bounding_box(view.joint_position, here, self.box)
        near_to = view_volume.eye_distance + quality.far_from
        choose_detail(view.joint_position, view_volume.forward, near_to, quality.near_count, here, self._scratch)
        fill_lists(here, view.group, self._body, styles.list_bits, self._needs, self._numbers, self._count, self.drawn)
        self._counts = counts = self._count.tolist()
        for at, kind, numbers, buffer in self._rows:
            count = counts[at][kind]
            if count:
                buffer.write(numbers[:count])
        return bool(self._count.any())

    def release(self) -> None:
        """Free the buffers."""
        for buffer in self._buffers.values():
            buffer.release()
