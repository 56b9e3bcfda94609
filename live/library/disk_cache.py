"""Disk cache of step clips, with a key of the source data and the code; and safe reading of regular files."""

import errno
import json
import os
import stat
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path
from typing import Any, Final

import numpy as np

from live.base.disk.array_cache import ArrayCache, digest_of_code
from live.base.system.files import open_to_read
from live.motion.clip import Clip
from live.motion.step_clip import StepClip

_STEP_FIELDS: Final = tuple(field.name for field in fields(StepClip) if field.name != "clip")
_PACKAGE: Final = Path(__file__).resolve().parents[1]


@dataclass(frozen=True, slots=True)
class ClipCache(ArrayCache):
    """A cache of step clips of one kind."""

    def load_or_build(self, sources: Iterable[bytes], build: Callable[[], list[StepClip]]) -> list[StepClip]:
        """Return the clips for `sources` from the cache, or build and cache them.

        `sources` is all that the clips depend on besides the code, in a fixed order. An exception of `build` passes
        through, and nothing is cached.
        """
        path = self.entry_path(_code_digest(), sources)
        clips = self.load(path, clips_from_arrays)
        if clips is None:
            clips = build()
            if clips:
                self.store(path, clips_to_arrays(clips))
        return clips


@cache
def _code_digest() -> bytes:
    """Digest of the code that turns files into clips."""
    return digest_of_code(_PACKAGE / package for package in ("motion", "library"))


def _clip_header(step: StepClip) -> dict[str, Any]:
    return {
        "name": step.clip.name,
        "samples": step.clip.sample_count,
        "sample_rate": step.clip.sample_rate,
        "step": {name: getattr(step, name) for name in _STEP_FIELDS},
    }


def clips_to_arrays(clips: Sequence[StepClip]) -> dict[str, Any]:
    """Return all data of clips in four arrays; at least one clip."""
    return {
        "root": np.concatenate([c.clip.root_position for c in clips]),
        "rotation": np.concatenate([c.clip.rotation for c in clips]),
        "contact": np.concatenate([c.clip.contact for c in clips]),
        "rows": np.frombuffer(json.dumps([_clip_header(c) for c in clips]).encode(), np.uint8),
    }


def clips_from_arrays(arrays: dict[str, Any]) -> list[StepClip]:
    """Return the clips of the arrays from `clips_to_arrays`."""
    root, rotation, contact = arrays["root"], arrays["rotation"], arrays["contact"]
    clips, at = [], 0
    for row in json.loads(arrays["rows"].tobytes()):
        end = at + row["samples"]
        clip = Clip(row["name"], root[at:end], rotation[at:end], row["sample_rate"], contact[at:end])
        own = row["step"] | {name: tuple(row["step"][name]) for name in ("tags", "mood")}
        own["hands"] = tuple((float(beat), str(left), str(right)) for beat, left, right in own.get("hands", ()))
        clips.append(StepClip(clip=clip, **own))
        at = end
    return clips


def read_regular_file(path: Path, max_bytes: int) -> bytes:
    """Return the bytes of a regular file, at most one more than `max_bytes`, even if it grows meanwhile.

    OSError if it cannot be read, or is a folder, a pipe or a device.
    """
    handle = open_to_read(path)
    with open(handle, "rb") as file:  # closes the handle
        kind = os.fstat(handle).st_mode
        if stat.S_ISDIR(kind):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
        if not stat.S_ISREG(kind):
            raise OSError(errno.EINVAL, "a file expected, this is a pipe or a device", str(path))
        return file.read(max_bytes + 1)
