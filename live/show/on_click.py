"""OnClick: the players' click runs with a show, and is switched by its events."""

import math

from live.control.click_output import ClickOutput
from live.control.events import ControlEvent, SetClick
from live.show.core import Show


class OnClick:
    """Between the show and its click. Thread: the one that runs the show."""

    def __init__(self, show: Show, output: ClickOutput) -> None:
        self._show = show
        self.output = output

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
