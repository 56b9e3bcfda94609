"""Streams: recordings that nobody has cut into steps, cut at their measure lines alone (T037, T038, T120).

Every measure is a clip of one "step" named after the stream. What may follow what is decided by similarity alone; a
measure of the recording follows the one before it without a seam, since its lead-in is that measure.
"""

import math
from dataclasses import replace
from typing import Final

from live.library.cut_step import cut_step
from live.library.recording import RecordingEntry
from live.motion.clip import Clip
from live.motion.mirror import mirror_step
from live.motion.step_clip import StepClip

OF_A_STEP: Final = ("leading_foot", "begin_pose", "end_pose", "weight_transfer", "direction", "distance_m")
"""What is said of a step and means nothing for a stream."""


def cut_recording(entry: RecordingEntry, clip: Clip) -> list[StepClip]:
    """All clips of an entry: its step, or the measures of its stream; each followed by its mirror image if asked.

    RecordingError that names file, line and field.
    """
    own = cut_stream(entry, clip) if entry.recording.unstructured else [cut_step(entry, clip)]
    if not entry.recording.mirror:
        return own
    return [both for step in own for both in (step, mirror_step(step))]


def cut_stream(entry: RecordingEntry, clip: Clip) -> list[StepClip]:
    """The measures of a stream, from `start_measure` on: as many as are asked for, else all whole ones."""
    recording = entry.recording
    for field in OF_A_STEP:
        if field in recording.model_fields_set:
            raise entry.error(field, "it is said of a step, and an unstructured recording is none: leave it out")
    count = recording.measures if "measures" in recording.model_fields_set else _whole(entry, clip)
    cut_step(_told(entry, recording.start_measure, count), clip)  # tells a stream that is too long in its own words
    return [replace(cut_step(_told(entry, recording.start_measure + n, 1), clip), in_stream=True) for n in range(count)]


def _whole(entry: RecordingEntry, clip: Clip) -> int:
    """How many whole measures there are from the first one on, at least 1, so that there is something to tell."""
    recording = entry.recording
    measure = recording.beats_per_measure * 60.0 / recording.bpm * clip.sample_rate
    start = recording.first_beat_s * clip.sample_rate + (recording.start_measure - 1) * measure
    return max(1, math.floor((clip.sample_count - 1 - start) / measure + 1e-9))


def _told(entry: RecordingEntry, start: int, measures: int) -> RecordingEntry:
    return replace(entry, recording=entry.recording.model_copy(update={"start_measure": start, "measures": measures}))
