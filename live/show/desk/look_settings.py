"""The parameters behind the keys of a look (`[look]`, `[[looks]]`) and of a drawing style (`draw`) in a patch."""

from collections.abc import Mapping
from typing import Final

from live.base.picture_parameters import GROUP_PARAMETERS, STYLE_ADDRESS_PREFIX
from live.show.patch.section_base import Setting
from live.show.patch.section_stage import NamedLookSection

LOOK_ADDRESSES: Final = {
    "background": "/dance/light/background",
    "floor": "/dance/light/floor",
    "key_light": "/dance/light/key/colour",
    "key": "/dance/light/key",
    "key_direction": "/dance/light/key/direction",
    "rim_light": "/dance/light/rim/colour",
    "rim": "/dance/light/rim",
    "ambient": "/dance/light/ambient",
    "ambient_colour": "/dance/light/ambient/colour",
    "haze": "/dance/light/haze",
    "level": "/dance/light/level",
    "saturation": "/dance/light/saturation",
    "side": "/dance/light/side",
    "side_left": "/dance/light/side/left",
    "side_right": "/dance/light/side/right",
    "back": "/dance/light/back",
    "back_light": "/dance/light/back/colour",
    "beams": "/dance/light/beams",
    "beams_colour": "/dance/light/beams/colour",
    "beams_width": "/dance/light/beams/width",
    "beams_fan": "/dance/light/beams/fan",
    "beams_sway": "/dance/light/beams/sway",
    "pulse": "/dance/light/pulse",
    "energy": "/dance/light/energy",
    "stage": "/dance/light/stage",
    "gradient": "/dance/background/gradient",
    "gradient_top": "/dance/background/top",
    "gradient_bottom": "/dance/background/bottom",
}
"""The parameter behind each key of a look."""


def draw_key(address: str) -> str:
    """Return the key of a drawing style that sets the parameter at `address`."""
    return address.removeprefix(STYLE_ADDRESS_PREFIX).replace("/", "_")


DRAW_KEYS: Final = tuple(draw_key(address) for address in GROUP_PARAMETERS if address.startswith(STYLE_ADDRESS_PREFIX))
"""All keys of a drawing style."""


def draw_settings(values: Mapping[str, Setting]) -> dict[str, Setting]:
    """Return the same values by the addresses of their controls, followed by the group's name if there is one."""
    settings = {}
    for key, value in values.items():
        name, space, group = key.strip().partition(" ")
        settings[STYLE_ADDRESS_PREFIX + name.replace("_", "/") + space + group] = value
    return settings


def look_settings(look: NamedLookSection) -> dict[str, Setting]:
    """Return the parameters that a look sets, by address."""
    said = {address: getattr(look, key) for key, address in LOOK_ADDRESSES.items()}
    return {address: value for address, value in said.items() if value is not None} | draw_settings(look.draw)
