"""The show in a window: the frame loop, and a film of it if asked for."""

import time

from rich.console import Console

from live.app.drawing_watch import DrawingWatch
from live.app.output_setup import OutputSetup
from live.app.recording import live_rate
from live.app.services.join_card import JoinCard
from live.app.session import Session
from live.app.shader_watch import watch_shaders
from live.app.sharing import LiveSharing
from live.app.takers import Takers
from live.app.window_operator import Operator
from live.app.window_picture import Picture
from live.app.window_setup import set_up
from live.base.stage_snapshot import Scene, StageView
from live.render.pacing import DisplayGrid, Pacer
from live.render.window.monitors import Monitor
from live.render.window.screensaver import Awake, x11_display

PACE_ABOVE = 1.05
"""At the display's own rate the loop's pace lies so much above it, so that vertical synchronisation sets it."""


def play_in_window(
    session: Session, scene: Scene, *, monitor: Monitor | None, fullscreen: bool, console: Console
) -> None:
    """Run the show in its windows until one is closed or its seconds are over."""
    picture = Picture.opened(session.wish, scene, monitor=monitor, fullscreen=fullscreen, venue=session.venue)
    try:
        play_picture(session, scene, picture, console=console)
    finally:
        picture.close()


def play_picture(
    session: Session, scene: Scene, picture: Picture, *, console: Console, reveal: bool | None = None,
    sharing: LiveSharing | None = None,
) -> None:  # fmt: skip
    """Run the show in windows that are open; `reveal`: they are hidden, show them now, full screen or not. `sharing`:
    the picture is shared already, by who stood by."""
    takers: Takers | None = None
    try:
        takers = Takers(session, picture.window.ctx, picture.size, sharing=sharing)
        if takers.any:
            picture.prepare_shown()
        operator = Operator(session, picture, scene)
        setup = set_up(session, picture, reveal is not None)
        session.engine.on_error = lambda error: console.print(
            f"a frame could not be drawn: {error}", style="red", markup=False
        )
        with session.running():
            if reveal is not None:
                picture.reveal(fullscreen=reveal)
            _loop(session, picture, operator, setup, takers)
    finally:
        if takers is not None:
            takers.close(console)


def _loop(session: Session, picture: Picture, operator: Operator, setup: OutputSetup, takers: Takers) -> None:
    awake = Awake(x11_display()).begin()
    try:
        _frames(session, picture, operator, setup, takers, awake)
    finally:
        setup.done()
        awake.end()


def _frames(
    session: Session,
    picture: Picture,
    operator: Operator,
    setup: OutputSetup,
    takers: Takers,
    awake: Awake,
) -> None:
    window = picture.window
    screen: bool | None = None
    watch = DrawingWatch(session, picture.renderer)

    shaders = watch_shaders(session, picture.take_shaders)
    card = JoinCard(session, picture)

    def draw(view: StageView) -> None:
        watch.graph(view)
        picture.draw(view)
        watch.times.mark("draw")

    rate = live_rate(session.wish, window.ctx, window.monitor.refresh_hz)
    display = rate == window.monitor.refresh_hz  # its swap paces the loop
    if display:
        rate = min(rate * PACE_ABOVE, 1000.0)
    pacer = Pacer(rate, session.clock.now, time.sleep)
    watch.period = 1.0 / min(rate, window.monitor.refresh_hz or rate)
    grid = DisplayGrid(1.0 / watch.period)
    previous = swapped = session.clock.now()
    while not operator.leaving:
        started = pacer.wait()
        watch.begin(pacer.late, started - previous)
        if shaders is not None:
            shaders.look(started)
        for where, value in picture.poll():
            if not setup.act(where, value):
                operator.act(picture.on_picture(where, value), session.clock.now())
        card.frame()
        session.before_frame()
        session.engine.frame(draw, at=grid.at(swapped if display else started))
        session.status.late_frames = pacer.late
        session.after_frame(started, previous)
        watch.times.mark("rest")
        picture.show(started)
        swapped = session.clock.now()
        takers.frame(picture.shown(), started)
        watch.end()
        awake.frame(started)
        if session.lifeline is not None and window.fullscreen is not screen:
            screen = window.fullscreen
            session.lifeline.tell_screen(screen, *(one.window.monitor.name for one in picture.screens))
        previous = started
        if session.finished(started):
            break
