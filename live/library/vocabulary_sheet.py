"""Sheet of proposed steps for people: a page with the key poses of each step, without any other file."""

import html
import math
from typing import Final

import numpy as np

from live.base.arrays import Float64
from live.graph.vocabulary.step_names import StepFacts
from live.library.vocabulary import ProposedStep, Vocabulary
from live.motion.skeleton import SKELETON

POSES_PER_BEAT: Final = 4
MAX_POSES: Final = 17
"""Key poses of a step that are drawn: one for each beat, and the last."""
_SIZE: Final = (58, 104)
"""Width and height of a pose's picture [px]."""
_SCALE: Final = 50.0
"""Pixels per metre."""
_COLOURS: Final = {"left": "#c2410c", "right": "#1d4ed8"}
_TRUNK: Final = "#374151"
_STYLE: Final = (
    "body{font:15px/1.4 system-ui,sans-serif;margin:2em auto;max-width:1200px;padding:0 1em;color:#111;background:#fff}"
    "section{border-top:1px solid #ccc;padding:.8em 0;break-inside:avoid}h2{font-size:1.1em;margin:0}"
    "p{margin:.2em 0;color:#444}.poses{display:flex;flex-wrap:wrap;gap:2px}svg{background:#f6f6f4}"
    "code{background:#f0f0ee;padding:.1em .3em}"
)


def sheet_page(vocabulary: Vocabulary, command: str) -> str:
    """Return the HTML page: a row for each proposed step. `command`: what adds all steps, shown at the top."""
    names = ", ".join(take.name for take in vocabulary.takes)
    count, repeated = len(vocabulary.steps), sum(len(step.found.starts) > 1 for step in vocabulary.steps)
    rows = "".join(_row(vocabulary, number, step) for number, step in enumerate(vocabulary.steps, 1))
    return (
        f'<!doctype html><html lang="en"><meta charset="utf-8"><title>Steps of {html.escape(names)}</title>'
        f"<style>{_STYLE}</style><h1>Steps of {html.escape(names)}</h1>"
        f"<p>{len(vocabulary.measures)} measures, {count} steps, {repeated} of them danced more than once. "
        f"Poses are as the audience sees a dancer who begins facing it; the dancer's "
        f'<b style="color:{_COLOURS["left"]}">left</b> and <b style="color:{_COLOURS["right"]}">right</b>. '
        f"The last picture is the way from above.</p><p>Add them: <code>{html.escape(command)}</code></p>{rows}"
        "</html>\n"
    )


def _row(vocabulary: Vocabulary, number: int, step: ProposedStep) -> str:
    facts = step.facts
    every = POSES_PER_BEAT * max(1, math.ceil((len(facts.pose) - 1) / POSES_PER_BEAT / (MAX_POSES - 1)))
    pictures = "".join(_pose_picture(pose) for pose in facts.pose[::every])
    return (
        f'<section id="step-{number}"><h2>{number}. {html.escape(step.name)}</h2><p>{html.escape(facts_text(step))}</p>'
        f"<p>{html.escape(places_text(vocabulary, step))}</p>"
        f'<div class="poses">{pictures}{_way_picture(facts)}</div></section>'
    )


def facts_text(step: ProposedStep) -> str:
    """Return length, repeats, travel, turn and tempo of a step in a line."""
    facts, found = step.facts, step.found
    times = len(found.starts)
    words = [f"{found.measures} measure{'s' if found.measures > 1 else ''}"]
    words.append("once" if times == 1 else f"{times} times, {100.0 * found.spread_m:.0f} cm apart")
    words.append(f"travels {facts.distance_m:.2f} m, turns {math.degrees(facts.turn):+.0f}°")
    beats = (len(facts.pose) - 1) / POSES_PER_BEAT
    words.append(f"{60.0 * beats / facts.seconds:.1f} bpm")
    return "; ".join(words)


def places_text(vocabulary: Vocabulary, step: ProposedStep) -> str:
    """Return the measures of all occurrences, from 1, by recording."""
    found: dict[str, list[int]] = {}
    for start in sorted(step.found.starts):
        take, number = vocabulary.place(start)
        found.setdefault(take.name, []).append(number)
    longer = step.found.measures - 1
    parts = []
    for name, numbers in found.items():
        shown = ", ".join(f"{n}-{n + longer}" if longer else str(n) for n in numbers[:40])
        more = f" and {len(numbers) - 40} more" if len(numbers) > 40 else ""
        parts.append(f"measures {shown}{more}" + (f" of {name}" if len(vocabulary.takes) > 1 else ""))
    return "; ".join(parts)


def _pose_picture(pose: Float64) -> str:
    """Return a stick figure (J, 3) from the front, its hips in the middle."""
    width, height = _SIZE
    x = width / 2 + _SCALE * (pose[:, 0] - pose[0, 0])
    y = height - 6 - _SCALE * pose[:, 1]
    depth = [(pose[joint, 2] + pose[parent, 2], joint, parent) for joint, parent in _BONES]
    lines = "".join(
        f'<line x1="{x[parent]:.1f}" y1="{y[parent]:.1f}" x2="{x[joint]:.1f}" y2="{y[joint]:.1f}" '
        f'stroke="{_colour(joint)}"/>'
        for _, joint, parent in sorted(depth)
    )
    head = f'<circle cx="{x[_HEAD]:.1f}" cy="{y[_HEAD] - 4:.1f}" r="5" fill="{_TRUNK}"/>'
    return (
        f'<svg width="{width}" height="{height}"><g stroke-width="2.5" stroke-linecap="round">{lines}</g>{head}</svg>'
    )


def _way_picture(facts: StepFacts) -> str:
    """Return the way of the hips from above, the audience below, and the heading at the end."""
    height = _SIZE[1]
    hips = facts.pose[:, 0, ::2]
    middle, size = (hips.max(axis=0) + hips.min(axis=0)) / 2, max(1.0, float(np.ptp(hips, axis=0).max()))
    at = height / 2 + (hips - middle) * (height - 24) / size
    points = " ".join(f"{x:.1f},{y:.1f}" for x, y in at)
    tip = at[-1] + 10.0 * np.array((math.sin(facts.turn), math.cos(facts.turn)))
    return (
        f'<svg width="{height}" height="{height}"><polyline points="{points}" fill="none" stroke="{_TRUNK}" '
        f'stroke-width="2"/><circle cx="{at[0, 0]:.1f}" cy="{at[0, 1]:.1f}" r="3" fill="{_TRUNK}"/>'
        f'<line x1="{at[-1, 0]:.1f}" y1="{at[-1, 1]:.1f}" x2="{tip[0]:.1f}" y2="{tip[1]:.1f}" stroke="#15803d" '
        f'stroke-width="3"/></svg>'
    )


def _colour(joint: int) -> str:
    name = SKELETON.names[joint]
    return next((colour for side, colour in _COLOURS.items() if name.startswith(side)), _TRUNK)


_BONES: Final = [(joint, int(parent)) for joint, parent in enumerate(SKELETON.parents) if parent >= 0]
_HEAD: Final = SKELETON.index("head")
