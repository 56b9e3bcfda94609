"""Run of a score's agents without dancers: where segments and elements lead, some ten times faster than the show.

Agents do not wait for their dancers here, and calls of the score are left out.
"""

from collections.abc import Collection

import numpy as np

from live.base.arrays import Float32
from live.clock.ticks import TICK
from live.show.score.section_span import score_length
from live.show.show import Show
from live.show.stages.measure_span import MeasureSpan


def agent_places(show: Show, measures: Collection[int]) -> dict[int, Float32]:
    """Return the places of the agents at the lines of these measures (from 0) of the written score, each (A, 2) [m].

    `show` is fresh, and cannot be used again. Every section is danced once, one after the other.
    """
    motion, timeline, playhead = show.motion, show.timeline, show.playhead
    length, beats = score_length(show.patch), timeline.beats_per_measure
    if show.patch.section and length is not None:
        playhead.loop((0, length - 1))
    heading = np.zeros(len(motion.state.position))
    found, tick = dict[int, Float32](), 0
    for measure in range(max(measures, default=-1) + 1):
        if measure in measures:
            found[measure] = motion.state.position.copy()
        begin = float(measure * beats)
        span = MeasureSpan(measure, begin, begin + beats, beats)
        playhead.begin_measure(measure)
        show.scheduler.set_speed(measure, timeline)
        motion.begin_measure(span, begin, timeline, heading)
        while timeline.beat_at((tick + 1) * TICK) < span.end:
            tick += 1
            motion.command(tick * TICK, timeline, span, speed=show.scheduler.speed)
            motion.advance(tick * TICK, reference=motion.state.position, reference_velocity=motion.state.velocity)
    return found
