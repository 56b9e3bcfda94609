"""What pages and controllers are told about pads: the lists, what waits and runs, and which steps cannot follow."""

import math
from typing import Any, Final

import numpy as np

from live.graph.structure_rules import UNREACHABLE
from live.show.desk.launcher import Launched
from live.show.desk.pad import KINDS, Pad
from live.show.show import Show

NEVER: Final = -1
"""Measures until a step that no way leads to."""


def columns(show: Show) -> list[str]:
    """Return the dancers of each column of a grid: everybody, and the groups."""
    return ["*", *(group.name for group in show.patch.group)]


def pad_facts(show: Show) -> dict[str, list[dict[str, Any]]]:
    """Return the pads of each page, in order, as values for JSON."""
    return {kind: [_facts_of(pad) for pad in show.launcher.pads.page(kind)] for kind in KINDS}


def _facts_of(pad: Pad) -> dict[str, Any]:
    facts: dict[str, Any] = {"pad": pad.text, "kind": pad.kind, "name": pad.own or pad.name, "words": pad.words}
    return facts | ({"does": pad.name, "measures": pad.measures, "follow": pad.follow} if pad.own else {})


def launch_facts(show: Show) -> dict[str, Any]:
    """Return what waits, runs and was refused, and which steps cannot follow what is danced now, for JSON.

    Beats are danced beats from 0: (measure + phase) times the beats of a measure.
    """
    launcher, danced = show.launcher, show.danced_beats
    rows = [_launch_row(one, "waits") for one in launcher.waiting.values()]
    for one in launcher.running.values():
        if one.ends > danced:
            rows.append(_launch_row(one, "runs" if one.due <= danced and _is_danced(show, one) else "waits"))
    refused = [{"pad": pad, "who": who, "state": "refused", "why": why} for pad, who, why in launcher.refused.values()]
    return {"beats": show.desk.beats, "launches": [*rows, *refused], "away": steps_away(show)}


def _launch_row(one: Launched, state: str) -> dict[str, Any]:
    return {
        "pad": one.pad.text, "who": one.group, "state": state, "due": _number(one.due), "until": _number(one.ends),
        "when": one.when, "follow": one.follow,
    }  # fmt: skip


def _number(beat: float) -> float | None:
    return round(beat, 3) if math.isfinite(beat) else None


def _is_danced(show: Show, one: Launched) -> bool:
    """Whether a step is danced by one of its dancers; True for everything else."""
    if one.pad.kind != "step":
        return True
    who = show.casting.select(one.group, show.state.position)
    danced = show.graph.library.node_step[show.dancers.node[who]]
    return bool((danced == show.graph.library.step_index(one.pad.name)).any())


def steps_away(show: Show) -> dict[str, dict[str, int]]:
    """Return for each column the steps that cannot follow at once: how many measures later, `NEVER` if not at all."""
    steps = show.graph.library.steps
    found = {}
    for who in columns(show):
        away = show.launcher.measures_away(who)
        late = np.flatnonzero(away > 0).tolist()
        found[who] = {steps[index]: NEVER if away[index] >= UNREACHABLE else int(away[index]) for index in late}
    return found
