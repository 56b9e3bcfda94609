"""Handler for the operator's keys and pointer in the show's window."""

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from live.base.picture_parameters import camera_from_row
from live.base.stage_snapshot import Scene
from live.control.events.events import ControlEvent, LearnMidi, PlaceElement, WalkOn
from live.control.keyboard import FORMATION_KEYS, KEYS, event_for_formation, event_for_key
from live.control.pointer import TOOLS, WALK_TOOL, event_for_place, event_for_stroke
from live.render.camera import floor_point
from live.render.outputs.projection import Projection
from live.render.outputs.test_card import JOIN_CARD
from live.render.uniforms import MIN_TARGET_DISTANCE
from live.render.window.window_input import (
    CloseRequested,
    KeyPressed,
    PointerMoved,
    PointerPressed,
    PointerReleased,
    WindowInput,
)
from live.show.patch.section_score import formation_names

if TYPE_CHECKING:
    from live.app.session import Session

MAX_STROKE_POINTS = 4096
"""Maximum number of points that a stroke keeps."""


class OperatorInput:
    """Converts window input of the operator to events, or changes the window itself."""

    def __init__(self, session: "Session", window: Projection, scene: Scene) -> None:
        self._session = session
        self._window = window
        self._scene = scene
        self._pressed = False
        self._tool = next(iter(TOOLS))
        self._stroke: list[tuple[float, float]] = []
        self._shift = False
        self.close_requested = False
        """Whether the window is to be closed."""

    def handle(self, value: WindowInput, now: float) -> None:
        """Handle one input at `now` [s of the show]."""
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
                self._finish_stroke(now)
            case CloseRequested():
                self.close_requested = True
            case _:
                pass

    def _key(self, key: KeyPressed, now: float) -> None:
        name = key.name.upper() if len(key.name) == 1 else key.name.capitalize()
        if name == "Escape":
            self._escape(now)
            return
        what = KEYS[name].command if name in KEYS else ""
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
        event = event_for_key(
            name,
            time=now,
            blackout_now=show.blackout,
            held_now=show.follower.held,
            show_held_now=show.desk.held,
            frozen_now=show.desk.master.frozen,
            dark_now=show.desk.master.goal < 1.0,
            code_now=JOIN_CARD in show.desk.master.cards.values(),
        )
        if name in FORMATION_KEYS:
            event = self._formation(FORMATION_KEYS.index(name), now)
        if event is not None:
            self._session.inbox.put(event)

    def _escape(self, now: float) -> None:
        """Cancel MIDI learning; else close the window, except in full screen."""
        if self._session.midi.learning.pending_control:
            self._session.inbox.put(LearnMidi(time=now, source="key", address=""))
        else:
            self.close_requested = not self._window.fullscreen

    def _formation(self, number: int, now: float) -> ControlEvent | None:
        formations = formation_names(self._session.show.patch.formation)
        return event_for_formation(formations[number], time=now) if number < len(formations) else None

    def _point(self, value: PointerPressed | PointerMoved, now: float, *, drag: bool) -> None:
        row = self._session.engine.view.picture
        camera = self._scene.camera if row is None else camera_from_row(row)  # as the picture shows it now
        if math.dist(camera.eye, camera.target) < MIN_TARGET_DISTANCE:
            return
        place = floor_point(camera, self._window.size, (value.x, value.y))
        if not drag:
            self._stroke, self._shift = [], value.shift
        if place is None:
            return
        if len(self._stroke) < MAX_STROKE_POINTS:
            self._stroke.append((float(place[0]), float(place[1])))
        event = event_for_place(self._tool, place[0], place[1], value.shift, now)
        if isinstance(event, PlaceElement):
            self._session.inbox.put(replace(event, drag=drag))
        elif isinstance(event, WalkOn):
            self._session.inbox.put(replace(event, anew=event.anew and not drag))

    def _finish_stroke(self, now: float) -> None:
        """Finish a stroke: send its event."""
        stroke, self._stroke = self._stroke, []
        if self._tool in (next(iter(TOOLS)), WALK_TOOL):
            return  # these tools have sent events during the stroke
        event = event_for_stroke(self._tool, stroke, self._shift, now)
        if event is not None:
            self._session.inbox.put(event)
