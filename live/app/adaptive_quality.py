"""Adaptive picture quality of a live show, and hot reload of shaders from a user's folder."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Final

from rich.console import Console

from live.base.errors import PersonError
from live.base.stage_snapshot import StageView
from live.control.events.event import ControlEvent
from live.control.events.events import HoldQuality, ResetBreaker
from live.render.renderer import Renderer
from live.render.shader import builtin_text, set_override_folder, shader_names
from live.render.timing.frame_budget import FrameBudget
from live.show.patch.patch import Patch
from live.show.selection.library_watch import folder_stamp
from live.show.view.render_scene import draw_patch

if TYPE_CHECKING:
    from live.app.session import Session


def handle_pass_resets(session: "Session", renderer: Renderer) -> None:
    """Let the operator enable render passes again that were disabled after an error."""

    def hear(event: ControlEvent) -> None:
        if isinstance(event, ResetBreaker):
            renderer.reset_pass(event.name)

    session.engine.event_listeners.append(hear)


class QualityController(FrameBudget):
    """Frame times and adaptive quality of one picture of a session; called around every frame."""

    def __init__(self, session: "Session", renderer: Renderer) -> None:
        super().__init__(renderer, session.clock.now)
        self.overload = lambda: session.overload
        self.controller.hold(session.options.quality)
        session.engine.mark = self.times.mark
        session.engine.event_listeners.append(self.handle)
        handle_pass_resets(session, renderer)
        session.engine.patch_listeners.append(self.update_patch)
        session.status.extra_figures["quality"] = self.facts
        session.status.extra_figures["frame_parts"] = self.times.facts
        session.status.notices.append(self._overlay_text)
        self._problem = ""
        session.status.notices.append(lambda: "; ".join(filter(None, (self._problem, *self._renderer.problems))))

    def handle(self, event: ControlEvent) -> None:
        """Handle the event that fixes the quality level."""
        if isinstance(event, HoldQuality):
            self.controller.hold(None if event.step < 0.0 else round(event.step))

    def update_patch(self, patch: Patch) -> None:
        """Draw the stage, the props and the custom passes of another patch."""
        try:
            draw_patch(self._renderer, patch)
            self._problem = ""
        except PersonError as error:
            self._problem = f"{error}; the last good one stays in use"

    def update_graph(self, view: StageView) -> None:
        """Update the overlay's graph of frame times."""
        graph = self._renderer.graph
        graph.period = self.period * 1e3 if view.overlay else 0.0
        if view.overlay:
            graph.count = self.times.copy_recent(graph.times)

    def _overlay_text(self) -> str:
        blamed = [f"{name} {count}" for name, count in self.times.late_causes.items() if count]
        return "   ".join(filter(None, (self.overlay_text(), f"late by {', '.join(blamed)}" if blamed else "")))


CHECK_INTERVAL: Final = 0.25
"""Interval [s] between two checks of the folder; it must be unchanged twice, so that no half-written file is read."""


def use_shader_folder(folder: Path, console: Console) -> None:
    """Use the shaders of `folder` from now on; if it does not exist, create it with copies of all shaders."""
    if not folder.exists():
        set_override_folder(None)
        _copy_all(folder)
        console.print(f"all shaders were copied here for editing: {folder.resolve()}", soft_wrap=True, markup=False)
    known = set(shader_names())
    there = {name for name, _, _ in folder_stamp(folder, ".glsl")}
    for name in sorted(there - known):
        console.print(f"note: --shaders: {name} is none of the program's shaders", style="yellow", markup=False)
    if not there & known:
        raise PersonError(
            f"--shaders {folder}: none of the program's shaders is there", "name a folder that does not exist"
        )
    set_override_folder(folder)


def _copy_all(folder: Path) -> None:
    try:
        folder.mkdir(parents=True)
        for name in shader_names():
            (folder / name).write_text(builtin_text(name), encoding="utf-8")
    except OSError as error:
        raise PersonError(f"--shaders {folder}: it cannot be created: {error.strerror}") from None


class ShaderWatch:
    """Checks the folder between frames. Thread: the main thread, which owns the OpenGL context."""

    def __init__(self, folder: Path, reload: Callable[[], None]) -> None:
        """`reload` rebuilds everything that draws; it raises PersonError if a shader does not compile."""
        self._folder, self._reload = folder, reload
        self._seen = self._loaded = folder_stamp(folder, ".glsl")
        self._next = 0.0
        self.problem = ""
        """Why the last edit failed; empty if it did not."""
        self.reloads = 0
        """Number of edits in use."""

    def check(self, now: float) -> None:
        """Check at `now` [s] whether a file was edited; most calls return at once."""
        if now < self._next:
            return
        self._next = now + CHECK_INTERVAL
        stamp = folder_stamp(self._folder, ".glsl")
        settled, self._seen = stamp == self._seen, stamp
        if not settled or stamp == self._loaded or not stamp:
            return
        self._loaded = stamp
        set_override_folder(self._folder)
        try:
            self._reload()
        except PersonError as error:
            self.problem = f"{error}; the last good one stays in use"
        else:
            self.problem, self.reloads = "", self.reloads + 1


def watch_shaders(session: "Session", reload: Callable[[], None]) -> ShaderWatch | None:
    """Return a watch on the folder of `--shaders`, shown in overlay and status; None without the option."""
    if session.options.shaders is None:
        return None
    watch = ShaderWatch(session.options.shaders, reload)
    session.status.notices.append(lambda: watch.problem)
    session.status.extra_figures["shaders"] = lambda: {"taken": watch.reloads, "problem": watch.problem}
    return watch
