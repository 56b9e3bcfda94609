"""Reader for scenarios in JSON: checks every number; every error names the field and the remedy."""

import json
import math
from typing import Any, Final

import numpy as np

from live.agents.scenarios.scenario import Scenario
from live.base.arrays import Float64
from live.base.errors import PersonError

MAX_METRES: Final = 1000.0
MAX_SECONDS: Final = 3600.0
MAX_AGENTS: Final = 20_000
MAX_WALLS: Final = 64
MAX_WAY_POINTS: Final = 1000
MAX_BYTES: Final = 1 << 26
NUMBERS: Final = {
    "duration": (1.0 / 64.0, MAX_SECONDS),
    "radius": (0.01, 5.0),
    "preferred_speed": (0.01, 20.0),
    "max_speed": (0.01, 20.0),
    "goal_radius": (0.001, 100.0),
}
"""Minimum and maximum of each number, in metres and seconds."""
KNOWN_FIELDS: Final = (*NUMBERS, "stage", "agents", "walls")


def read_scenario(text: str | bytes, source: str = "the scenario") -> Scenario:
    """Parse a scenario from `text` (JSON). Raises PersonError, naming `source` and field, if it is invalid."""
    if len(text) > MAX_BYTES:
        raise PersonError(f"{source}: {len(text):,} bytes", f"a scenario has at most {MAX_BYTES:,}")
    try:
        data = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise PersonError(f"{source}: not JSON: {error}", 'write an object like {"duration": 30, …}') from None
    if not isinstance(data, dict):
        raise PersonError(f"{source}: {_short_repr(data)} where an object is needed", 'write {"duration": 30, …}')
    return _Reader(source).scenario(data)


def unknown_fields(text: str | bytes) -> list[str]:
    """Return the unknown top-level names of a readable scenario."""
    return [str(name)[:40] for name in json.loads(text) if name not in KNOWN_FIELDS]


def _short_repr(value: object) -> str:
    """Return a short, recognizable form of a value for messages."""
    try:
        text = json.dumps(value)
    except (ValueError, RecursionError):
        text = repr(type(value))
    return text if len(text) <= 40 else text[:37] + "…"


class _Reader:
    """Parser of the parts; `source` begins every message."""

    def __init__(self, source: str) -> None:
        self._source = source

    def _error(self, field: str, what: str, remedy: str) -> PersonError:
        return PersonError(f"{self._source}: {field}: {what}", remedy)

    def scenario(self, data: dict[str, Any]) -> Scenario:
        missing = [name for name in (*NUMBERS, "agents") if name not in data]
        if missing:
            raise self._error(missing[0], "missing", f"a scenario needs {', '.join((*NUMBERS, 'agents'))}")
        numbers = {name: self._number(name, data[name], *NUMBERS[name]) for name in NUMBERS}
        if numbers["max_speed"] < numbers["preferred_speed"]:
            what = f"{numbers['max_speed']:g} is below preferred_speed, {numbers['preferred_speed']:g}"
            raise self._error("max_speed", what, "give at least the preferred speed")
        stage = self._stage(data.get("stage"))
        walls = self._walls(data.get("walls", []))
        starts, goals = [], []
        for index, agent in enumerate(self._list("agents", data["agents"], MAX_AGENTS)):
            field = f"agents[{index}]"
            if not isinstance(agent, dict):
                raise self._error(field, _short_repr(agent), 'write {"position": [x, z], "goal": [x, z]}')
            for key in ("position", "goal"):
                if key not in agent:
                    raise self._error(f"{field}.{key}", "missing", 'write {"position": [x, z], "goal": [x, z]}')
            starts.append(self._start(f"{field}.position", agent["position"], stage))
            goals.append(self._way_points(f"{field}.goal", agent["goal"]))
        return Scenario(
            numbers["duration"],
            numbers["radius"],
            numbers["preferred_speed"],
            numbers["max_speed"],
            numbers["goal_radius"],
            start=np.array(starts, float).reshape(-1, 2),
            goals=tuple(goals),
            stage=stage,
            walls=walls,
        )

    def _number(self, field: str, value: object, low: float, high: float) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self._error(
                field, f"{_short_repr(value)} where a number is needed", f"write one from {low:g} to {high:g}"
            )
        if (
            not (math.isfinite(value) and low <= value <= high)
            if isinstance(value, float)
            else not low <= value <= high
        ):
            raise self._error(field, _short_repr(value), f"write a number from {low:g} to {high:g}")
        return float(value)

    def _list(self, field: str, value: object, most: int) -> list[Any]:
        if not isinstance(value, list):
            raise self._error(field, f"{_short_repr(value)} where a list is needed", "write [ … ]")
        if len(value) > most:
            raise self._error(field, f"{len(value):,} entries", f"give at most {most:,}")
        return value

    def _tuple(self, field: str, value: object, form: str) -> list[float]:
        if not isinstance(value, list) or len(value) != form.count(",") + 1:
            raise self._error(field, _short_repr(value), f"write {form}, in metres")
        return [self._number(f"{field}[{i}]", each, -MAX_METRES, MAX_METRES) for i, each in enumerate(value)]

    def _stage(self, value: object) -> tuple[float, float, float, float] | None:
        if value is None:
            return None
        x0, z0, x1, z1 = self._tuple("stage", value, "[x0, z0, x1, z1]")
        if x1 <= x0 or z1 <= z0:
            raise self._error("stage", _short_repr(value), "write [x0, z0, x1, z1] with x0 < x1 and z0 < z1, or null")
        return x0, z0, x1, z1

    def _walls(self, value: object) -> Float64:
        entries = self._list("walls", value, MAX_WALLS)
        ends = [self._tuple(f"walls[{i}]", each, "[x1, z1, x2, z2]") for i, each in enumerate(entries)]
        return np.array(ends, float).reshape(-1, 4)

    def _start(self, field: str, value: object, stage: tuple[float, float, float, float] | None) -> list[float]:
        x, z = self._tuple(field, value, "[x, z]")
        if stage is not None and not (stage[0] <= x <= stage[2] and stage[1] <= z <= stage[3]):
            raise self._error(field, f"[{x:g}, {z:g}] is off the stage", f"start within {_short_repr(list(stage))}")
        return [x, z]

    def _way_points(self, field: str, value: object) -> Float64:
        if isinstance(value, list) and value and isinstance(value[0], list):
            points = self._list(field, value, MAX_WAY_POINTS)
            return np.array([self._tuple(f"{field}[{i}]", point, "[x, z]") for i, point in enumerate(points)])
        return np.array([self._tuple(field, value, "[x, z]")])
