"""Who is drawn how: lists of dancers for each way of drawing and each body, filled anew for every picture."""

from dataclasses import dataclass
from typing import Final

import moderngl
import numpy as np
import numpy.typing as npt

from live.base.stage_view import StageView
from live.render.group_styles import GroupStyles
from live.render.quality import Quality

Bool = npt.NDArray[np.bool_]
Float32 = npt.NDArray[np.float32]
Int32 = npt.NDArray[np.int32]

LISTS: Final = (
    "all", "near", "far", "bodies near", "bodies far", "ink near", "ink far", "particles", "ribbons", "trails",
    "xray",
)  # fmt: skip
"""`all` cast shadows, `near` and `far` are lit bodies and nothing else; the others are drawn in a style."""


@dataclass(frozen=True, slots=True, eq=False)
class Sight:
    """A camera as far as the lists need it."""

    forward: Float32
    """The way it looks, a unit vector, shape (3,)."""
    start: float
    """Where along that way it stands [m]."""


class Instances:
    """The lists of one crowd of at most `capacity` dancers, whose bodies are `body` (A,), 0 to `bodies` - 1."""

    def __init__(self, ctx: moderngl.Context, capacity: int, body: Int32, bodies: int) -> None:
        self._body, self._bodies = body, bodies
        self._indices = np.arange(capacity, dtype=np.float32)
        self._distance = np.zeros(capacity, np.float32)
        self._buffers = {
            (name, kind): ctx.buffer(reserve=capacity * 4, dynamic=True) for name in LISTS for kind in range(bodies)
        }
        self._counts = dict.fromkeys(self._buffers, 0)

    def count(self, name: str, body: int) -> int:
        """How many dancers of a body are on a list."""
        return self._counts[name, body]

    def buffer(self, name: str, body: int) -> moderngl.Buffer:
        """Their numbers, float32 each."""
        return self._buffers[name, body]

    def fill(self, view: StageView, sight: Sight, quality: Quality, styles: GroupStyles) -> int:
        """Fill all lists for a moment seen so; returns how many dancers are on the stage."""
        self._counts = dict.fromkeys(self._buffers, 0)
        indices = self._indices[: len(view.present)]
        there = indices if view.present.all() else np.ascontiguousarray(indices[view.present])
        if len(there) == 0:
            return 0
        near, far = self._split(view, there, sight, quality)
        if styles.any:
            self._fill_styled(view.group, there, near, far, styles)
        else:
            for name, some in (("all", there), ("near", near), ("far", far)):
                self._put(name, some)
        return len(there)

    def _fill_styled(self, group: Int32, there: Float32, near: Float32, far: Float32, styles: GroupStyles) -> None:
        masks = styles.masks
        for names, some in (
            (
                {"all": masks["casting"]} | {name: masks[name] for name in ("particles", "ribbons", "trails", "xray")},
                there,
            ),
            ({"near": styles.plain, "bodies near": masks["bodies"], "ink near": masks["ink"]}, near),
            ({"far": styles.plain, "bodies far": masks["bodies"], "ink far": masks["ink"]}, far),
        ):
            own = None  # the group of each, looked up once
            for name, mask in names.items():
                if mask.all():
                    self._put(name, some)
                elif mask.any() and len(some):
                    own = group[some.astype(np.int32)] % len(mask) if own is None else own
                    self._put(name, some[mask[own]])

    def _put(self, name: str, some: Float32) -> None:
        if len(some) == 0:
            return
        if self._bodies == 1:
            self._counts[name, 0] = len(some)
            self._buffers[name, 0].write(some)
            return
        body = self._body[some.astype(np.int32)]
        for kind in range(self._bodies):
            own = np.ascontiguousarray(some[body == kind])
            self._counts[name, kind] = len(own)
            if len(own):
                self._buffers[name, kind].write(own)

    def _split(self, view: StageView, there: Float32, sight: Sight, quality: Quality) -> tuple[Float32, Float32]:
        """Those who get the near body and the others: the nearest ones, and everybody nearer than `far_from`."""
        count = len(there)
        near = min(quality.near_count, count)
        if near == count:
            return there, there[:0]
        distance = np.matmul(view.joint_position[:, 0], sight.forward, out=self._distance[: len(view.present)])
        own = distance if count == len(distance) else distance[view.present]
        near = max(near, int(np.count_nonzero(own < sight.start + quality.far_from)))
        if near >= count:
            return there, there[:0]
        order = np.argpartition(own, near)
        return np.ascontiguousarray(there[order[:near]]), np.ascontiguousarray(there[order[near:]])

    def release(self) -> None:
        """Free the buffers."""
        for buffer in self._buffers.values():
            buffer.release()
