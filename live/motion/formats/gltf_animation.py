"""glTF animations: channels as interpolated curves (specification, C) and the frame times at which they are sampled."""

from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
import numpy.typing as npt

from live.base.arrays import Float, Float64
from live.motion import quaternion
from live.motion.formats.file_error import quoted
from live.motion.formats.gltf_accessors import AccessorReader
from live.motion.formats.gltf_document import JsonObject
from live.motion.formats.gltf_skeleton import NodeTree

Interpolation = Literal["LINEAR", "STEP", "CUBICSPLINE"]

KEY_TOLERANCE: Final = 0.01
"""Fraction between two keys that counts as on the key: times are float32, precise to 0.06 ms after ten minutes."""
MIN_KEY_INTERVAL: Final = 1e-3
"""Keys closer together than this [s] count as one."""
MAX_KEY_INTERVAL: Final = 1.0
"""Key intervals longer than this [s] are not used to find the frame rate."""
GRID_TOLERANCE: Final = 0.05
"""Fraction of a frame by which a key may deviate from the frame grid."""
MIN_RATE: Final = 20.0
IRREGULAR_RATE: Final = 60.0
"""Frames per second if the keys are not on a regular grid."""


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """K keys of a value of W numbers; a rotation is a unit quaternion (w, x, y, z)."""

    times: Float64
    """Ascending [s], shape (K,)."""
    values: Float64
    """At the keys, shape (K, W)."""
    interpolation: Interpolation
    is_rotation: bool
    tangents: tuple[Float64, Float64] | None = None
    """For CUBICSPLINE: incoming and outgoing [per second], (K, W) each."""

    def sample(self, times: Float64) -> Float:
        """Value at each of `times` (T,) [s], shape (T, W); constant before the first and after the last key."""
        if len(self.times) == 1:
            return np.broadcast_to(self.values[0], (len(times), self.values.shape[1]))
        after = np.clip(np.searchsorted(self.times, times, side="right"), 1, len(self.times) - 1)
        before = after - 1
        span = self.times[after] - self.times[before]
        part = np.clip((times - self.times[before]) / np.maximum(span, 1e-9), 0.0, 1.0)
        part = np.where(part < KEY_TOLERANCE, 0.0, np.where(part > 1.0 - KEY_TOLERANCE, 1.0, part))
        if self.interpolation == "STEP":
            return np.asarray(self.values[np.where(part < 1.0, before, after)])
        if self.tangents is not None:
            value = self._spline(before, after, part[:, None], span[:, None])
            return quaternion.unit(value) if self.is_rotation else value
        if self.is_rotation:
            return quaternion.slerp(self.values[before], self.values[after], part)
        return np.asarray(self.values[before] * (1.0 - part[:, None]) + self.values[after] * part[:, None])

    def _spline(
        self, before: npt.NDArray[np.int64], after: npt.NDArray[np.int64], t: Float64, span: Float64
    ) -> Float64:
        """Cubic Hermite spline: (2t³ - 3t² + 1) v_k + d (t³ - 2t² + t) b_k + (3t² - 2t³) v_k+1 + d (t³ - t²) a_k+1."""
        incoming, outgoing = self.tangents or (self.values, self.values)
        square, cube = t * t, t * t * t
        return np.asarray(
            (2.0 * cube - 3.0 * square + 1.0) * self.values[before]
            + span * (cube - 2.0 * square + t) * outgoing[before]
            + (3.0 * square - 2.0 * cube) * self.values[after]
            + span * (cube - square) * incoming[after]
        )


def key_rate(times: Float64) -> float:
    """Return the frames per second of the grid on which all keys (K,) [s] lie; 60 if there is none.

    Exporters write a key per frame, or omit some. Rates below 20 are multiplied by the smallest integer that reaches
    20, so that curvature between keys is kept.
    """
    gaps = np.diff(times)
    long = gaps[gaps > MIN_KEY_INTERVAL]
    if not long.size:
        return IRREGULAR_RATE
    blur = float(np.spacing(np.float32(np.abs(times).max())))
    for gap in (float(np.median(long)), float(long.min())):
        gap = float(times[-1] - times[0]) / float(np.round(gaps / gap).sum())  # a single gap is imprecise in float32
        places = (times - times[0]) / gap
        off = float(np.abs(places - np.round(places)).max())
        if off < GRID_TOLERANCE + blur / gap and gap <= MAX_KEY_INTERVAL:
            rate = 1.0 / gap
            if abs(rate - round(rate)) < 1e-4 * rate:
                rate = float(round(rate))
            return rate * float(np.ceil(MIN_RATE / rate - 1e-9)) if rate < MIN_RATE else rate
    return IRREGULAR_RATE


PATHS: Final = {"translation": "VEC3", "rotation": "VEC4", "scale": "VEC3"}
MAX_DURATION: Final = 36_000.0
"""Maximum duration of an animation [s]."""
_INTERPOLATIONS: Final[tuple[Interpolation, ...]] = ("LINEAR", "STEP", "CUBICSPLINE")


@dataclass(frozen=True, slots=True)
class Channel:
    """One animated property of one node; its keys are read on demand."""

    node: int
    path: str
    """"translation", "rotation" or "scale"."""
    place: JsonObject
    sampler: JsonObject


@dataclass(frozen=True, slots=True)
class Animation:
    """One animation of the file with the channels that move nodes."""

    name: str
    channels: tuple[Channel, ...]


def list_animations(root: JsonObject, nodes: NodeTree) -> list[Animation]:
    """Return all animations; channels without a node (extensions) and of morph weights are ignored."""
    animations = []
    for number, animation in enumerate(root.elements("animations")):
        samplers = animation.length("samplers")
        channels = []
        for channel in animation.elements("channels"):
            target = channel.object("target")
            path = target.text("path")
            if path not in PATHS or not target.has("node"):
                continue
            node = target.integer("node", below=nodes.count)
            sampler = animation.element("samplers", channel.integer("sampler", below=samplers))
            channels.append(Channel(node, path, channel, sampler))
        name = " ".join(animation.text("name").split())[:100] or f"number {number}"
        animations.append(Animation(name, tuple(channels)))
    return animations


@dataclass(frozen=True, slots=True)
class FrameTimes:
    """Evenly spaced times at which an animation is sampled."""

    start: float
    rate: float
    count: int

    def times(self) -> Float64:
        """Return the times, shape (T,) [s]."""
        return self.start + np.arange(self.count) / self.rate


class CurveReader:
    """Reads the channels of one animation; caches key times, which channels share, up to a size limit."""

    def __init__(self, accessors: AccessorReader, size: int) -> None:
        """`size` is the file size in bytes."""
        self._accessors = accessors
        self._times: dict[int, Float64] = {}
        self._cache_budget = 1_000_000 + size // 4

    def frames(self, channels: list[Channel]) -> FrameTimes:
        """Frame times from the first to the last key of all channels, at the rate of the channel with most keys."""
        start, end, longest = np.inf, -np.inf, np.empty(0)
        for channel in channels:
            keys = self._key_times(channel)
            start, end = min(start, float(keys[0])), max(end, float(keys[-1]))
            longest = keys if len(keys) > len(longest) else longest
            if end - start > MAX_DURATION:
                raise channel.sampler.error(
                    "input", f"lasts {end - start:.0f} s", f"at most {MAX_DURATION:.0f} s expected"
                )
        rate = key_rate(longest)
        return FrameTimes(start, rate, round((end - start) * rate) + 1)

    def curve(self, channel: Channel) -> Curve:
        """Return keys and interpolation of a channel; raises MotionFileError for invalid data."""
        times, sampler = self._key_times(channel), channel.sampler
        said = sampler.text("interpolation", "LINEAR")
        way = next((known for known in _INTERPOLATIONS if known == said), None)
        if way is None:
            raise sampler.error("interpolation", f"is {quoted(said)}", "LINEAR, STEP or CUBICSPLINE expected")
        index = sampler.integer("output", below=1 << 40)
        values = self._accessors.read(index, PATHS[channel.path])
        per_key = 3 if way == "CUBICSPLINE" else 1
        if len(values) != per_key * len(times):
            words = f"has {len(values)} values for {len(times)} keys"
            raise sampler.error("output", words, f"{per_key * len(times)} expected")
        is_rotation = channel.path == "rotation"
        if is_rotation:
            values = values[:, [3, 0, 1, 2]]
        tangents = (values[0::3], values[2::3]) if per_key == 3 else None
        values = values[1::3] if per_key == 3 else values
        if is_rotation:
            lengths = np.linalg.norm(values, axis=1)
            if (lengths < 1e-6).any():
                raise sampler.error("output", f"holds a zero rotation at key {np.argmin(lengths)}", "unit quaternions")
            if tangents is None:
                values = np.asarray(quaternion.align_signs(values / lengths[:, None]), np.float64)
        return Curve(times, values, way, is_rotation, tangents)

    def _key_times(self, channel: Channel) -> Float64:
        index = channel.sampler.integer("input", below=1 << 40)
        if index in self._times:
            return self._times[index]
        times = self._accessors.read(index, "SCALAR")[:, 0]
        if not times.size:
            raise channel.sampler.error("input", "has no keys", "at least one expected")
        backwards = np.flatnonzero(np.diff(times) < 0.0)
        if backwards.size:
            words = f"runs backwards at key {backwards[0] + 1}"
            raise channel.sampler.error("input", words, "ascending times expected")
        if self._cache_budget >= times.size:
            self._cache_budget -= times.size
            self._times[index] = times
        return times
