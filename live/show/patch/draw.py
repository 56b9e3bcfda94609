"""How dancers are drawn, as a patch says it: `[group.draw]` and `draw` of `[[looks]]`."""

from collections.abc import Mapping
from typing import Annotated, Final

from pydantic import Field

from live.base.errors import PersonError
from live.base.picture import OF_GROUPS, STYLE_OF_GROUP
from live.show.desk.parameter_table import check_setting, split


def _key(address: str) -> str:
    return address.removeprefix(STYLE_OF_GROUP).replace("/", "_")


KEYS: Final = tuple(_key(address) for address in OF_GROUPS if address.startswith(STYLE_OF_GROUP))
"""All keys."""
Setting = float | bool | str | tuple[float, float, float]
Draw = Annotated[dict[str, Setting], Field(max_length=400)]
"""Values by the control's address without `/dance/draw/`, words joined by `_` or `/`: `ink_width`."""


def drawn(said: Mapping[str, Setting]) -> dict[str, Setting]:
    """The same values by the addresses of their controls, a group's name kept behind."""
    settings = {}
    for key, value in said.items():
        name, space, group = key.strip().partition(" ")
        settings[STYLE_OF_GROUP + name.replace("_", "/") + space + group] = value
    return settings


def check_drawn(said: Mapping[str, Setting], where: str) -> None:
    """ValueError, which begins with `where`, for a key that there is not or a value that it cannot have."""
    for key, value in drawn(said).items():
        address = split(key)[0]
        if address not in OF_GROUPS or not address.startswith(STYLE_OF_GROUP):
            raise ValueError(f"{where}: nothing is drawn by {_key(address)!r}; there are: {', '.join(KEYS)}")
        try:
            check_setting(key, value)
        except PersonError as error:
            raise ValueError(f"{where}: {error}") from None
