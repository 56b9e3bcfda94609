"""The show in a window: the frame loop, the operator's keys and pointer, and a film of it if asked for."""

import contextlib
import math
import time
from dataclasses import replace
from typing import TYPE_CHECKING

from rich.console import Console

from live.base.errors import PersonError
from live.base.picture import camera_of
from live.base.stage_view import Scene, StageView
from live.cli.drawing_watch import DrawingWatch
from live.cli.floor_keeping import FloorKeeping
from live.cli.output_keeping import OutputKeeping
from live.cli.output_places import outputs_of, places_of
from live.cli.output_setup import OutputSetup
from live.cli.recording import live_rate
from live.cli.session import Session
from live.cli.shader_watch import watch_shaders
from live.cli.takers import Takers
from live.cli.wish import Wish
from live.control.events import Attract, ControlEvent, LearnMidi, Repel, ShowCard, WalkOn
from live.control.keys import FORMATION_KEYS, KEYS, event_for_formation, event_for_key
from live.control.pointer import TOOLS, WALKED, event_for_place, event_for_stroke
from live.render.awake import Awake, x11_display
from live.render.camera import floor_point
from live.render.frame import CLOSEST
from live.render.monitors import Monitor, UnknownMonitor
from live.render.outputs.join_card import join_card
from live.render.outputs.projection import Projection
from live.render.outputs.test_cards import JOIN
from live.render.pacing import DisplayGrid, Pacer
from live.render.window import NoWindow
from live.render.window_input import (
    CloseRequested,
    KeyPressed,
    PointerMoved,
    PointerPressed,
    PointerReleased,
    WindowInput,
)
from live.show.core import Show
from live.show.sections.segment import formation_names

if TYPE_CHECKING:
    from live.show.venue import Venue

PACE_ABOVE = 1.05
"""At the display's own rate the loop's pace lies so much above it, so that vertical synchronisation sets it."""


LONGEST_STROKE = 4096
"""Points of a stroke that are kept while it is drawn."""


class Operator:
    """What the operator does at the window becomes events, or changes the window itself."""

    def __init__(self, session: Session, window: "Projection", scene: Scene) -> None:
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
        if name == "Escape":
            self._escape(now)
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
        event = event_for_key(
            name,
            time=now,
            blackout_now=show.blackout,
            held_now=show.follower.held,
            show_held_now=show.desk.held,
            frozen_now=show.desk.master.frozen,
            dark_now=show.desk.master.goal < 1.0,
            code_now=JOIN in show.desk.master.cards.values(),
        )
        if name in FORMATION_KEYS:
            event = self._formation(FORMATION_KEYS.index(name), now)
        if event is not None:
            self._session.inbox.put(event)

    def _escape(self, now: float) -> None:
        """Nothing is learned after all; else never out of a full-screen show: in a window it closes like the window's
        own button."""
        if self._session.midi.learning.waits_for:
            self._session.inbox.put(LearnMidi(time=now, source="key", address=""))
        else:
            self.leaving = not self._window.fullscreen

    def _formation(self, number: int, now: float) -> ControlEvent | None:
        formations = formation_names(self._session.show.patch.formation)
        return event_for_formation(formations[number], time=now) if number < len(formations) else None

    def _point(self, value: PointerPressed | PointerMoved, now: float, *, drag: bool) -> None:
        row = self._session.engine.view.picture
        camera = self._scene.camera if row is None else camera_of(row)  # as the picture shows it now
        if math.dist(camera.eye, camera.target) < CLOSEST:
            return
        place = floor_point(camera, self._window.size, (value.x, value.y))
        if not drag:
            self._stroke, self._shift = [], value.shift
        if place is None:
            return
        if len(self._stroke) < LONGEST_STROKE:
            self._stroke.append((float(place[0]), float(place[1])))
        event = event_for_place(self._tool, place[0], place[1], value.shift, now)
        if isinstance(event, Attract | Repel):
            self._session.inbox.put(replace(event, drag=drag))
        elif isinstance(event, WalkOn):
            self._session.inbox.put(replace(event, anew=event.anew and not drag))

    def _let_go(self, now: float) -> None:
        """A stroke is finished: what it draws begins to act."""
        stroke, self._stroke = self._stroke, []
        if self._tool in (next(iter(TOOLS)), WALKED):
            return  # it has acted all the while
        event = event_for_stroke(self._tool, stroke, self._shift, now)
        if event is not None:
            self._session.inbox.put(event)


class JoinCard:
    """Makes the card that an audience joins by, while somebody shows it, whenever its link is another one."""

    def __init__(self, session: Session, picture: Projection) -> None:
        self._audience, self._picture = session.audience, picture
        self._link = ""

    def frame(self) -> None:
        """Before each frame."""
        audience = self._audience
        if audience is None or audience.link == self._link or not audience.code:
            return
        if any(screen.card == JOIN for screen in self._picture.all):
            self._link = audience.link
            self._picture.take_sheet(join_card(audience.code, audience.link))


class Picture(Projection):
    """A projection that a command line opened."""

    @classmethod
    def opened(
        cls, wish: Wish, scene: Scene, *, monitor: Monitor | None, fullscreen: bool, hidden: bool = False,
        venue: "Venue | None" = None,
    ) -> "Picture":  # fmt: skip
        """Open its windows; `hidden`: they are seen only when they are revealed. PersonError if there can be none."""
        places = places_of(wish, venue, monitor=monitor, fullscreen=fullscreen, hidden=hidden)
        try:
            return cls(scene, places)
        except (NoWindow, UnknownMonitor) as error:
            raise PersonError(str(error)) from None

    def rehearse(self, show: Show) -> None:
        """Draw a picture that nobody sees, so that the driver has compiled everything before it counts."""
        view = show.view()
        show.fill(view, 0.0)
        self.renderer.draw(view, self.pictures.next)
        self.window.ctx.finish()


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
    session: Session, scene: Scene, picture: Picture, *, console: Console, reveal: bool | None = None
) -> None:
    """Run the show in windows that are open; `reveal`: they are hidden, show them now, full screen or not."""
    takers: Takers | None = None
    try:
        takers = Takers(session, picture.window.ctx, picture.size)
        if takers.any:
            picture.prepare_shown()
        operator = Operator(session, picture, scene)
        setup = _setup(session, picture, reveal is not None)
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


def _setup(session: Session, picture: Picture, anew: bool) -> OutputSetup:
    """How projectors are set up; `anew`: they may be bent otherwise by now than when the windows were opened."""
    if anew:
        with contextlib.suppress(PersonError):
            for screen, output in zip(
                picture.screens, outputs_of(session.wish.read_venue(), session.wish.venue), strict=False
            ):
                screen.set(replace(screen.output, corners=output.corners, mesh=output.mesh))

    def told(words: str) -> None:
        setup.kept = words

    keeping = OutputKeeping(session.wish.venue, told)

    def ask(output: str, card: str) -> None:
        session.inbox.put(ShowCard(time=session.clock.now(), source="key", output=output, card=card))

    floor = FloorKeeping(session, keeping, lambda: picture.size)
    setup = OutputSetup(
        picture, keeping.keep, session.show.refusals.add, ask, floor, joins=session.audience is not None
    )
    setup.recall(session.show.desk.master.cards)
    session.engine.outward.append(setup.hear)
    session.status.more["outputs"] = setup.facts
    session.status.more["flashes_held"] = lambda: picture.flashes.held
    session.status.notes.append(lambda: setup.kept if setup.kept.startswith("NOT") else "")
    return setup


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
