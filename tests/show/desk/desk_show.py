"""A show with sections, views, looks, scenes and cues, and a session that sends control calls to it."""

from live.clock.ticks import TICK
from live.control.registry.registry import REGISTRY
from tests.show.made_show import made_show

DESK = """
[[section]]
name = "verse"
measures = 4
wait = true
[[section]]
name = "solo"
measures = 3
then = "verse"
[[view]]
name = "side"
eye = [11.5, 3.4, 0.0]
target = [0.0, 0.9, 0.0]
[[looks]]
name = "dusk"
key_light = [1.0, 0.4, 0.2]
measures = 1
[[scene]]
name = "low"
measures = 1
[scene.set]
"/dance/light/level" = 0.25
"/dance/motion/larger front" = 0.4
"/dance/camera" = "side"
"/dance/look" = "dusk"
[[cue]]
name = "dim"
number = 1
count_in = 4
scene = "low"
text = "lights down"
[[cue]]
name = "solo"
number = 2.5
section = "solo"
calls = [["/dance/spread", 2]]
then = "auto"
after = 2
[[cue]]
name = "up"
when = "beat"
scene = "start"
measures = 1
[[cue]]
name = "top"
when = "section"
scene = "low"
measures = 0
"""


class DeskSession:
    """A show that receives control calls and is run in beats (32 ticks each at 120 bpm)."""

    def __init__(self, extra=DESK, **options):
        self.show = made_show(extra, **options)
        self.ticks = 0

    @property
    def desk(self):
        return self.show.desk

    def say(self, address, *values, source="key"):
        """Send a control call; returns whether the show accepted it."""
        return self.show.apply(REGISTRY.call(address, values, self.ticks * TICK, source))

    def run(self, beats=0.0, ticks=0):
        for _ in range(round(beats * 32) + ticks):
            self.ticks += 1
            self.show.tick(self.ticks * TICK)
        return self

    def value(self, address, group="*"):
        """The first number of a parameter."""
        return float(self.desk.parameters.value[self.desk.parameters.table.find(address, group)[0].first])

    @property
    def cues(self):
        return self.desk.facts(self.show.danced_beats)["cues"]

    @property
    def words(self):
        return self.show.refusals.last_reason
