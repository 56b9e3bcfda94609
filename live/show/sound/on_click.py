"""OnClick: the players' click runs with a show, and is switched by its events."""

import math
from typing import Any

from live.control.audio.click_output import ClickOutput
from live.control.audio.sound_devices import device_refuses
from live.control.events.events import ControlEvent, SetClick
from live.show.core import Show


class OnClick:
    """Between the show and its click. Thread: the one that runs the show."""

    def __init__(self, show: Show, output: ClickOutput) -> None:
        self._show = show
        self.output = output

    def start(self) -> None:
        """Open the output; PersonError if it refuses."""
        try:
            self.output.start()
        except Exception as error:  # PortAudioError, whose class is known only where PortAudio is
            raise device_refuses(error, "--click", self.output.device.name) from None

    def stop(self) -> None:
        """Close it."""
        self.output.stop()

    def status(self) -> dict[str, Any]:
        """For the status line."""
        return self.output.facts()

    def frame(self) -> None:
        """After each frame: how the show runs, and what is counted down to."""
        show = self._show
        left = show.follower.counting_in
        one = math.floor(show.timeline.beat_at(show.time) + left) if left else -math.inf
        self.output.show(show.timeline, one)

    def heard(self, event: ControlEvent) -> None:
        """An event of the show."""
        if isinstance(event, SetClick):
            self.output.track.on = event.on
