"""The show without a window, in real time: for rehearsal, tests and long runs; with a picture if somebody takes it."""

import time
from collections.abc import Callable

from rich.console import Console

from live.base.errors import PersonError
from live.base.stage_view import Scene, StageView
from live.cli.session import Session
from live.render.pacing import Pacer


def play_headless(session: Session, scene: Scene, console: Console) -> None:
    """Run until the seconds are over or Ctrl-C; draws only if somebody takes the picture."""
    if session.wish.record is None and not session.wish.share:
        with session.running():
            _loop(session, lambda view: None, session.wish.film_fps)
        return
    from live.cli.recording import live_rate
    from live.cli.takers import Takers
    from live.render.headless import NoOpenGL, OffscreenTarget, create_headless_context
    from live.render.renderer import Renderer

    wish = session.wish
    try:
        ctx = create_headless_context()
    except NoOpenGL as error:
        raise PersonError(str(error)) from None
    target = OffscreenTarget(ctx, wish.size)
    renderer = Renderer(ctx, scene, size=wish.size)
    rate = live_rate(wish, ctx)
    takers = Takers(session, ctx, wish.size)

    def draw(view: StageView) -> None:
        renderer.draw(view, target.framebuffer)
        takers.frame(target.framebuffer, session.clock.now())

    try:
        with session.running():
            _loop(session, draw, rate)
    finally:
        takers.close(console)
        renderer.release()
        target.release()
        ctx.release()


def _loop(session: Session, draw: Callable[[StageView], None], rate: float) -> None:
    pacer = Pacer(rate, session.clock.now, time.sleep)
    previous = session.clock.now()
    while True:
        started = pacer.wait()
        session.before_frame()
        session.engine.frame(draw)
        session.status.late_frames = pacer.late
        session.after_frame(started, previous)
        previous = started
        if session.finished(started) or session.deserted:  # nobody sees it, and nobody is there to end it
            return
