"""Ableton Link of a patch."""

from typing import Literal

from live.show.patch.section_base import Section


class LinkSection(Section):
    """`[link]`: other programs' and people's tempo and beat, over the local network (Ableton Link)."""

    mode: Literal["off", "follow", "lead"] = "off"
    """`follow`: the show takes the session's tempo, beat and measure line. `lead`: the session takes the show's."""
    start_stop: bool = False
    """Whether starts and stops are shared, too."""
