"""Captured performers of a patch."""

from typing import Annotated

from pydantic import Field

from live.show.patch.section_base import Name, Place, Section

Words = Annotated[str, Field(min_length=1, max_length=250)]


class MocapSection(Section):
    """`[[mocap]]`: a real dancer whose whole body is captured live and who dances among the others; see
    [mocap.md](mocap.md). With `live play PATCH --vmc PORT` and no such table there is one who is called `live`."""

    name: Name
    """What she is called, as in `/dance/mocap/NAME/shown`."""
    dancer: Words | None = None
    """Which dancer she is: the first of whom these words mean, as `3`, `ember & 1` or a group; `none` for nobody. Left
    out: the first dancer whom no other performer is."""
    tracker: Annotated[str, Field(min_length=1, max_length=64)] | None = None
    """The PosiStageNet tracker (its name or number there) that says where she stands, while her suit says how: her suit
    may drift then. `at`, `turn_deg` and `scale` are the tracking system's. See `[psn] trackers`."""
    shown: bool = True
    """Whether she is seen from the beginning."""
    mirrored: bool = False
    """Whether she is seen as in a mirror."""
    at: Place = (0.0, 0.0)
    """Where the middle of her floor lies on the stage (x, z) [m]."""
    turn_deg: Annotated[float, Field(ge=-360, le=360)] = 0.0
    """How her floor is turned on the stage, towards +x."""
    scale: Annotated[float, Field(ge=0, le=10)] = 1.0
    """How long her ways become; feet slide where it is not 1."""
    canon: Words = "none"
    """Who repeats her, as `mist` or `mist & 1-4`."""
    canon_beats: Annotated[float, Field(ge=0, le=16)] = 2.0
    """From one who repeats her to the next."""
    obstacle: bool = False
    """Whether dancers go out of her way as of somebody real; they always do as of another dancer."""
    attract: Annotated[float, Field(ge=-10, le=10)] = 0.0
    """How strongly she draws dancers to her; below 0 she drives them away."""
    attracts: Words = "*"
    """Who is drawn or driven away: words as in `mist & 1-4`; `*` is everybody."""
    delay_ms: Annotated[float, Field(ge=0, le=1000)] = 40.0
    """How much later she is shown than she was received, so that between two poses that come unevenly there is always
    a way to go."""
    floor: bool = True
    """Whether her feet are brought down to the floor, wherever the capture has its own."""
    port: Annotated[int, Field(ge=0, le=65535)] = 0
    """The port here that she alone sends to; 0: any that is listened to."""
    sender: Annotated[str, Field(max_length=100)] = ""
    """The address of the machine that sends her; empty: whoever sends, in the order in which they begin."""
