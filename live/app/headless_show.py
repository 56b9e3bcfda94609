"""The show without a window, in real time: for rehearsal, tests and long runs; with a picture if somebody takes it."""

import contextlib
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from rich.console import Console

from live.app.headless_picture import HeadlessPicture
from live.app.session import Session
from live.base.errors import PersonError
from live.base.fault_isolation import FAULTS
from live.base.stage_snapshot import Scene, StageView
from live.render.pacing import Pacer

if TYPE_CHECKING:
    from live.app.drawing_watch import DrawingWatch
    from live.app.sharing import LiveSharing
    from live.show.patch.patch import Patch


def play_headless(
    session: Session, scene: Scene, console: Console, *, picture: HeadlessPicture | None = None,
    sharing: "LiveSharing | None" = None,
) -> None:  # fmt: skip
    """Run until the seconds are over or Ctrl-C; draws only if somebody takes the picture. `picture`, `sharing`: made
    already, by who stood by; whoever made them gives them back."""
    if session.lifeline is not None:
        session.engine.on_error = lambda error: FAULTS.note("drawing", error)
    if session.wish.record is None and not session.wish.share:
        with session.running():
            _loop(session, lambda view: None, session.wish.film_fps)
        return
    made = picture or HeadlessPicture(session.wish, scene)
    try:
        _draw(session, made, console, sharing)
    finally:
        if picture is None:
            made.close()


def _draw(session: Session, picture: HeadlessPicture, console: Console, sharing: "LiveSharing | None") -> None:
    from live.app.drawing_watch import DrawingWatch, watch_passes
    from live.app.recording import live_rate
    from live.app.shader_watch import watch_shaders
    from live.app.takers import Takers

    wish, renderer = session.wish, picture.renderer
    session.status.more["flashes_held"] = lambda: picture.flashes.held
    rate = live_rate(wish, picture.ctx)
    watch = None if wish.quality is None else DrawingWatch(session, renderer)  # whoever films asks for the best
    if watch is not None:
        watch.period = 1.0 / rate
    if watch is None:
        watch_passes(session, renderer)
        session.status.notes.append(lambda: "; ".join(renderer.problems))
    takers = Takers(session, picture.ctx, wish.size, sharing=sharing)
    shaders = watch_shaders(session, renderer.take_shaders)

    def take_patch(patch: "Patch") -> None:
        with contextlib.suppress(PersonError):  # it was tried before it came here: else the last good one goes on
            renderer.take_own(patch.picture.own_passes)

    session.engine.patched.append(take_patch if watch is None else watch.take_patch)

    def draw(view: StageView) -> None:
        if shaders is not None:
            shaders.look(session.clock.now())
        framebuffer = picture.draw(view, session.clock.now)
        takers.frame(framebuffer, session.clock.now())

    try:
        with session.running():
            _loop(session, draw, rate, watch)
    finally:
        takers.close(console)


def _loop(
    session: Session, draw: Callable[[StageView], None], rate: float, watch: "DrawingWatch | None" = None
) -> None:
    pacer = Pacer(rate, session.clock.now, time.sleep)
    previous = session.clock.now()
    while True:
        started = pacer.wait()
        if watch is not None:
            watch.begin(pacer.late, started - previous)
        session.before_frame()
        session.engine.frame(draw)
        session.status.late_frames = pacer.late
        session.after_frame(started, previous)
        if watch is not None:
            watch.end()
        previous = started
        if session.finished(started):
            return
