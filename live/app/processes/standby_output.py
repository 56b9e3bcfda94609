"""Output of a machine that follows another one, as a standby or as a render node: picture, sharing and status file."""

import contextlib
from collections import Counter
from collections.abc import Callable
from time import perf_counter
from typing import Any

from rich.console import Console

from live.app.film.live_recording import LiveSharing, live_fps
from live.app.headless_picture import HeadlessPicture
from live.app.launch_options import LaunchOptions
from live.app.processes.warm_standby import open_windows
from live.app.session_audio import AudioChoice
from live.app.session_records import resident_megabytes
from live.base.errors import PersonError
from live.show.loader import LoadedShow
from live.show.show import Show
from live.show.venue.venue import Venue
from live.show.view.status import Status, StatusFile


class StandbyOutput:
    """Draws, shares and reports the followed show. Thread: the main thread, which owns the OpenGL context."""

    def __init__(
        self,
        options: LaunchOptions,
        loaded: LoadedShow,
        venue: Venue | None,
        sound: AudioChoice,
        alive: Callable[[], dict[str, Any]],
    ) -> None:
        """Make everything that will be needed; raise PersonError if something fails.

        `alive`: figures for the status on how this machine follows.
        """
        self._options, self._alive = options, alive
        self.window: Any = open_windows(options, loaded, venue, hidden=False)
        self.headless: HeadlessPicture | None = None
        self.sharing: LiveSharing | None = None
        self._show: Show | None = None
        self._view: Any = None
        self._status: Status | None = None
        self._file: StatusFile | None = None
        self._status_written = self._has_drawn = False
        try:
            if self.window is None and self._options.share:
                self.headless = HeadlessPicture(self._options, loaded.scene(whole=False))
            if self._options.share:
                self._share(sound)
        except BaseException:
            self.close(Console(stderr=True))
            raise

    def _share(self, sound: AudioChoice) -> None:
        if self.window is not None:
            ctx, size = self.window.window.ctx, self.window.size
            self.window.prepare_output_frame()
        else:
            assert self.headless is not None
            ctx, size = self.headless.ctx, self._options.size
        self.sharing = LiveSharing(self._options.share, ctx, size, live_fps(self._options, ctx), sound.music)

    @property
    def is_drawing(self) -> bool:
        """Whether the picture is drawn, or none is wanted."""
        return self._has_drawn or (self.window is None and self.headless is None)

    def frame(self, show: Show, tick: int, time: float) -> None:
        """Draw, share and report the followed show after `tick` as it is at `time` [s]."""
        if show is not self._show:
            self._start_show(show)
        if self.window is not None or self.headless is not None:
            show.fill(self._view, time)
            self._draw(time)
            self._has_drawn = True
        if self._status is not None and self._file is not None:
            self._status.frames += 1
            self._status.ticks = tick
            self._file.frame(time)

    def dark(self) -> None:
        """Show black: there is no show, or it has ended."""
        if self._show is None:
            return
        if self._view is not None and (self.window is not None or self.headless is not None):
            self._view.brightness = 0.0
            self._draw(perf_counter())
        self._end_status()
        self._show = None

    def _draw(self, time: float) -> None:
        if self.window is not None:
            self.window.draw(self._view)
            self.window.show(time)
            if self.sharing is not None:
                self.sharing.frame(self.window.output_frame(), time)
        elif self.headless is not None:
            framebuffer = self.headless.draw(self._view, lambda: time)
            if self.sharing is not None:
                self.sharing.frame(framebuffer, time)

    def _start_show(self, show: Show) -> None:
        """Start output for another show object: the leader has changed or restarted."""
        self._show, self._view = show, show.view()
        self._end_status()
        if self._options.status_json is None:
            return
        status = Status(show, rejected=Counter, memory=resident_megabytes())
        status.extra_figures["alive"] = self._alive
        if self.sharing is not None:
            status.extra_figures["shared"] = self.sharing.facts
        with contextlib.suppress(OSError):  # the folder has been removed since; the show does not need it
            self._status, self._file = (
                status,
                StatusFile(self._options.status_json, status, append=self._status_written),
            )
            self._status_written = True

    def _end_status(self) -> None:
        if self._file is not None:
            self._file.close(0.0)
        self._file = self._status = None

    def release_status(self) -> None:
        """Close the status file: from now on the session writes it."""
        self._end_status()

    def close(self, console: Console) -> None:
        """Release all resources."""
        self._end_status()
        if self.sharing is not None:
            self.sharing.close(console)
            self.sharing = None
        if self.headless is not None:
            self.headless.close()
            self.headless = None
        if self.window is not None:
            self.window.close()


def check_status_writable(options: LaunchOptions) -> None:
    """Raise PersonError if the status file cannot be written."""
    path = options.status_json
    if path is None:
        return
    try:
        path.touch()
    except OSError as error:
        raise PersonError(f"cannot write --status-json {path}: {error.strerror}") from None
