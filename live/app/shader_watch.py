"""The program's shaders in a folder of somebody's own: drawn with, and taken anew when a file there is edited."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Final

from rich.console import Console

from live.base.errors import PersonError
from live.render.shader import names, own_text, read_from

if TYPE_CHECKING:
    from live.app.session import Session

EVERY: Final = 0.25
"""Seconds between two looks at the folder; it must look the same twice, so that nothing half written is read."""

Stamp = tuple[tuple[str, int, int], ...]


def begin_with(folder: Path, console: Console) -> None:
    """Draw with the shaders of `folder` from now on. It is made, with copies of them all, if it is not there."""
    if not folder.exists():
        read_from(None)
        _copy_all(folder)
        console.print(f"all shaders are here, to be edited: {folder.resolve()}", soft_wrap=True, markup=False)
    known = set(names())
    there = {name for name, _, _ in stamp_of(folder)}
    for name in sorted(there - known):
        console.print(f"note: --shaders: {name} is none of the program's shaders", style="yellow", markup=False)
    if not there & known:
        raise PersonError(
            f"--shaders {folder}: none of the program's shaders is there", "name a folder that is not there"
        )
    read_from(folder)


def _copy_all(folder: Path) -> None:
    try:
        folder.mkdir(parents=True)
        for name in names():
            (folder / name).write_text(own_text(name), encoding="utf-8")
    except OSError as error:
        raise PersonError(f"--shaders {folder}: it cannot be made: {error.strerror}") from None


def stamp_of(folder: Path) -> Stamp:
    """Names, times and sizes of the shaders in a folder; nothing if it is away."""
    try:
        files = [each for each in os.scandir(folder) if each.name.endswith(".glsl") and each.is_file()]
        return tuple(sorted((each.name, each.stat().st_mtime_ns, each.stat().st_size) for each in files))
    except OSError:
        return ()


class ShaderWatch:
    """Looks at the folder between frames. Thread: the main thread, which owns the OpenGL context."""

    def __init__(self, folder: Path, take: Callable[[], None]) -> None:
        """`take` makes everything that draws anew; PersonError if a shader is no program."""
        self._folder, self._take = folder, take
        self._seen = self._taken = stamp_of(folder)
        self._next = 0.0
        self.problem = ""
        """Why the last edit could not be taken; empty if it could."""
        self.taken = 0
        """Edits that were."""

    def look(self, now: float) -> None:
        """Look at `now` [s] whether somebody has edited a file; most calls return at once."""
        if now < self._next:
            return
        self._next = now + EVERY
        stamp = stamp_of(self._folder)
        settled, self._seen = stamp == self._seen, stamp
        if not settled or stamp == self._taken or not stamp:
            return
        self._taken = stamp
        read_from(self._folder)
        try:
            self._take()
        except PersonError as error:
            self.problem = f"{error}; the last good one goes on"
        else:
            self.problem, self.taken = "", self.taken + 1


def watch_shaders(session: "Session", take: Callable[[], None]) -> "ShaderWatch | None":
    """A watch over the folder that was wished for, which tells in overlay and status what is wrong; None for none."""
    if session.wish.shaders is None:
        return None
    watch = ShaderWatch(session.wish.shaders, take)
    session.status.notes.append(lambda: watch.problem)
    session.status.more["shaders"] = lambda: {"taken": watch.taken, "problem": watch.problem}
    return watch
