"""The worlds: places of one look each, in which a show is danced.

A world is one row here: what its own drawing does not fix, as values of picture parameters. These are the defaults
wherever a patch says nothing. Its drawing is a function of its share (`/dance/world/NAME`): `live/render/worlds`.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from live.base.parameter import WORLD_NAMES
from live.base.picture_parameters import (
    BY_ADDRESS,
    GROUP_PARAMETERS,
    STYLE_ADDRESS_PREFIX,
    WORLD_PREFIX,
)

Value = float | tuple[float, float, float]
Values = Mapping[str, Value]


@dataclass(frozen=True, slots=True, eq=False)
class World:
    """One world and its defaults, by the address of the parameter."""

    name: str
    values: Values


_BLACK: Final = (0.0, 0.0, 0.0)
WORLDS: Final = (
    World("haze", {
        "/dance/light/key": 0.9, "/dance/light/key/direction": (-0.55, -1.0, -0.5),
        "/dance/light/rim": 1.25, "/dance/light/side": 0.25,
        "/dance/light/haze": 0.045, "/dance/light/beams": 0.9, "/dance/light/beams/colour": (0.42, 0.62, 1.0),
        "/dance/light/beams/width": 0.06, "/dance/light/beams/fan": 0.42, "/dance/light/beams/sway": 0.22,
        "/dance/light/back": 0.35, "/dance/light/back/colour": (0.62, 0.78, 1.0),
    }),
    World("studio", {
        "/dance/light/key": 0.62, "/dance/light/key/colour": (1.0, 0.985, 0.96),
        "/dance/light/key/direction": (-0.5, -1.15, -0.62),
        "/dance/light/rim": 0.3, "/dance/light/rim/colour": (1.0, 1.0, 1.0), "/dance/light/ambient": 0.0,
        "/dance/light/fill": 0.56, "/dance/light/fill/above": (1.0, 1.0, 1.0),
        "/dance/light/fill/below": (0.56, 0.55, 0.54),
        "/dance/light/haze": 0.0, "/dance/light/background": (0.97, 0.98, 0.99),
        "/dance/light/floor": (0.80, 0.80, 0.80), "/dance/light/pulse": 0.0,
        "/dance/pass/mirror": 0.18, "/dance/pass/shadow": 0.95, "/dance/pass/vignette": 0.25,
    }),
    World("paper", {
        "/dance/light/key": 1.15, "/dance/light/key/colour": (1.0, 1.0, 1.0),
        "/dance/light/key/direction": (-0.7, -1.0, -0.42),
        "/dance/light/rim": 0.0, "/dance/light/ambient": 0.0, "/dance/light/fill": 0.34,
        "/dance/light/fill/above": (1.0, 1.0, 1.0), "/dance/light/fill/below": (0.75, 0.72, 0.7),
        "/dance/light/haze": 0.0, "/dance/light/background": (0.88, 0.83, 0.73),
        "/dance/light/floor": (0.80, 0.74, 0.63),
        "/dance/light/pulse": 0.0, "/dance/pass/mirror": 0.0, "/dance/pass/shadow": 0.75, "/dance/pass/vignette": 0.3,
        "/dance/draw/sheen": 0.0,
    }),
    World("constellation", {
        "/dance/light/key": 0.25, "/dance/light/rim": 0.4, "/dance/light/rim/colour": (0.4, 0.55, 1.0),
        "/dance/light/haze": 0.0, "/dance/light/background": (0.004, 0.006, 0.016),
        "/dance/light/floor": (0.008, 0.010, 0.018),
        "/dance/light/beams": 0.0, "/dance/pass/shadow": 0.0, "/dance/pass/mirror": 0.5,
        "/dance/draw/solid": 0.0, "/dance/draw/particles": 0.6, "/dance/draw/particles/share": 0.22,
        "/dance/draw/particles/drift": 0.2,
    }),
    World("water", {
        "/dance/light/key": 0.95, "/dance/light/key/colour": (1.0, 0.84, 0.66),
        "/dance/light/key/direction": (-0.75, -0.8, -0.45),
        "/dance/light/rim": 1.5, "/dance/light/rim/colour": (0.36, 0.72, 0.9), "/dance/light/ambient": 0.14,
        "/dance/light/fill": 0.1, "/dance/light/fill/above": (0.2, 0.42, 0.55),
        "/dance/light/fill/below": (0.15, 0.5, 0.55),
        "/dance/light/haze": 0.012, "/dance/light/background": (0.006, 0.018, 0.028),
        "/dance/light/floor": (0.006, 0.016, 0.022),
        "/dance/pass/shadow": 0.3, "/dance/pass/mirror": 1.0,
    }),
    World("dusk", {
        "/dance/light/key": 1.25, "/dance/light/key/colour": (1.0, 0.60, 0.30),
        "/dance/light/key/direction": (-0.95, -0.40, 0.12),
        "/dance/light/rim": 1.5, "/dance/light/rim/colour": (1.0, 0.50, 0.20), "/dance/light/ambient": 0.0,
        "/dance/light/fill": 0.44, "/dance/light/fill/above": (0.42, 0.48, 0.82),
        "/dance/light/fill/below": (0.42, 0.30, 0.24),
        "/dance/light/haze": 0.010, "/dance/light/background": (0.30, 0.20, 0.22),
        "/dance/light/floor": (0.060, 0.062, 0.040),
        "/dance/background/top": (0.030, 0.060, 0.17), "/dance/background/bottom": (1.0, 0.42, 0.13),
        "/dance/light/pulse": 0.0, "/dance/pass/mirror": 0.0, "/dance/pass/shadow": 0.8, "/dance/pass/vignette": 0.6,
    }),
)  # fmt: skip
"""All worlds, in the order of `WORLD_NAMES`. A parameter that one of them sets has its start value in the others."""
BY_NAME: Final = {world.name: world for world in WORLDS}
FADE_MEASURES: Final = 2.0
"""Length of the cross-fade to a world [measures], unless the call gives one."""
WORLD_PARAMETERS: Final = tuple(
    dict.fromkeys((*(WORLD_PREFIX + name for name in WORLD_NAMES), *(key for world in WORLDS for key in world.values)))
)
"""Addresses of all parameters that worlds set: their shares first."""


def is_drawing_style(address: str) -> bool:
    """Whether a parameter belongs to a group's drawing style."""
    return address.startswith(STYLE_ADDRESS_PREFIX)


def world_values(name: str) -> dict[str, Value]:
    """Return the values of all `WORLD_PARAMETERS` in a world, by address; KeyError for an unknown name."""
    own = BY_NAME[name].values
    values: dict[str, Value] = {}
    for address in WORLD_PARAMETERS:
        start = (GROUP_PARAMETERS if is_drawing_style(address) else BY_ADDRESS)[address].start
        values[address] = own.get(address, start[0] if len(start) == 1 else (start[0], start[1], start[2]))
    return values | {WORLD_PREFIX + name: 1.0}
