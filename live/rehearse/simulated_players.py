"""Simulated players with phones and control surfaces: a seeded Poisson process of valid and invalid calls."""

from collections.abc import Iterator, Sequence
from typing import Final, NamedTuple

import numpy as np

from live.base.parameter import WORLD_NAMES
from live.control.registry.control import ROLE_RANKS, Argument, ArgumentValue, Control, Role
from live.control.registry.registry import QUERIES, REGISTRY
from live.show.desk.parameter_table import NAME_CHOICES
from live.show.patch.patch import Patch
from live.show.patch.section_score import formation_names

FORMATIONS: Final = ("circle", "line", "grid", "star:6", "block", "wedge", "arc", "two lines", "spiral", "heart")
PLACES: Final = ("left", "right", "front", "back", "centre", "all", "*", "1-4", "2 + 5", "front - 1", "left & back")
FACINGS: Final = ("public", "path", "centre", "attractor", "30", "-120", "dancer 3", "dancer 999")
INVALID_NAMES: Final = (
    "",
    " ",
    "nobody",
    "\x00",
    "Ω" * 40,
    "x" * 64,
    "1-",
    "& &",
    "9" * 60,
    "*",
    "-1",
    "nan",
    "left &",
)
HOSTILE_VALUES: Final = (
    float("nan"), float("inf"), -float("inf"), 1e300, -1e9, 0.0, -0.0, 2**63, True, None, b"\xff\xfe", "", "x" * 300,
)  # fmt: skip


class ArgumentGenerator:
    """Generator of argument values for one show's controls, from the names in its patch. Every call takes its random
    generator."""

    def __init__(self, patch: Patch, steps: Sequence[str]) -> None:
        groups = [group.name for group in patch.group]
        formations = formation_names(patch.formation)
        self._pools: dict[str, list[str]] = {
            "group": ["*", *groups, *groups],
            "who": ["*", *groups, *PLACES, *(f"{name} & left" for name in groups)],
            "formation": [*formations, *formations, *FORMATIONS],
            "step": list(steps),
            "section": [section.name for section in patch.section] or ["verse"],
            "cue": [cue.name for cue in patch.cue] or ["1"],
            "scene": ["start", *(scene.name for scene in patch.scene)],
            "view": ["start", *(view.name for view in patch.view)],
            "world": list(WORLD_NAMES),
            "look": ["start", *(look.name for look in patch.looks)],
            "signal": [*(signal.name for signal in patch.signal), "hit", "drop"],
            "gate": ["*", "left", "right", "back"],
            **{kind: list(names) for kind, names in NAME_CHOICES.items()},
            "thing": ["tree", "rope", "chair"],
        }

    def values(self, control: Control, chance: np.random.Generator) -> list[ArgumentValue]:
        """Return values that the control accepts (names may not exist); optional ones are sometimes left out."""
        values: list[ArgumentValue] = []
        for argument in control.arguments:
            if argument.default is not None and chance.random() < 0.3:
                break
            values.append(self._value(argument, chance))
        return values

    def _value(self, argument: Argument, chance: np.random.Generator) -> ArgumentValue:
        if argument.type == "bool":
            return bool(chance.random() < 0.5)
        if argument.type == "float":
            return _number(argument, chance)
        return self._text(argument, chance)

    def _text(self, argument: Argument, chance: np.random.Generator) -> str:
        name = argument.name
        if name in ("points", "begins"):
            return points(chance, 1 if name == "begins" else int(chance.integers(2, 7)))
        if name == "facing":
            return _pick(FACINGS, chance)
        if name == "steps":
            return ", ".join(_pick(self._pools["step"], chance) for _ in range(int(chance.integers(1, 5))))
        if name == "match":
            return _pick(("squared", "shortest", "equal", "both", "bottleneck", "number"), chance)
        if name == "when":
            return _pick(("measure", "section"), chance)
        if name == "whom":
            return _pick((str(int(chance.integers(1, 12))), self._pools["group"][-1]), chance)
        return _pick(self._pools[self._kind(argument)], chance)

    def _kind(self, argument: Argument) -> str:
        """Return the kind of words for an argument."""
        kind = argument.names or argument.name
        if kind == "group" and argument.type == "text":
            return "who"
        return kind if kind in self._pools else "thing"


def invalid_values(chance: np.random.Generator) -> list[object]:
    """Return invalid values of any type and number."""
    pool: tuple[object, ...] = (*HOSTILE_VALUES, *INVALID_NAMES)
    return [pool[int(chance.integers(len(pool)))] for _ in range(int(chance.integers(0, 9)))]


def points(chance: np.random.Generator, count: int) -> str:
    """Return `count` random points of a stage, as text."""
    return ", ".join(f"{x:.2f} {z:.2f}" for x, z in chance.uniform((-4.5, -2.8), (4.5, 2.8), (count, 2)))


def _pick(pool: Sequence[str], chance: np.random.Generator) -> str:
    return pool[int(chance.integers(len(pool)))]


def _number(argument: Argument, chance: np.random.Generator) -> float:
    """Return a number within the range; mostly in a sensible part, as ranges exceed the size of a stage."""
    low, high = argument.minimum, argument.maximum
    if chance.random() < 0.05:
        return float(chance.choice((low, high)))
    if argument.name == "measures":
        low, high = max(low, 0.25), min(high, 12.0)
    elif argument.name in ("x", "x2", "z", "z2", "y") and high > 4.0:
        low, high = max(low, -4.5), min(high, 4.5)
    elif argument.name in ("width", "depth"):
        low, high = 5.0, 14.0
    elif argument.name == "count":
        high = 3.0
    elif high - low > 1000.0:
        high = low + 60.0
    return float(chance.uniform(low, max(low, high)))


SALT: Final = 0xF0E5
DRAG_CONTROLS: Final = ("/dance/attract", "/dance/voice", "/dance/performer")
"""Controls that a phone sends repeatedly while a finger moves."""
FREQUENCIES: Final = {"/dance/go": 4.0, "/dance/section": 3.0, "/dance/signal": 3.0, "/dance/undo": 3.0}
"""Relative frequencies of controls; 1 for all others."""
RARE_CONTROLS: Final = ("/dance/ping", "/dance/panic", "/dance/blackout", "/dance/clear", "/dance/stage", "/dance/hold",
               "/dance/hold/score", "/dance/practice", "/dance/clock/source", "/dance/clock/metre", "/dance/clock/hold",
               "/dance/clock/half", "/dance/clock/double", "/dance/clock/count_in", "/dance/output/fade",
               "/dance/output/freeze", "/dance/output/flashes", "/dance/output/card",
               "/dance/picture/quality")  # fmt: skip


class Call(NamedTuple):
    """One message of a player."""

    time: float
    """Arrival time [s of the show]."""
    address: str
    values: list[object]
    source: str


class SimulatedPlayers:
    """`count` people, each of whom sends about `rate` messages a minute."""

    def __init__(
        self, seed: int, arguments: ArgumentGenerator, *, count: int = 8, rate: float = 6.0,
        invalid_share: float = 0.05, role: Role = "operator", start: float = 0.0,
    ) -> None:  # fmt: skip
        """`rate` [1/min] of each; `invalid_share`: share of invalid messages; `role`: highest role of controls used."""
        self._rng = np.random.default_rng([seed, SALT])
        self._arguments, self._invalid_share = arguments, invalid_share
        self._rate = count * rate / 60.0
        self._count, self._time = count, start
        allowed = (control for control in REGISTRY if ROLE_RANKS[control.role] <= ROLE_RANKS[role])
        self._controls = [control for control in allowed if control.address not in QUERIES]
        weights = np.array([_frequency(control) for control in self._controls])
        self._shares = weights / weights.sum()

    def calls(self) -> Iterator[Call]:
        """Yield messages in order of time, endlessly."""
        chance = self._rng
        while self._rate > 0.0:
            self._time += float(chance.exponential(1.0 / self._rate))
            source = f"phone {int(chance.integers(self._count)) + 1}"
            control = self._controls[int(chance.choice(len(self._controls), p=self._shares))]
            if chance.random() < self._invalid_share:
                yield Call(self._time, control.address, invalid_values(chance), source)
                continue
            values: list[object] = list(self._arguments.values(control, chance))
            yield Call(self._time, control.address, values, source)
            if control.address in DRAG_CONTROLS and len(values) >= 2:
                yield from self._finger_moves(control, values, source)

    def _finger_moves(self, control: Control, values: list[object], source: str) -> Iterator[Call]:
        """Yield the messages of the same finger moving for up to a second."""
        at = [index for index, argument in enumerate(control.arguments) if argument.name in ("x", "z")]
        time = self._time
        for _ in range(int(self._rng.integers(2, 20))):
            time += 0.05
            values = list(values)
            for index in at:
                values[index] = float(values[index]) + 0.1 * float(self._rng.standard_normal())  # type: ignore[arg-type]
            yield Call(time, control.address, values, source)
        self._time = time


def _frequency(control: Control) -> float:
    if control.address in RARE_CONTROLS:
        return 0.15
    return FREQUENCIES.get(control.address, 1.0)
