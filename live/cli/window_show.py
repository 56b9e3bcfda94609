"""The show in a window: the frame loop, the operator's keys and pointer, and a film of it if asked for."""

import time
from dataclasses import replace
from typing import Any

from rich.console import Console

from live.base.errors import PersonError
from live.base.stage_view import Scene, StageView
from live.cli.recording import LiveRecording, live_rate
from live.cli.session import Session
from live.control.events import Attract, ControlEvent, Repel
from live.control.keys import FORMATION_KEYS, KEYS, event_for_formation, event_for_key
from live.control.pointer import TOOLS, event_for_place, event_for_stroke
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
from live.show.sections.segment import formation_names

TITLE = "ChoreoGraphics Live"
PACE_ABOVE = 1.05
"""At the display's own rate the loop's pace lies so much above it, so that vertical synchronisation sets it."""


LONGEST_STROKE = 4096
"""Points of a stroke that are kept while it is drawn."""


class Operator:
    """What the operator does at the window becomes events, or changes the window itself."""

    def __init__(self, session: Session, window: Window, scene: Scene) -> None:
        self._session = session
        self._window = window
        self._scene = scene
        self._pressed = False
        self._tool = next(iter(TOOLS))
        self._stroke: list[tuple[float, float]] = []
        self._shift = False
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
                self._let_go(now)
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
        elif what == "window/guides":
            self._session.engine.guides = not self._session.engine.guides
        elif name in TOOLS:
            self._tool = name
            self._session.status.tool = TOOLS[name].description
        show = self._session.show
        event = event_for_key(name, time=now, blackout_now=show.blackout, held_now=show.follower.held)
        if name in FORMATION_KEYS:
            event = self._formation(FORMATION_KEYS.index(name), now)
        if event is not None:
            self._session.inbox.put(event)

    def _formation(self, number: int, now: float) -> ControlEvent | None:
        formations = formation_names(self._session.show.patch.formation)
        return event_for_formation(formations[number], time=now) if number < len(formations) else None

    def _point(self, value: PointerPressed | PointerMoved, now: float, *, drag: bool) -> None:
        place = floor_point(self._scene.camera, self._window.size, (value.x, value.y))
        if not drag:
            self._stroke, self._shift = [], value.shift
        if place is None:
            return
        if len(self._stroke) < LONGEST_STROKE:
            self._stroke.append((float(place[0]), float(place[1])))
        event = event_for_place(self._tool, place[0], place[1], value.shift, now)
        if isinstance(event, Attract | Repel):
            self._session.inbox.put(replace(event, drag=drag))

    def _let_go(self, now: float) -> None:
        """A stroke is finished: what it draws begins to act."""
        stroke, self._stroke = self._stroke, []
        if self._tool == next(iter(TOOLS)):
            return  # it has acted all the while
        event = event_for_stroke(self._tool, stroke, self._shift, now)
        if event is not None:
            self._session.inbox.put(event)


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
