"""The animation of a glTF file that moves the dancer: its channels as curves, and the frames they are read at."""

from dataclasses import dataclass
from typing import Final

import numpy as np
import numpy.typing as npt

from live.motion import quaternion
from live.motion.formats.curves import Curve, Interpolation, key_rate
from live.motion.formats.file_error import shown
from live.motion.formats.gltf_accessors import Accessors
from live.motion.formats.json_place import JsonPlace
from live.motion.formats.nodes import Nodes

Float64 = npt.NDArray[np.float64]

PATHS: Final = {"translation": "VEC3", "rotation": "VEC4", "scale": "VEC3"}
LONGEST: Final = 36_000.0
"""Seconds that an animation may last."""
_INTERPOLATIONS: Final[tuple[Interpolation, ...]] = ("LINEAR", "STEP", "CUBICSPLINE")


@dataclass(frozen=True, slots=True)
class Channel:
    """One property of one node; its keys are read when they are needed."""

    node: int
    path: str
    """"translation", "rotation" or "scale"."""
    place: JsonPlace
    sampler: JsonPlace


@dataclass(frozen=True, slots=True)
class Animation:
    """One animation of the file with the channels that move nodes."""

    name: str
    channels: tuple[Channel, ...]


def list_animations(root: JsonPlace, nodes: Nodes) -> list[Animation]:
    """All animations; channels without a node (extensions) and of morph weights are left out."""
    animations = []
    for number, animation in enumerate(root.elements("animations")):
        samplers = animation.length("samplers")
        channels = []
        for channel in animation.elements("channels"):
            target = channel.object("target")
            path = target.text("path")
            if path not in PATHS or not target.has("node"):
                continue
            node = target.whole("node", below=nodes.count)
            sampler = animation.element("samplers", channel.whole("sampler", below=samplers))
            channels.append(Channel(node, path, channel, sampler))
        name = " ".join(animation.text("name").split())[:100] or f"number {number}"
        animations.append(Animation(name, tuple(channels)))
    return animations


@dataclass(frozen=True, slots=True)
class Frames:
    """Evenly spaced times at which an animation is read."""

    start: float
    rate: float
    count: int

    def times(self) -> Float64:
        """Shape (T,) [s]."""
        return self.start + np.arange(self.count) / self.rate


class CurveReader:
    """Reads the channels of one animation; key times, which channels share, are kept as far as they are few."""

    def __init__(self, accessors: Accessors, size: int) -> None:
        """`size` is that of the file in bytes."""
        self._accessors = accessors
        self._times: dict[int, Float64] = {}
        self._room = 1_000_000 + size // 4

    def frames(self, channels: list[Channel]) -> Frames:
        """From the first key to the last of all channels, at the rate of the one with most keys."""
        start, end, longest = np.inf, -np.inf, np.empty(0)
        for channel in channels:
            keys = self._key_times(channel)
            start, end = min(start, float(keys[0])), max(end, float(keys[-1]))
            longest = keys if len(keys) > len(longest) else longest
            if end - start > LONGEST:
                raise channel.sampler.error("input", f"lasts {end - start:.0f} s", f"at most {LONGEST:.0f} s expected")
        rate = key_rate(longest)
        return Frames(start, rate, round((end - start) * rate) + 1)

    def curve(self, channel: Channel) -> Curve:
        """Keys and interpolation of a channel; raises MotionFileError for what cannot be."""
        times, sampler = self._key_times(channel), channel.sampler
        said = sampler.text("interpolation", "LINEAR")
        way = next((known for known in _INTERPOLATIONS if known == said), None)
        if way is None:
            raise sampler.error("interpolation", f"is {shown(said)}", "LINEAR, STEP or CUBICSPLINE expected")
        index = sampler.whole("output", below=1 << 40)
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
                values = np.asarray(quaternion.continuous(values / lengths[:, None]), np.float64)
        return Curve(times, values, way, is_rotation, tangents)

    def _key_times(self, channel: Channel) -> Float64:
        index = channel.sampler.whole("input", below=1 << 40)
        if index in self._times:
            return self._times[index]
        times = self._accessors.read(index, "SCALAR")[:, 0]
        if not times.size:
            raise channel.sampler.error("input", "has no keys", "at least one expected")
        backwards = np.flatnonzero(np.diff(times) < 0.0)
        if backwards.size:
            words = f"runs backwards at key {backwards[0] + 1}"
            raise channel.sampler.error("input", words, "ascending times expected")
        if self._room >= times.size:
            self._room -= times.size
            self._times[index] = times
        return times
