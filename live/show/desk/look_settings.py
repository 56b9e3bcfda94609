"""The parameters behind the keys of a look (`[look]`, `[[looks]]`) and of a drawing style (`draw`) in a patch."""

from collections.abc import Mapping
from typing import Final

from live.base.parameter import WORLD_NAMES
from live.base.picture_parameters import GROUP_PARAMETERS, STYLE_ADDRESS_PREFIX
from live.show.desk.worlds import is_drawing_style, world_values
from live.show.patch.patch import Patch
from live.show.patch.section_base import Setting, parameter_values
from live.show.patch.section_stage import NamedLookSection


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


def group_settings(name: str, draw: Mapping[str, Setting]) -> tuple[dict[str, Setting], dict[str, Setting]]:
    """Return how a group is drawn at the start, by address, and how those of its dancers are for whom a selection
    stands behind the key, by address and selection."""
    whole: dict[str, Setting] = {}
    selected: dict[str, Setting] = {}
    for key, value in draw_settings(draw).items():
        address, space, words = key.partition(" ")
        if space and words.strip():
            selected[f"{address} {name} & {words.strip()}"] = value
        else:
            whole[address] = value
    return whole, selected


def world_settings(patch: Patch, name: str) -> dict[str, Setting]:
    """Return the parameters that a world sets, by address, those of the stage first; the patch's own values come first.

    What `[look]` and `[picture.set]` say is said of the world in which the show begins; the other worlds come whole, or
    a floor that is dark for the black box would be dark in the white studio, too. A group's parameters are followed by
    its name: how a group is drawn is said of all worlds. KeyError for an unknown world.
    """
    values = world_values(name)
    begins = patch.look.world or WORLD_NAMES[0]
    said = {**patch.picture.set, **parameter_values("look", patch.look)} if name == begins else {}
    settings: dict[str, Setting] = {
        address: said.get(address, value) for address, value in values.items() if not is_drawing_style(address)
    }
    for group in patch.group:
        own = group_settings(group.name, group.draw)[0]
        settings |= {
            f"{address} {group.name}": value
            for address, value in values.items()
            if is_drawing_style(address) and address not in own
        }
    return settings


def look_settings(patch: Patch, look: NamedLookSection) -> dict[str, Setting]:
    """Return the parameters that a look sets, by address: those of its world first."""
    world = {} if look.world is None else world_settings(patch, look.world)
    return world | parameter_values("look", look) | draw_settings(look.draw)
