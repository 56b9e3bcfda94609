"""Answers about formations: their places for any number of dancers, and the ways into one, each way to choose."""

import math
from collections.abc import Sequence
from typing import Annotated, Any, Final, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from live.agents.evolutions.dry_run import SAMPLES_PER_MEASURE, DryRunResult
from live.agents.formations.formation import Formation, formation_of
from live.agents.formations.stage_fit import fit_stage
from live.base.arrays import Float64
from live.base.errors import PersonError
from live.document.preview import PreviewEngine, plan_faults
from live.rehearse.open_ends import next_segment

MAX_PLACES: Final = 64
"""Formations whose places are asked for at once."""
MAX_DANCERS: Final = 400
MAX_OPTIONS: Final = 16
MOST_NEXT: Final = 4
"""Formations that are suggested after an element."""
WAY_STEP: Final = SAMPLES_PER_MEASURE // 8
"""Ways are told 8 times in each measure."""
MAX_PREVIEW_POINTS: Final = 256
"""Points of each drawn line that are told; longer ones are thinned."""


class PlacesWish(BaseModel):
    """One formation whose places are asked for."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)
    formation: Annotated[str, Field(max_length=250)] | dict[str, Any]
    """A name or words as in a segment, or the table of a formation."""
    dancers: Annotated[int, Field(ge=1, le=MAX_DANCERS)]


class WayOption(BaseModel):
    """How the dancers of a segment get to its places: keys of `[[segment]]`; those left out stay as they are."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)
    match: Literal["squared", "shortest", "equal", "both", "bottleneck", "number"] | None = None
    way: Literal["mended", "straight", "divided"] | None = None
    facing: Literal["linear", "tangent", "measures", "declared"] | None = None
    headings_deg: Annotated[list[Annotated[float, Field(ge=-36000, le=36000)]], Field(max_length=1000)] | None = None


def places_values(engine: PreviewEngine, wishes: Sequence[PlacesWish]) -> dict[str, Any]:
    """Return the places of each formation, or why there are none, in the order of the wishes."""
    rows: list[dict[str, Any]] = []
    for wish in wishes:
        try:
            rows.append(_place_values(engine, wish))
        except PersonError as error:
            rows.append({"refused": [{"what": error.message, "remedy": error.remedy or ""}]})
    return {"kind": "places", "places": rows}


def _place_values(engine: PreviewEngine, wish: PlacesWish) -> dict[str, Any]:
    if isinstance(wish.formation, str):
        found = engine.formation(wish.formation, wish.dancers)
    else:
        found = formation_of(engine.spec(wish.formation), wish.dancers, engine.seed)
    stage = engine.patch.stage
    fit = fit_stage(found, stage.width, stage.depth)
    return {
        "slots": np.round(found.slots, 3).tolist(),
        "heading": np.round(found.heading, 3).tolist(),
        "soloists": int(found.soloist.sum()),
        "section": found.section.tolist(),
        "lines": [np.round(_thinned(line), 3).tolist() for line in found.lines],
        "least_m": None if not np.isfinite(found.min_distance) else round(found.min_distance, 3),
        "fits": fit.fits,
        "outside": [place + 1 for place in fit.outside],
        "scale": round(fit.scale, 4),
        "move": [round(each, 3) for each in fit.offset],
        "remedy": fit.remedy,
        "warnings": _warnings(found),
        "waiting": found.unplaced_dancers,
        "empty": found.empty_places,
    }


def _warnings(found: Formation) -> list[str]:
    return [words[:300] for words in found.warnings]


def _thinned(line: Float64) -> Float64:
    if len(line) <= MAX_PREVIEW_POINTS:
        return line
    return np.asarray(line[np.linspace(0, len(line) - 1, MAX_PREVIEW_POINTS).astype(np.int64)])


def option_values(engine: PreviewEngine, segment: int, options: Sequence[WayOption]) -> dict[str, Any]:
    """Return the ways of the dancers of a segment (from 1) into its formation, for each option: places, sums, and who
    would meet or cannot get there. PersonError if it is not danced, or leads into no formation."""
    first, last = engine.measures_of(segment - 1)
    section = engine.patch.segment[segment - 1]
    if section.formation is None:
        raise PersonError(f"segment {segment} leads into no formation", "its matching is that of a formation's places")
    before = engine.at(first - 1.0)
    who = np.flatnonzero(engine.select(section.group, before.place) & (before.present != 0))
    rows: list[dict[str, Any]] = []
    for option in options:
        said = {key: value for key, value in option.model_dump().items() if value is not None}
        changes = said | {"headings_deg": tuple(said.get("headings_deg", section.headings_deg))}
        if changes.get("facing", section.facing) != "declared":
            changes["headings_deg"] = ()
        elif not changes["headings_deg"]:
            rows.append({"option": said, "refused": [{"what": "a heading for each measure is missing", "remedy": ""}]})
            continue
        segments = list(engine.patch.segment)
        segments[segment - 1] = section.model_copy(update=changes)
        plan = engine.plan(first, last, engine.patch.model_copy(update={"segment": tuple(segments)}))
        rows.append({"option": said} | _option_values(engine, plan, first, who))
    head = {"segment": segment, "from": first, "to": last, "formation": section.formation, "group": section.group}
    return {"kind": "options", **head, "dancers": (who + 1).tolist(), "options": rows}


def _option_values(engine: PreviewEngine, plan: DryRunResult, first: int, who: Any) -> dict[str, Any]:
    ways = np.concatenate([plan.ways[::WAY_STEP], plan.places[-1:]])[:, who].astype(np.float64)
    length = np.hypot(*np.diff(ways, axis=0).transpose(2, 0, 1)).sum(axis=0) if len(who) else np.zeros(0)
    numbers = set((who + 1).tolist())
    faults = plan_faults(engine, plan, first)
    return {
        "total_m": round(float(length.sum()), 2),
        "longest_m": round(float(length.max(initial=0.0)), 2),
        "shortest_m": round(float(length.min(initial=np.inf)), 2) if len(length) else 0.0,
        "meetings": [one for one in faults["meetings"] if numbers.intersection(one["dancers"])],
        "too_far": [one for one in faults["too_far"] if one["dancer"] in numbers],
        "ways": np.round(ways.transpose(1, 0, 2), 3).tolist(),
        "headings": np.round(plan.headings[:, who].T, 3).tolist(),
    }


def next_values(engine: PreviewEngine, element: int) -> dict[str, Any]:
    """Return what could follow an element (from 1): formations, each with the segment that leads into it. PersonError
    if it is not danced."""
    after, end, ranked = engine.next_formations(element - 1)
    rows = [
        {
            "formation": one.formation, "measures": one.measures, "total_m": one.total_m, "longest_m": one.longest_m,
            "meetings": one.meetings, "segment": {} if end is None else next_segment(engine.patch, end, one),
        }
        for one in ranked[:MOST_NEXT]
    ]  # fmt: skip
    quiet = None if end is None or math.isinf(end.quiet) else end.quiet
    return {"kind": "next", "element": element, "after": after, "quiet": quiet, "formations": rows}
