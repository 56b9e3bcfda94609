"""Adapters that connect a show to the musicians' click track and to an Ableton Link session."""

import math
from typing import Any

from live.control.audio.click_output import ClickOutput
from live.control.audio.devices import device_error
from live.control.events.events import ControlEvent, One, SetClick
from live.control.link.link_session import LinkSession
from live.show.show import Show


class ClickConnection:
    """Connection of a show to its click output. Thread: the show's."""

    def __init__(self, show: Show, output: ClickOutput) -> None:
        self._show = show
        self.output = output

    def start(self) -> None:
        """Open the output; PersonError if it refuses."""
        try:
            self.output.start()
        except Exception as error:  # PortAudioError, whose class exists only where PortAudio is installed
            raise device_error(error, "--click", self.output.device.name) from None

    def stop(self) -> None:
        """Close the output."""
        self.output.stop()

    def status(self) -> dict[str, Any]:
        """Return figures for the status line."""
        return self.output.status()

    def frame(self) -> None:
        """Pass the Timeline and the end of a count-in to the output, after each frame."""
        show = self._show
        left = show.follower.counting_in
        one = math.floor(show.timeline.beat_at(show.time) + left) if left else -math.inf
        self.output.set_timeline(show.timeline, one)

    def handle(self, event: ControlEvent) -> None:
        """Handle an event of the show."""
        if isinstance(event, SetClick):
            self.output.track.on = event.on


class LinkConnection:
    """Connection of a show to its Link session. Thread: the show's."""

    def __init__(self, show: Show, session: LinkSession) -> None:
        self._show = show
        self._session = session
        self._manual_count = show.follower.manual_tempo[0]

    def start(self) -> None:
        """Join the session."""
        self._session.start()

    def stop(self) -> None:
        """Leave the session."""
        self._session.stop()

    def frame(self) -> None:
        """Pass Timeline and tempo to the session after each frame, and a manual tempo while the session is the
        source."""
        follower = self._show.follower
        self._session.set_timeline(self._show.timeline, follower.tempo)
        count, tempo = follower.manual_tempo
        if count != self._manual_count:
            self._manual_count = count
            if follower.source == "link":
                self._session.set_tempo(tempo)

    def handle(self, event: ControlEvent) -> None:
        """Handle an event of the show: in lead mode a "this is the one" resynchronizes all peers."""
        if isinstance(event, One) and self._session.mode == "lead":
            self._session.resync()

    def status(self) -> dict[str, Any]:
        """Return figures for the status line."""
        reading = self._session.reading
        return {
            "mode": self._session.mode,
            "peers": self._session.peers,
            "bpm": None if reading is None else round(reading.tempo * reading.fold, 2),
            "faults": self._session.faults,
            "fault": self._session.fault,
        }
