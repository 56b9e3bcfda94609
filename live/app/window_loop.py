"""Frame loop of a show in windows, with recording and sharing of its picture."""

import time
from typing import TYPE_CHECKING

import moderngl
from rich.console import Console

from live.app.adaptive_quality import DrawingWatch, watch_shaders
from live.app.launch_options import LaunchOptions
from live.app.live_recording import LiveRecording, LiveSharing, live_rate
from live.app.output_config import places_of
from live.app.projector_setup import OutputSetup, set_up
from live.app.services.join_card import JoinCard
from live.app.session import Session
from live.app.window_operator import Operator
from live.base.errors import PersonError
from live.base.fault_isolation import Bulkhead, name_of
from live.base.stage_snapshot import Scene, StageView
from live.render.frame_stats import DisplayGrid, Pacer
from live.render.outputs.projection import Projection
from live.render.window.monitors import Monitor, UnknownMonitor
from live.render.window.screensaver import Awake, x11_display
from live.render.window.window import NoWindow
from live.show.show import Show

if TYPE_CHECKING:
    from live.show.venue.venue import Venue


class Picture(Projection):
    """The windows of a show, opened from command line and venue."""

    @classmethod
    def opened(
        cls, options: LaunchOptions, scene: Scene, *, monitor: Monitor | None, fullscreen: bool, hidden: bool = False,
        venue: "Venue | None" = None,
    ) -> "Picture":  # fmt: skip
        """Open the windows; `hidden`: they are invisible until revealed. Raise PersonError if that fails."""
        places = places_of(options, venue, monitor=monitor, fullscreen=fullscreen, hidden=hidden)
        try:
            return cls(scene, places)
        except (NoWindow, UnknownMonitor) as error:
            raise PersonError(str(error)) from None

    def rehearse(self, show: Show) -> None:
        """Draw one invisible picture, so that the driver compiles everything before the show."""
        view = show.view()
        show.fill(view, 0.0)
        self.renderer.draw(view, self.pictures.next)
        self.window.ctx.finish()


class Takers:
    """Consumers of the drawn pictures besides the window: recording and sharing.

    Thread: the main thread, which owns the OpenGL context.
    """

    def __init__(
        self, session: Session, ctx: moderngl.Context, size: tuple[int, int], *, sharing: LiveSharing | None = None
    ) -> None:
        """Make those of the options; raise PersonError if one fails. `sharing`: already made, closed elsewhere."""
        self._lent = sharing
        options, music, fps = session.options, session.sound.music, live_rate(session.options, ctx)
        self._calls = Bulkhead()
        self._all: list[LiveRecording | LiveSharing] = []
        if options.record is not None:
            self._all.append(LiveRecording(options.record, ctx, size, fps, music))
        if options.share:
            sharing = sharing or LiveSharing(options.share, ctx, size, fps, music)
            self._all.append(sharing)
            session.status.notes.append(sharing.words)
            session.status.more["shared"] = sharing.facts

    @property
    def any(self) -> bool:
        """Whether there is at least one."""
        return bool(self._all)

    def frame(self, framebuffer: moderngl.Framebuffer, time: float) -> None:
        """Pass on the picture just drawn at `time` [s of the show]."""
        for each in self._all:
            self._calls.call(name_of(each.frame), each.frame, framebuffer, time)

    def close(self, console: Console) -> None:
        """Close them, and print the result of each."""
        for each in self._all:
            if each is not self._lent:
                each.close(console)


PACE_ABOVE = 1.05
"""Factor of the loop's rate over the display's, so that vertical synchronisation sets the pace."""


def play_in_window(
    session: Session, scene: Scene, *, monitor: Monitor | None, fullscreen: bool, console: Console
) -> None:
    """Run the show in its windows until one is closed or the time limit is reached."""
    picture = Picture.opened(session.options, scene, monitor=monitor, fullscreen=fullscreen, venue=session.venue)
    try:
        play_picture(session, scene, picture, console=console)
    finally:
        picture.close()


def play_picture(
    session: Session, scene: Scene, picture: Picture, *, console: Console, reveal: bool | None = None,
    sharing: LiveSharing | None = None,
) -> None:  # fmt: skip
    """Run the show in open windows.

    `reveal`: the windows are hidden; show them now, in full screen (True) or not. `sharing`: already made by a standby.
    """
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

    rate = live_rate(session.options, window.ctx, window.monitor.refresh_hz)
    display = rate == window.monitor.refresh_hz  # the buffer swap paces the loop
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
