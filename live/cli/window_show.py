"""The show in a window: the frame loop, the operator's keys and pointer, and a film of it if asked for."""

import time
from dataclasses import replace
from typing import Any

from rich.console import Console

from live.base.errors import PersonError
from live.base.stage_view import Scene, StageView
from live.cli.recording import LiveRecording, live_rate
from live.cli.session import Session
from live.control.events import Attract, Repel
from live.control.keys import KEYS, event_for_key, event_for_pointer
from live.render.camera import floor_point
from live.render.monitors import Monitor, UnknownMonitor
from live.render.pacing import Pacer
from live.render.renderer import Renderer
from live.render.window import NoWindow, Window
from live.render.window_input import (
    CloseRequested,
    KeyPressed,
    PointerMoved,
    PointerPressed,
    PointerReleased,
    WindowInput,
)

TITLE = "ChoreoGraphics Live"
PACE_ABOVE = 1.05
"""At the display's own rate the loop's pace lies so much above it, so that vertical synchronisation sets it."""


class Operator:
    """What the operator does at the window becomes events, or changes the window itself."""

    def __init__(self, session: Session, window: Window, scene: Scene) -> None:
        self._session = session
        self._window = window
        self._scene = scene
        self._pressed = False
        self.leaving = False
        """Whether the window was asked to close."""

    def act(self, value: WindowInput, now: float) -> None:
        """One input at `now` [s of the show]."""
        match value:
            case KeyPressed():
                self._key(value, now)
            case PointerPressed():
                self._pressed = True
                self._point(value, now, drag=False)
            case PointerMoved() if self._pressed:
                self._point(value, now, drag=True)
            case PointerReleased():
                self._pressed = False
            case CloseRequested():
                self.leaving = True
            case _:
                pass

    def _key(self, key: KeyPressed, now: float) -> None:
        name = key.name.upper() if len(key.name) == 1 else key.name.capitalize()
        if name == "Escape":  # never out of a full-screen show; in a window it closes like the window's own button
            self.leaving = not self._window.fullscreen
            return
        what = KEYS[name].what if name in KEYS else ""
        if what == "window/fullscreen":
            self._window.toggle_fullscreen()
        elif what == "window/overlay":
            self._session.engine.overlay = not self._session.engine.overlay
        event = event_for_key(name, time=now, blackout_now=self._session.show.blackout)
        if event is not None:
            self._session.inbox.put(event)

    def _point(self, value: PointerPressed | PointerMoved, now: float, *, drag: bool) -> None:
        place = floor_point(self._scene.camera, self._window.size, (value.x, value.y))
        if place is None:
            return
        event = event_for_pointer(place[0], place[1], value.shift, now)
        if isinstance(event, Attract | Repel):
            self._session.inbox.put(replace(event, drag=drag))


def play_in_window(
    session: Session, scene: Scene, *, monitor: Monitor | None, fullscreen: bool, console: Console
) -> None:
    """Run the show in a window until it is closed or its seconds are over."""
    wish = session.wish
    try:
        window = Window(TITLE, monitor=monitor, fullscreen=fullscreen, size=wish.size)
    except (NoWindow, UnknownMonitor) as error:
        raise PersonError(str(error)) from None
    renderer: Renderer | None = None
    recording: LiveRecording | None = None
    try:
        renderer = Renderer(window.ctx, scene, size=window.size)
        if wish.record is not None:
            fps = live_rate(wish, window.ctx)
            recording = LiveRecording(wish.record, window.ctx, window.size, fps, session.sound.music)
        operator = Operator(session, window, scene)
        session.engine.on_error = lambda error: console.print(
            f"a frame could not be drawn: {error}", style="red", markup=False
        )
        with session.running():
            _loop(session, window, renderer, operator, recording)
    finally:
        if recording is not None:
            recording.close(console)
        if renderer is not None:
            renderer.release()
        window.close()


def _loop(
    session: Session, window: Window, renderer: Renderer, operator: Operator, recording: LiveRecording | None
) -> None:
    size = window.size

    def draw(view: StageView) -> None:
        nonlocal size
        if window.size != size:
            size = window.size
            renderer.resize(size)
        target: Any = window.target
        renderer.draw(view, target)

    rate = live_rate(session.wish, window.ctx, window.monitor.refresh_hz)
    if rate == window.monitor.refresh_hz:
        rate = min(rate * PACE_ABOVE, 1000.0)
    pacer = Pacer(rate, session.clock.now, time.sleep)
    previous = session.clock.now()
    while not operator.leaving:
        started = pacer.wait()
        for value in window.poll():
            operator.act(value, session.clock.now())
        session.engine.frame(draw)
        if recording is not None:
            recording.frame(window.target, started)
        session.status.late_frames = pacer.late
        session.after_frame(started, previous)
        window.swap()
        previous = started
        if session.finished(started):
            break
