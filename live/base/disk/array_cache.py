"""Disk cache of named arrays, for values that take long to compute, under a key of their sources and of the code.

A cache only saves time. An entry that is cut off, damaged, of another version or unreadable (another user's) is ignored
and replaced, atomically; a folder that is full or read-only only means that the values are computed again. Entries are
numpy's npz files without pickled objects: reading one runs no code.
"""

import contextlib
import hashlib
import os
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any, TypeVar

import numpy as np

from live.base.disk.kernel_store import cache_root

Arrays = dict[str, np.ndarray[Any, Any]]
Value = TypeVar("Value")


def digest_of_code(places: Iterable[Path]) -> bytes:
    """Return a digest of these Python files and of all in these folders."""
    digest = hashlib.sha256()
    for place in places:
        for source in sorted(place.rglob("*.py")) if place.is_dir() else [place]:
            digest.update(source.read_bytes())
    return digest.digest()


@dataclass(frozen=True, slots=True)
class ArrayCache:
    """A cache of one kind: files `kind-KEY.npz`; the newest `max_entries` stay, with at most `max_bytes` together."""

    kind: str
    max_entries: int
    max_bytes: int = 4_000_000_000

    def entry_path(self, code: bytes, sources: Iterable[bytes]) -> Path:
        """Return the file of an entry.

        `code`: digest of the code that computes the values; `sources`: all else that they depend on, in a fixed order.
        """
        digest = hashlib.sha256(code)
        for source in sources:
            digest.update(len(source).to_bytes(8, "little"))
            digest.update(source)
        return cache_root().parent / f"{self.kind}-{digest.hexdigest()[:16]}.npz"

    def load(self, path: Path, unpack: Callable[[Arrays], Value]) -> Value | None:
        """Return what `unpack` makes of an entry's arrays; None if the entry is missing or unreadable.

        Reading renews the entry's time. `unpack` may raise any exception for arrays that it does not expect.
        """
        try:
            if not path.is_file():
                return None
            with path.open("rb") as file:
                value = unpack(read_arrays(file))
        except Exception:  # a damaged file makes zipfile, numpy, json and our own checks raise different errors
            return None
        with contextlib.suppress(OSError):  # in a read-only folder, or another user's
            os.utime(path)
        return value

    def store(self, path: Path, arrays: Arrays) -> None:
        """Write an entry atomically, and remove those that are too many; an error leaves the cache as it was."""
        unfinished = path.with_suffix(f".{os.getpid()}.tmp")
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with unfinished.open("wb") as file:
                write_arrays(file, arrays)
            unfinished.replace(path)
            self._evict(path.parent)
        except OSError:
            with contextlib.suppress(OSError):
                unfinished.unlink()

    def _evict(self, folder: Path) -> None:
        with os.scandir(folder) as there:
            names = [entry for entry in there if entry.name.startswith(f"{self.kind}-") and entry.name.endswith(".npz")]
        states = sorted(((entry.stat(), entry.path) for entry in names), key=lambda one: -one[0].st_mtime_ns)
        total = 0
        for number, (state, old) in enumerate(states):
            total += state.st_size
            if number >= self.max_entries or (number > 0 and total > self.max_bytes):
                Path(old).unlink(missing_ok=True)


def write_arrays(file: IO[bytes], arrays: Arrays) -> None:
    """Write arrays of numbers losslessly as numpy's npz."""
    np.savez(file, **arrays)  # type: ignore[arg-type]


def read_arrays(file: IO[bytes]) -> Arrays:
    """Read the arrays that `write_arrays` wrote; any exception for other data."""
    with np.load(file, allow_pickle=False) as data:
        return dict(data)
