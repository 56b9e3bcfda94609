"""What is doubtful about a step that was cut: what is said of it against what is measured, and what is missing."""

import math

from live.library.recording import RecordingEntry
from live.motion.editing.orientation import circular_mean, heading_of
from live.motion.step_clip import StepClip
from live.motion.step_figures import measured_direction, measured_distance, travel

DISTANCE_SHARE = 0.25
DISTANCE_LEAST = 0.1
"""A distance that is off by less than this share of it, or by less than so many metres, is believed."""
AXIS_OFF = math.radians(60.0)
"""A way that is farther than this from the direction that was written is another direction."""
LEAD_IN_BEATS = 0.75
"""A transition takes so many beats before a step."""
STANDS_LEAST = 0.1
"""Dancers have a foot on the floor for more than this share of a step."""
AWAY = math.radians(120.0)
"""A step whose average heading is farther than this from that at its first beat is danced with the back (T122)."""
_BEARING = {"forward": 0.0, "left": math.pi / 2, "back": math.pi, "right": -math.pi / 2}


def doubts_about(entry: RecordingEntry, step: StepClip) -> list[tuple[str, str]]:
    """Field and words for each doubt about one step of a recording."""
    doubts = []
    recording, measured = entry.recording, measured_distance(step)
    if recording.direction is not None and not _goes(step, recording.direction):
        doubts.append(
            ("direction", f"{recording.direction!r}, but she goes {measured_direction(step)}, {measured:.2f} m")
        )
    if recording.distance_m is not None:
        off = abs(recording.distance_m - measured)
        if off > max(DISTANCE_LEAST, DISTANCE_SHARE * recording.distance_m):
            doubts.append(("distance_m", f"{recording.distance_m:g}, but {measured:.2f} m are measured"))
    if recording.weight_transfer and recording.leading_foot is None:
        words = 'true, but leading_foot is not given, so no other side is known; write leading_foot = "left" or "right"'
        doubts.append(("weight_transfer", words))
    first, last = int(step.first), math.ceil(step.first + step.measures * step.samples_per_measure)
    stands = step.clip.contact[first : last + 1].any(axis=1).mean()
    if stands < STANDS_LEAST:
        often = (
            "no foot touches the floor in this step"
            if stands == 0
            else (f"a foot is on the floor in {100 * stands:.0f} % of this step only")
        )
        doubts.append(("file", f"{often}; check the floor, unit_m and up"))
    away = abs(circular_mean(heading_of(step.clip.rotation[first : last + 1, 0])))
    if away > AWAY:
        words = (
            f"she faces the public at the first beat, and on average {math.degrees(away):.0f} degrees away from it: "
            'she shows her back; begin the step a measure later, or write face = "average" under [motion] in the patch'
        )
        doubts.append(("start_measure", words))
    beat = 60.0 / recording.bpm
    begins = recording.first_beat_s + (recording.start_measure - 1) * recording.beats_per_measure * beat
    if begins < LEAD_IN_BEATS * beat:
        words = f"the recording begins {begins:.2f} s before the step: its first pose is held for the lead-in (T039)"
        doubts.append(("first_beat_s", words))
    return doubts


def _goes(step: StepClip, direction: str) -> bool:
    """Whether the way is roughly in the direction written; how far is another question."""
    word = direction.split()[-1]
    if word not in _BEARING:
        return measured_direction(step) == "in place"
    x, z = travel(step)
    if measured_direction(step) == "in place":
        return False
    off = math.remainder(math.atan2(x, z) - _BEARING[word], 2 * math.pi)
    return abs(off) <= AXIS_OFF
