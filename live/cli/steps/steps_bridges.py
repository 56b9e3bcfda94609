"""`live steps graph --bridges`: where in the recordings the ways between unjoined steps are (T141)."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from live.base.errors import PersonError
from live.cli.steps.steps_library import folders
from live.graph.build.bridge import Recorded, find_bridges
from live.graph.motion_graph import MotionGraph
from live.library.recording_file import read_step_files
from live.library.recording_reader import RecordingReader
from live.motion.clip import Clip

MOST_PAIRS = 24
"""Pairs of steps for which bridges are searched, the nearest first: half a second each for half an hour of motion."""


def read_recordings_of(library: Path | None) -> list[Clip]:
    """Every recording of the library's folders, whole and once; PersonError if there is none."""
    found: dict[int, Clip] = {}
    for folder in folders(library):
        reader = RecordingReader()
        for entries in read_step_files(folder).recordings.values():
            for entry in entries:
                clip = reader.clip(entry)
                found.setdefault(id(clip), clip)
    if not found:
        raise PersonError("--bridges: there are no recordings to search", "sketched steps have nothing around them")
    return list(found.values())


def find_missing_bridges(
    graph: MotionGraph, missing: Sequence[dict[str, Any]], recordings: Sequence[Clip]
) -> list[dict[str, Any]]:
    """For the nearest pairs of steps that are not joined the best stretch of a recording, one row each."""
    recorded, library = [Recorded.of(clip) for clip in recordings], graph.library
    rows = []
    for row in missing[:MOST_PAIRS]:
        source, target = library.steps.index(row["from"]), library.steps.index(row["to"])
        bpm = next(clip.bpm for clip in library.clips if clip.step == row["from"])
        measure_s = 60.0 / bpm * library.beats_per_measure
        for bridge in find_bridges(graph, recorded, source, target, measure_s=measure_s, most=1):
            rows.append(
                {
                    "from": row["from"],
                    "to": row["to"],
                    "recording": recordings[bridge.recording].name,
                    "start_s": round(bridge.start, 3),
                    "stop_s": round(bridge.stop, 3),
                    "begin_m": round(bridge.begin_cost, 4),
                    "end_m": round(bridge.end_cost, 4),
                    "joins": bridge.cost <= graph.rule.threshold,
                }
            )
    return rows
