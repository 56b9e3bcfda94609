"""Adaptive picture quality of a live show, and hot reload of shaders from a user's folder."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Final

from rich.console import Console

from live.app.session import Session
from live.base.errors import PersonError
from live.base.stage_snapshot import StageView
from live.control.events.event import ControlEvent
from live.control.events.events import HoldQuality, ResetBreaker
from live.render.frame_budget import Affordance
from live.render.renderer import Renderer
from live.render.shader import names, own_text, read_from
from live.show.patch.patch import Patch

if TYPE_CHECKING:
    from live.app.session import Session


def watch_passes(session: Session, renderer: Renderer) -> None:
    """Let the operator enable render passes again that were disabled after an error."""

    def hear(event: ControlEvent) -> None:
        if isinstance(event, ResetBreaker):
            renderer.reset_pass(event.name)

    session.engine.outward.append(hear)


class DrawingWatch(Affordance):
    """Frame times and adaptive quality of one picture of a session; called around every frame."""

    def __init__(self, session: Session, renderer: Renderer) -> None:
        super().__init__(renderer, session.clock.now)
        self.overload = lambda: session.overload
        self.ladder.hold(session.options.quality)
        session.engine.mark = self.times.mark
        session.engine.outward.append(self.hear)
        watch_passes(session, renderer)
        session.engine.patched.append(self.take_patch)
        session.status.more["quality"] = self.facts
        session.status.more["frame_parts"] = self.times.facts
        session.status.notes.append(self._words)
        self._problem = ""
        session.status.notes.append(lambda: "; ".join(filter(None, (self._problem, *self._renderer.problems))))

    def hear(self, event: ControlEvent) -> None:
        """Handle the event that fixes the quality level."""
        if isinstance(event, HoldQuality):
            self.ladder.hold(None if event.step < 0.0 else round(event.step))

    def take_patch(self, patch: Patch) -> None:
        """Load the custom passes of another patch."""
        try:
            self._renderer.take_own(patch.picture.own_passes)
            self._problem = ""
        except PersonError as error:
            self._problem = f"{error}; the last good one stays in use"

    def graph(self, view: StageView) -> None:
        """Update the overlay's graph of frame times."""
        graph = self._renderer.graph
        graph.period = self.period * 1e3 if view.overlay else 0.0
        if view.overlay:
            graph.count = self.times.recent(graph.times)

    def _words(self) -> str:
        blamed = [f"{name} {count}" for name, count in self.times.blamed.items() if count]
        return "   ".join(filter(None, (self.words(), f"late by {', '.join(blamed)}" if blamed else "")))


EVERY: Final = 0.25
"""Interval [s] between two checks of the folder; it must be unchanged twice, so that no half-written file is read."""

Stamp = tuple[tuple[str, int, int], ...]


def begin_with(folder: Path, console: Console) -> None:
    """Use the shaders of `folder` from now on; if it does not exist, create it with copies of all shaders."""
    if not folder.exists():
        read_from(None)
        _copy_all(folder)
        console.print(f"all shaders were copied here for editing: {folder.resolve()}", soft_wrap=True, markup=False)
    known = set(names())
    there = {name for name, _, _ in stamp_of(folder)}
    for name in sorted(there - known):
        console.print(f"note: --shaders: {name} is none of the program's shaders", style="yellow", markup=False)
    if not there & known:
        raise PersonError(
            f"--shaders {folder}: none of the program's shaders is there", "name a folder that does not exist"
        )
    read_from(folder)


def _copy_all(folder: Path) -> None:
    try:
        folder.mkdir(parents=True)
        for name in names():
            (folder / name).write_text(own_text(name), encoding="utf-8")
    except OSError as error:
        raise PersonError(f"--shaders {folder}: it cannot be created: {error.strerror}") from None


def stamp_of(folder: Path) -> Stamp:
    """Return names, times and sizes of the shaders in a folder; empty if the folder is missing."""
    try:
        files = [each for each in os.scandir(folder) if each.name.endswith(".glsl") and each.is_file()]
        return tuple(sorted((each.name, each.stat().st_mtime_ns, each.stat().st_size) for each in files))
    except OSError:
        return ()


class ShaderWatch:
    """Checks the folder between frames. Thread: the main thread, which owns the OpenGL context."""

    def __init__(self, folder: Path, take: Callable[[], None]) -> None:
        """`take` rebuilds everything that draws; it raises PersonError if a shader does not compile."""
        self._folder, self._take = folder, take
        self._seen = self._taken = stamp_of(folder)
        self._next = 0.0
        self.problem = ""
        """Why the last edit failed; empty if it did not."""
        self.taken = 0
        """Number of edits in use."""

    def look(self, now: float) -> None:
        """Check at `now` [s] whether a file was edited; most calls return at once."""
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
            self.problem = f"{error}; the last good one stays in use"
        else:
            self.problem, self.taken = "", self.taken + 1


def watch_shaders(session: "Session", take: Callable[[], None]) -> "ShaderWatch | None":
    """Return a watch on the folder of `--shaders`, shown in overlay and status; None without the option."""
    if session.options.shaders is None:
        return None
    watch = ShaderWatch(session.options.shaders, take)
    session.status.notes.append(lambda: watch.problem)
    session.status.more["shaders"] = lambda: {"taken": watch.taken, "problem": watch.problem}
    return watch
