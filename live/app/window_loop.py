"""Frame loop of a show in windows, with recording and sharing of its picture."""

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

import moderngl
from rich.console import Console

from live.app.adaptive_quality import QualityController, watch_shaders
from live.app.film.live_recording import LivePages, LiveRecording, LiveSharing, live_fps
from live.app.launch_options import LaunchOptions
from live.app.output_config import window_placement
from live.app.projector_setup import OutputSetup, make_output_setup
from live.app.services.join_card import JoinCard
from live.app.session import Session
from live.app.window_operator import OperatorInput
from live.base.errors import PersonError
from live.base.fault_isolation import Bulkhead, callback_name
from live.base.stage_snapshot import Scene, StageView
from live.render.outputs.projection import Projection
from live.render.timing.frame_stats import DisplayGrid, Pacer
from live.render.window.monitors import Monitor, UnknownMonitor
from live.render.window.screensaver import ScreensaverInhibitor, x11_display
from live.render.window.window import NoWindow
from live.show.show import Show

if TYPE_CHECKING:
    from live.show.venue.venue import Venue


class ShowWindows(Projection):
    """The windows of a show, opened from command line and venue."""

    @classmethod
    def from_options(
        cls, options: LaunchOptions, scene: Scene, *, monitor: Monitor | None, fullscreen: bool, hidden: bool = False,
        venue: "Venue | None" = None,
    ) -> "ShowWindows":  # fmt: skip
        """Open the windows; `hidden`: they are invisible until revealed. Raise PersonError if that fails."""
        places = window_placement(options, venue, monitor=monitor, fullscreen=fullscreen, hidden=hidden)
        try:
            return cls(scene, places)
        except (NoWindow, UnknownMonitor) as error:
            raise PersonError(str(error)) from None

    def warm_up(self, show: Show) -> None:
        """Draw one invisible picture, so that the driver compiles everything before the show."""
        view = show.view()
        show.fill(view, 0.0)
        self.renderer.draw(view, self.pictures.next)
        self.window.ctx.finish()


class FrameSinks:
    """Consumers of the drawn pictures besides the window: recording, sharing, and web pages.

    Thread: the main thread, which owns the OpenGL context.
    """

    def __init__(
        self, session: Session, ctx: moderngl.Context, size: tuple[int, int], *, sharing: LiveSharing | None = None
    ) -> None:
        """Make those of the options; raise PersonError if one fails. `sharing`: already made, closed elsewhere."""
        self._shared_sink = sharing
        options, sound, fps = session.options, session.sound, live_fps(session.options, ctx)
        self._calls = Bulkhead()
        self._sinks: list[LiveRecording | LiveSharing | LivePages] = []
        if options.record is not None:
            self._sinks.append(LiveRecording(options.record, ctx, size, fps, sound.music))
        if options.share:
            sharing = sharing or LiveSharing(options.share, ctx, size, fps, sound.music)
            self._sinks.append(sharing)
            session.status.notices.append(sharing.problem_text)
            session.status.extra_figures["shared"] = sharing.facts
        if session.web is not None:
            self._sinks.append(LivePages(session.web, ctx, size))

    @property
    def is_active(self) -> bool:
        """Whether there is at least one."""
        return bool(self._sinks)

    def frame(self, framebuffer: moderngl.Framebuffer, time: float) -> None:
        """Pass on the picture just drawn at `time` [s of the show]."""
        for each in self._sinks:
            self._calls.call(callback_name(each.frame), each.frame, framebuffer, time)

    def close(self, console: Console) -> None:
        """Close them, and print the result of each."""
        for each in self._sinks:
            if each is not self._shared_sink:
                each.close(console)


DISPLAY_RATE_FACTOR = 1.05
"""Factor of the loop's rate over the display's, so that vertical synchronisation sets the pace."""


def play_in_window(
    session: Session, scene: Scene, *, monitor: Monitor | None, fullscreen: bool, console: Console,
    opened: Callable[[], None] = lambda: None,
) -> None:  # fmt: skip
    """Run the show in its windows until one is closed or the time limit is reached; `opened`: called before."""
    picture = ShowWindows.from_options(
        session.options, scene, monitor=monitor, fullscreen=fullscreen, venue=session.venue
    )
    try:
        opened()
        picture.window.make_current()
        run_in_windows(session, scene, picture, console=console)
    finally:
        picture.close()


def run_in_windows(
    session: Session, scene: Scene, picture: ShowWindows, *, console: Console, reveal: bool | None = None,
    sharing: LiveSharing | None = None,
) -> None:  # fmt: skip
    """Run the show in open windows.

    `reveal`: the windows are hidden; show them now, in full screen (True) or not. `sharing`: already made by a standby.
    """
    takers: FrameSinks | None = None
    try:
        takers = FrameSinks(session, picture.window.ctx, picture.size, sharing=sharing)
        if takers.is_active:
            picture.prepare_output_frame()
        operator = OperatorInput(session, picture, scene)
        setup = make_output_setup(session, picture, reveal is not None)
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


def _loop(
    session: Session, picture: ShowWindows, operator: OperatorInput, setup: OutputSetup, takers: FrameSinks
) -> None:
    awake = ScreensaverInhibitor(x11_display()).start()
    try:
        _frames(session, picture, operator, setup, takers, awake)
    finally:
        setup.stop_editing()
        awake.stop()


def _frames(
    session: Session,
    picture: ShowWindows,
    operator: OperatorInput,
    setup: OutputSetup,
    takers: FrameSinks,
    awake: ScreensaverInhibitor,
) -> None:
    window = picture.window
    screen: bool | None = None
    watch = QualityController(session, picture.renderer)
    watch.update_patch(session.show.patch)  # of a show that goes on, it may have been edited

    shaders = watch_shaders(session, picture.reload_shaders)
    card = JoinCard(session.audience, picture)

    def draw(view: StageView) -> None:
        watch.update_graph(view)
        picture.draw(view)
        watch.times.mark("draw")

    rate = live_fps(session.options, window.ctx, window.monitor.refresh_hz)
    display = rate == window.monitor.refresh_hz  # the buffer swap paces the loop
    if display:
        rate = min(rate * DISPLAY_RATE_FACTOR, 1000.0)
    pacer = Pacer(rate, session.clock.now, time.sleep)
    watch.period = 1.0 / min(rate, window.monitor.refresh_hz or rate)
    grid = DisplayGrid(1.0 / watch.period)
    previous = swapped = session.clock.now()
    while not operator.close_requested:
        started = pacer.wait()
        watch.begin(pacer.late, started - previous)
        if shaders is not None:
            shaders.check(started)
        for where, value in picture.poll():
            if not setup.handle_input(where, value):
                operator.handle(picture.to_picture(where, value), session.clock.now())
        card.frame()
        session.before_frame()
        session.engine.frame(draw, at=grid.align(swapped if display else started))
        session.status.late_frames = pacer.late
        session.after_frame(started, previous)
        watch.times.mark("rest")
        picture.show(started)
        swapped = session.clock.now()
        takers.frame(picture.output_frame(), started)
        watch.end()
        awake.refresh(started)
        if session.lifeline is not None and window.fullscreen is not screen:
            screen = window.fullscreen
            session.lifeline.send_screen(screen, *(one.window.monitor.name for one in picture.screens))
        previous = started
        if session.finished(started):
            break
