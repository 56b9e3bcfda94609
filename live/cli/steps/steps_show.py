"""`live steps show`: one step in full: what is said of it, what is measured, and what can follow it."""

import json
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.text import Text

from live.cli.steps.steps_library import find_step, named_steps, threshold_for
from live.cli.steps.steps_list import row_of
from live.graph.followers import followers
from live.graph.step_library import build_library
from live.motion.step_clip import StepClip
from live.motion.step_figures import beat_contacts, foot_slide, travel

CONTACT = " ▁▂▃▄▅▆▇█"
"""Share of a beat in contact, from none to all of it."""


def print_step(name: str, library: Path | None, as_json: bool) -> None:
    """Print all about the step called `name`; PersonError if there is none."""
    steps = named_steps(library)
    step = find_step(steps, name)
    beats = step.clips[0].beats_per_measure
    clips = [clip for one in steps for clip in one.clips if clip.beats_per_measure == beats]
    graph_library = build_library(clips)
    index = graph_library.steps.index(step.name)
    threshold = threshold_for(steps)
    row = row_of(step) | {
        "clips": [clip_row(number, clip) for number, clip in enumerate(step.clips, start=1)],
        "followers": [
            {"step": f.step, "distance_m": round(f.distance_m, 4), "pairs": f.pairs}
            for f in followers(graph_library, index, threshold=threshold)
        ],
        "threshold_m": threshold,
    }
    if as_json:
        print(json.dumps(row, ensure_ascii=False, indent=1))
    else:
        _print(row)


def clip_row(number: int, clip: StepClip) -> dict[str, Any]:
    """One variation as JSON; contacts are shares of each beat, left and right foot."""
    slide = foot_slide(clip)
    return {
        "variation": number,
        "clip": clip.clip.name,
        "seconds": round(clip.measures * clip.samples_per_measure / clip.clip.sample_rate, 3),
        "measures": clip.measures,
        "bpm": clip.bpm,
        "direction": clip.direction,
        "distance_m": round(clip.distance_m, 3),
        "mirrored": clip.mirrored,
        "leading_foot": clip.leading_foot or None,
        "begin_pose": clip.begin_pose or None,
        "end_pose": clip.end_pose or None,
        "travel_m": [round(float(value), 3) for value in travel(clip)],
        "contacts": [[round(float(share), 2) for share in beat] for beat in beat_contacts(clip)],
        "foot_slide": None if slide is None else round(slide, 4),
    }


def _print(row: dict[str, Any]) -> None:
    console = Console(highlight=False)

    def say(text: str = "", style: str = "") -> None:
        console.print(text, style=style, soft_wrap=True, markup=False)

    say(row["name"], "bold")
    for label, value in _told(row):
        say(f"  {label:<16} {value}")
    say()
    for clip in row["clips"]:
        x, z = clip["travel_m"]
        mirrored = ", mirrored" if clip["mirrored"] else ""
        slide = "no contact" if clip["foot_slide"] is None else f"feet slide {100 * clip['foot_slide']:.1f} cm/s"
        say(
            f"  {clip['variation']:>3}  {clip['direction']}{mirrored}: {clip['distance_m']:.2f} m "
            f"(x {x:+.2f}, z {z:+.2f}), {clip['seconds']:.2f} s at {clip['bpm']:g} bpm, {slide}"
        )
        say(f"       {clip['clip']}", "dim")
        for foot, side in enumerate(("left", "right")):
            marks = "".join(CONTACT[round(beat[foot] * (len(CONTACT) - 1))] * 2 + " " for beat in clip["contacts"])
            console.print(Text(f"       {side:<5} foot on the floor  |{marks[:-1]}|", style="dim"), soft_wrap=True)
    say()
    if row["followers"]:
        say(f"  can be followed by (within {row['threshold_m']:g} m):")
        for follower in row["followers"]:
            say(f"    {follower['step']:<24} {100 * follower['distance_m']:5.1f} cm, {follower['pairs']} joins")
    else:
        say(f"  nothing can follow it within {row['threshold_m']:g} m: record a step that begins as it ends", "yellow")


def _told(row: dict[str, Any]) -> list[tuple[str, str]]:
    beats = ", ".join(f"{count}" for count in row["beats"])
    told = [("length", f"{beats} beats, {row['beats_per_measure']} to a measure"), ("folder", row["folder"])]
    for key in ("leading_foot", "begin_pose", "end_pose", "author", "style", "tags"):
        if row[key]:
            told.append((key.replace("_", " "), ", ".join(row[key])))
    if row["weight_transfer"]:
        told.append(("weight transfer", "repeats alternate the sides"))
    return told
