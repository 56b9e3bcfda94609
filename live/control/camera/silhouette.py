"""Silhouettes of seen performers as pictures in memory, for looks: white on black, one ring `camera-NAME` each.

Only the outline of a body leaves the camera's process this way, and only if it was asked for. The rings are those of
`live.base.system.picture_ring`; programs of this user alone can read them.
"""

import math
import re
import threading
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from live.base.arrays import UInt8
from live.base.system.picture_ring import FrameRing
from live.control.camera.pose_models import LANDMARK_SIZE, ModelPose
from live.control.camera.seen_person import Person
from live.control.camera.silhouette_kernels import draw_mask
from live.motion.capture.landmarks import LANDMARK_NAMES

SIZE: Final = (400, 480)
"""Width and height of a silhouette's picture [pixels]."""
PIXELS_PER_METRE: Final = 192.0
"""Pixels of the picture per metre of the body: it shows 2.5 m from the floor up to raised hands."""
HIPS: Final = (200.0, 264.0)
"""Where the middle of the hips lies in the picture, from the left and from the top [pixels]."""
HELD_S: Final = 0.25
"""For this long [s] the silhouette of somebody who is not seen stays, as their joints do."""
_SCALE_SHARE: Final = 0.08
"""Share of a new picture in the person's size in the camera's picture."""
_HIP: Final = [LANDMARK_NAMES.index("leftHip"), LANDMARK_NAMES.index("rightHip")]


def pixels_per_metre(pose: ModelPose) -> float:
    """Return how many pixels of the camera's picture a metre of the body takes, by all landmarks (least squares); 0 if
    the body has no size."""
    place = pose.picture - pose.picture[_HIP].mean(axis=0)
    body = pose.body[:, :2] - pose.body[_HIP, :2].mean(axis=0)
    weight = pose.visibility[:, None]
    size = float((weight * body * body).sum())
    return max(float((weight * place * body).sum()) / size, 0.0) if size > 1e-6 else 0.0


def draw_silhouette(pose: ModelPose, scale: float, picture: UInt8) -> None:
    """Draw a person's silhouette, white on black, over a `picture` (480, 400, 3).

    `scale`: pixels of the camera's picture per metre, more than 0. The silhouette is upright as the camera's picture,
    whatever the region's rotation was; the middle of the hips is at `HIPS`, and a metre takes `PIXELS_PER_METRE`.
    """
    region = pose.region
    per_pixel = LANDMARK_SIZE / max(region.size, 1e-3)  # of the mask, per pixel of the camera's picture
    step = per_pixel * scale / PIXELS_PER_METRE  # of the mask, per pixel of the silhouette
    c, s = math.cos(region.angle), math.sin(region.angle)
    to_region = np.array([[c, s], [-s, c]])  # from the picture's axes to the region's
    hips = pose.picture[_HIP].mean(axis=0) - (region.x, region.y)
    corner = 0.5 * LANDMARK_SIZE + to_region @ (per_pixel * hips - step * np.array(HIPS))
    place = np.concatenate((corner, step * to_region.T.ravel()))
    draw_mask(np.ascontiguousarray(pose.mask, np.float32), place, picture)


def ring_names(performers: Sequence[str]) -> dict[str, str]:
    """Return the name of each performer's ring: `camera-` and the name, without accents, a dash for every sign that a
    ring's name may not have; a number behind it where two performers would have the same one."""
    names: dict[str, str] = {}
    for performer in performers:
        plain = unicodedata.normalize("NFKD", performer).encode("ascii", "ignore").decode()
        first = name = f"camera-{re.sub(r'[^A-Za-z0-9._-]', '-', plain)}"[:60]
        number = 2
        while name in names.values():
            name, number = f"{first}-{number}", number + 1
        names[performer] = name
    return names


@dataclass(slots=True, eq=False)
class _Outlet:
    """One performer's ring."""

    ring: FrameRing
    person: tuple[int, int] = (-1, -1)
    """Camera and number of the person in it."""
    scale: float = 0.0
    """Pixels of the camera's picture per metre."""
    last: float = -math.inf
    """When they were last seen [s]."""
    is_black: bool = False


class SilhouetteRings:
    """The rings of all performers. Thread: any."""

    def __init__(self, performers: Sequence[str]) -> None:
        """Open a ring, black, for each performer; what is wrong is told in `problem` and stops nothing."""
        self._lock = threading.Lock()
        self._outlets: dict[str, _Outlet] = {}
        self._black = np.zeros((SIZE[1], SIZE[0], 3), np.uint8)
        self._picture = self._black.copy()
        draw_mask(np.zeros((2, 2), np.float32), np.zeros(6), self._picture)  # loads the kernel
        self.problem = ""
        """Why a ring could not be opened; empty if all could."""
        self.rename(performers)

    @property
    def names(self) -> list[str]:
        """Names of the open rings."""
        with self._lock:
            return [each.ring.path.name for each in self._outlets.values()]

    def rename(self, performers: Sequence[str]) -> None:
        """Use the performers of another patch: rings of those who stay are kept, the others are removed."""
        names = ring_names(performers)
        with self._lock:
            for name, outlet in list(self._outlets.items()):
                if names.get(name) != outlet.ring.path.name:
                    self._end(outlet)
                    del self._outlets[name]
            self.problem = ""
            for performer, name in names.items():
                if performer not in self._outlets:
                    self._open(performer, name)

    def _open(self, performer: str, name: str) -> None:
        try:
            outlet = _Outlet(FrameRing(name, SIZE, private=True))
        except (OSError, ValueError) as error:  # another program's file, or no memory: the show does not need it
            self.problem = f"the silhouette of {performer} is not published: {error}"
            return
        self._outlets[performer] = outlet
        self._darken(outlet, 0.0)

    def show(self, performer: str, camera: int, person: Person, now: float) -> None:
        """Publish the silhouette of a performer as a camera has just seen them. `now` [s]: the present.

        While several cameras see them, the one that did so first is kept: the outline does not jump between views.
        """
        with self._lock:
            outlet = self._outlets.get(performer)
            if outlet is None or (outlet.person[0] != camera and now - outlet.last <= HELD_S):
                return
            scale = pixels_per_metre(person.pose)
            if scale <= 0.0:
                return
            if outlet.person != (camera, person.number) or outlet.is_black:
                outlet.person, outlet.scale = (camera, person.number), scale
            outlet.scale *= (scale / outlet.scale) ** _SCALE_SHARE
            draw_silhouette(person.pose, outlet.scale, self._picture)
            outlet.ring.write(self._picture, person.time)
            outlet.last, outlet.is_black = now, False

    def darken_unseen(self, now: float) -> None:
        """Make the picture of everybody black who has not been seen for `HELD_S`. `now` [s]: the present."""
        with self._lock:
            for outlet in self._outlets.values():
                if not outlet.is_black and now - outlet.last > HELD_S:
                    self._darken(outlet, now)

    def _darken(self, outlet: _Outlet, now: float) -> None:
        outlet.ring.write(self._black, now)
        outlet.is_black = True

    def _end(self, outlet: _Outlet) -> None:
        self._darken(outlet, max(outlet.last, 0.0))  # a reader keeps the last picture
        outlet.ring.close()

    def close(self) -> None:
        """Leave black behind, and remove the rings."""
        with self._lock:
            for outlet in self._outlets.values():
                self._end(outlet)
            self._outlets.clear()
