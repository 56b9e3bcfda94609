"""Patch sections for input and output: OSC, MIDI, Ableton Link, trackers, audience, mocap."""

from typing import Annotated, Final, Literal

from pydantic import Field, ValidationInfo, model_validator

from live.show.patch.section_base import Name, Place, Section, run_check

Target = Annotated[str, Field(pattern=r"^(\[[0-9A-Fa-f:.]+\]|[^:\s]+):\d{1,5}$", max_length=200)]
Targets = Annotated[tuple[Target, ...], Field(max_length=8)]


class OscSection(Section):
    """`[osc]`: OSC output of the show's beat, measure, tempo, steps, feet and positions."""

    out: Targets = ()
    """Destinations such as `127.0.0.1:57120`; `--osc-out` or the venue overrides them."""
    positions_per_second: Annotated[float, Field(ge=0, le=60, allow_inf_nan=False)] = 10.0
    """How often the dancers' positions are sent; 0: never."""
    feet: bool = True
    """Whether a message is sent for each foot that lands, for making sounds."""


PortName = Annotated[str, Field(min_length=1, max_length=200)]
Number = Annotated[int, Field(ge=0, le=127)]
Bound = Annotated[float, Field(allow_inf_nan=False)]


class MidiMapSection(Section):
    """`[[midi.map]]`: what one note, controller or program change does."""

    note: Number | None = None
    """A note, 0 to 127 (middle C is 60)."""
    cc: Number | None = None
    """Or a controller."""
    program: Number | None = None
    """Or a program change, 0 to 127."""
    bend: Literal[True] | None = None
    """Or the pitch bend of the channel."""
    pressure: Literal[True] | None = None
    """Or the pressure of the channel (aftertouch)."""
    nrpn: Annotated[int, Field(ge=0, le=16383)] | None = None
    """Or a non-registered parameter number."""
    channel: Annotated[int, Field(ge=1, le=16)] | None = None
    """1 to 16; all if left out."""
    control: Annotated[str, Field(min_length=1, max_length=100)]
    """The address of a control, as in `live docs osc`."""
    values: dict[str, float | bool | str] = Field(default={})
    """Constant values of the control, by their names."""
    scale: tuple[Bound, Bound] | None = None
    """Values that a controller's 0 and 127 set; left out: the whole range of the control."""
    curve: Annotated[float, Field(ge=0.1, le=10)] = 1.0
    """Exponent of the controller's position, 0 to 1: 2 is finer at the low end."""
    fine: bool = False
    """Whether the controller, below 32, forms a 14-bit pair with the one 32 higher."""
    velocity: bool = False
    """Whether the note's velocity sets the value."""
    mode: Literal["toggle", "momentary"] | None = None
    """Behaviour of a switch; left out: toggle for notes and program changes, momentary for controllers."""
    pickup: bool | None = None
    """Whether nothing changes until the controller crosses the present value; left out: only for controllers."""
    lit: tuple[Number, Number] = (0, 127)
    """Velocities sent to a pad (`[midi] output`) when its switch is off and on; often colours."""

    @model_validator(mode="after")
    def _binding_is_valid(self, info: ValidationInfo) -> "MidiMapSection":
        run_check(info, "midi.map", self)
        return self


class MidiSection(Section):
    """`[midi]`: input and output ports, and what pedals and keys do."""

    input: PortName | None = None
    """Input port, by its name or a part of it: clock, time code, and messages for `[[midi.map]]`."""
    output: PortName | None = None
    """Port for feedback of present values: pad lights, motor faders."""
    clock_out: PortName | None = None
    """Port to which the show's beat is sent as MIDI clock."""
    grid: PortName | None = None
    """Port of a grid controller (Launchpad, APC) with the show's pads, or `auto` for the first one connected."""
    defaults: bool = True
    """Whether pedals and the keys of channel 16 control the clock if there is no `[[midi.map]]`."""
    time_code_bpm: Annotated[float, Field(ge=20, le=400)] | None = None
    """Tempo for MIDI time code, which has no beats; left out: `[clock] bpm`."""
    time_code_offset_s: Annotated[float, Field(ge=-360000, le=360000, allow_inf_nan=False)] = 0.0
    """The time code at which the first measure begins [s]."""
    map: Annotated[tuple[MidiMapSection, ...], Field(max_length=1000)] = ()
    """What notes, controllers and program changes do, instead of the defaults."""
    learned: Annotated[tuple[MidiMapSection, ...], Field(max_length=1000)] = ()
    """Mappings learned from controller moves; the show writes them to NAME.midi.toml next to the patch."""


class LinkSection(Section):
    """`[link]`: tempo and beat shared with other programs over the local network (Ableton Link)."""

    mode: Literal["off", "follow", "lead"] = "off"
    """`follow`: the show takes the session's tempo, beat and measure line. `lead`: the session takes the show's."""
    start_stop: bool = False
    """Whether starts and stops are shared, too."""


AXES = r"^-?[xyz] -?[xyz]$"


class PsnSection(Section):
    """`[psn]`: trackers received by PosiStageNet (`live play PATCH --psn 236.10.10.10:56565`). A tracker with the name
    or number of a `[[mocap]]` is that performer; see `live docs mocap`."""

    axes: Annotated[str, Field(pattern=AXES)] = "x z"
    """Axes of the tracking system that point to the right as the audience sees it, and towards the audience: `x z`,
    `x -z`, `-y x`."""
    others: bool = True
    """Whether dancers go around trackers that belong to no performer, as around real dancers."""
    trackers: Annotated[tuple[Name, ...], Field(max_length=128)] = ()
    """The existing trackers, by name or number: a `[[mocap]]` with another `tracker` is refused, so that a typing error
    is found before the show. Left out: any."""

    def to_floor(self, place: tuple[float, float, float]) -> tuple[float, float]:
        """Return the position on the floor, x, z [m]."""
        right, front = (
            (-1.0 if axis.startswith("-") else 1.0) * place["xyz".index(axis[-1])] for axis in self.axes.split()
        )
        return right, front


class AudienceSection(Section):
    """`[audience]`: what phones may do in this show; `live play --audience` starts their server."""

    regions: Annotated[tuple[Name, ...], Field(max_length=8)] = ()
    """Rows or groups of seats, from which people choose theirs: `["stalls", "balcony"]`; left out: none."""
    vote_measures: Annotated[int, Field(ge=1, le=64)] = 4
    """Length of a vote in measures."""
    tally: bool = True
    """Whether projectors show how a vote stands, and its winner, from the beginning; phones always do."""
    winner_measures: Annotated[int, Field(ge=1, le=64)] = 4
    """For how many measures projectors show the winner of a vote."""
    gain: Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)] = 1.0
    """Initial strength of the audience's influence on dancers."""
    open: bool = True
    """Whether phones may take part from the beginning."""
    shake: bool = True
    """Whether dancers spread when many phones are shaken."""
    visible: Annotated[int, Field(ge=0, le=24)] = 24
    """Largest number of participants shown as lights on the floor at a time."""
    phones: Annotated[int, Field(ge=1, le=200000)] = 4000
    """Largest number of phones at a time; a gateway serves up to 10,000, see `live docs stadium`."""
    phones_per_address: Annotated[int, Field(ge=1, le=200000)] = 4
    """Largest number of phones from one network address at a time; together they count as one participant. There is no
    limit if all phones share an address (the venue's `network`), or if this is as high as `phones`."""


Selection = Annotated[str, Field(min_length=1, max_length=250)]


DEFAULT_PERFORMER: Final = "live"
"""The performer's name where the patch has none."""


class MocapSection(Section):
    """`[[mocap]]`: a real dancer whose whole body is captured live and who dances among the others; see
    `live docs mocap`. With `live play PATCH --vmc PORT` and no such table there is one performer named `live`."""

    name: Name
    """Name of the performer, as in `/dance/mocap/NAME/shown`."""
    dancer: Selection | None = None
    """The dancer to drive: the first one of a selection such as `3`, `ember & 1` or a group; `none` for no dancer. Left
    out: the first dancer that no other performer drives."""
    tracker: Annotated[str, Field(min_length=1, max_length=64)] | None = None
    """The PosiStageNet tracker (its name or number there) that gives the position, while the suit gives the pose: the
    suit may drift then. `at`, `turn_deg` and `scale` are the tracking system's. See `[psn] trackers`."""
    shown: bool = True
    """Whether the performer is visible from the beginning."""
    mirrored: bool = False
    """Whether the motion is mirrored, left for right."""
    at: Place = (0.0, 0.0)
    """Position on the stage of the middle of the capture floor (x, z) [m]."""
    turn_deg: Annotated[float, Field(ge=-360, le=360)] = 0.0
    """Rotation of the capture floor on the stage, towards +x."""
    scale: Annotated[float, Field(ge=0, le=10)] = 1.0
    """Scale of travelled distances; feet slide if it is not 1."""
    canon: Selection = "none"
    """Dancers who repeat the motion in canon, such as `mist` or `mist & 13-16`."""
    canon_beats: Annotated[float, Field(ge=0, le=16)] = 2.0
    """Delay in beats from one dancer of the canon to the next."""
    obstacle: bool = False
    """Whether dancers avoid the performer as a real person; they always do as another dancer."""
    attract: Annotated[float, Field(ge=-10, le=10)] = 0.0
    """How strongly the performer attracts dancers; below 0 they are repelled."""
    attracts: Selection = "*"
    """Dancers who are attracted or repelled, as in `mist & 13-16`; `*` is all."""
    delay_ms: Annotated[float, Field(ge=0, le=1000)] = 40.0
    """Delay between receiving and showing a pose; it absorbs the jitter of the network."""
    floor: bool = True
    """Whether the feet are put on the stage floor, wherever the capture has its floor."""
    port: Annotated[int, Field(ge=0, le=65535)] = 0
    """Local port for this performer alone; 0: any open one."""
    sender: Annotated[str, Field(max_length=100)] = ""
    """Address of the sending machine; empty: any, assigned in the order in which senders begin."""
