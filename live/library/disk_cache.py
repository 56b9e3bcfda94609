"""Disk cache of step clips, with a key of the source data and the code; and safe reading of regular files.

A stale entry is never read and is deleted when newer ones need its room. The cache only saves time: every error in it
is ignored, and the clips are built again.
"""

import contextlib
import errno
import hashlib
import json
import os
import stat
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path
from typing import IO, Any, Final

import numpy as np

from live.base.kernel_store import cache_root
from live.motion.clip import Clip
from live.motion.step_clip import StepClip

_STEP_FIELDS: Final = tuple(field.name for field in fields(StepClip) if field.name != "clip")
_PACKAGE: Final = Path(__file__).resolve().parents[1]


@dataclass(frozen=True, slots=True)
class ClipCache:
    """A cache of one kind: files `kind-KEY.npz`; the newest `max_entries` stay, with at most `max_bytes` together."""

    kind: str
    max_entries: int
    max_bytes: int = 4_000_000_000

    def load_or_build(self, sources: Iterable[bytes], build: Callable[[], list[StepClip]]) -> list[StepClip]:
        """Return the clips for `sources` from the cache, or build and cache them.

        `sources` is all that the clips depend on besides the code, in a fixed order. An exception of `build` passes
        through, and nothing is cached.
        """
        path = self._path(sources)
        clips = _read_cached(path)
        if clips is None:
            clips = build()
            if clips:
                self._write(path, clips)
        return clips

    def _path(self, sources: Iterable[bytes]) -> Path:
        digest = hashlib.sha256(_code_digest())
        for source in sources:
            digest.update(len(source).to_bytes(8, "little"))
            digest.update(source)
        return cache_root().parent / f"{self.kind}-{digest.hexdigest()[:16]}.npz"

    def _write(self, path: Path, clips: list[StepClip]) -> None:
        unfinished = path.with_suffix(f".{os.getpid()}.tmp")
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with unfinished.open("wb") as file:
                write_clips(file, clips)
            unfinished.replace(path)
            self._evict(path.parent)
        except OSError:
            with contextlib.suppress(OSError):
                unfinished.unlink()

    def _evict(self, folder: Path) -> None:
        caches = [(cache.stat(), cache) for cache in folder.glob(f"{self.kind}-*.npz")]
        total = 0
        for number, (state, old) in enumerate(sorted(caches, key=lambda one: one[0].st_mtime_ns, reverse=True)):
            total += state.st_size
            if number >= self.max_entries or (number > 0 and total > self.max_bytes):
                old.unlink(missing_ok=True)


@cache
def _code_digest() -> bytes:
    """Digest of the code that turns files into clips."""
    digest = hashlib.sha256()
    for package in ("motion", "library"):
        for source in sorted((_PACKAGE / package).rglob("*.py")):
            digest.update(source.read_bytes())
    return digest.digest()


def _clip_header(step: StepClip) -> dict[str, Any]:
    return {
        "name": step.clip.name,
        "samples": step.clip.sample_count,
        "sample_rate": step.clip.sample_rate,
        "step": {name: getattr(step, name) for name in _STEP_FIELDS},
    }


def _read_cached(path: Path) -> list[StepClip] | None:
    """Read the clips cached at `path`, None if they are missing or unreadable; reading renews the file's time."""
    try:
        if not path.is_file():
            return None
        with path.open("rb") as file:
            clips = read_clips(file)
        os.utime(path)
    except Exception:  # a damaged file makes zipfile, numpy, json and our own checks raise different errors
        return None
    return clips


def write_clips(file: IO[bytes], clips: Sequence[StepClip]) -> None:
    """Write clips losslessly as numpy's npz; at least one."""
    np.savez(file, **clips_to_arrays(clips))


def read_clips(file: IO[bytes]) -> list[StepClip]:
    """Read the clips that `write_clips` wrote; any exception for other data."""
    with np.load(file, allow_pickle=False) as data:
        return clips_from_arrays(dict(data))


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
        clips.append(StepClip(clip=clip, **row["step"] | {name: tuple(row["step"][name]) for name in ("tags", "mood")}))
        at = end
    return clips


def read_regular_file(path: Path, max_bytes: int) -> bytes:
    """Return the bytes of a regular file, at most one more than `max_bytes`, even if it grows meanwhile.

    OSError if it cannot be read, or is a folder, a pipe or a device.
    """
    handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0))
    with open(handle, "rb") as file:  # closes the handle
        kind = os.fstat(handle).st_mode
        if stat.S_ISDIR(kind):
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
        if not stat.S_ISREG(kind):
            raise OSError(errno.EINVAL, "a file expected, this is a pipe or a device", str(path))
        return file.read(max_bytes + 1)
