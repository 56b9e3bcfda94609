"""OSC of a patch.

MIDI of a patch.

What the lamps of the hall are told, over sACN or Art-Net.

Ableton Link of a patch.

Trackers of a patch.

The audience of a patch.

Captured performers of a patch.
"""

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from live.control.dmx_mapping import SENDS, Channel, widths_of
from live.control.midi.midi_binding import DEFAULTS, BadBinding, Binding, Kind, Mode, joined
from live.show.patch.section_base import Name, Place, Section

Target = Annotated[str, Field(pattern=r"^(\[[0-9A-Fa-f:.]+\]|[^:\s]+):\d{1,5}$", max_length=200)]
Endpoint = Annotated[str, Field(pattern=r"^((\[[0-9A-Fa-f:.]+\]|[^:\s]+):)?\d{1,5}$", max_length=200)]
Endpoints = Annotated[tuple[Endpoint, ...], Field(max_length=8)]
Targets = Annotated[tuple[Target, ...], Field(max_length=8)]


class OscSection(Section):
    """`[osc]`: whom the show tells over OSC what happens in it: beat, measure, tempo, steps, feet, places."""

    out: Targets = ()
    """Addresses like `127.0.0.1:57120`; `--osc-out` or the venue name others instead."""
    positions_per_second: Annotated[float, Field(ge=0, le=60, allow_inf_nan=False)] = 10.0
    """How often the dancers' places are told; 0 for never."""
    feet: bool = True
    """Whether each foot is told that comes down, to make sounds of."""


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
    """Or a parameter without a registered number."""
    channel: Annotated[int, Field(ge=1, le=16)] | None = None
    """1 to 16; all if left out."""
    control: Annotated[str, Field(min_length=1, max_length=100)]
    """The address of a control, as in docs/osc.md."""
    values: dict[str, float | bool | str] = Field(default={})
    """Values of the control that are always the same, by their names."""
    scale: tuple[Bound, Bound] | None = None
    """What a controller's 0 and 127 set; the whole range of the control if left out."""
    curve: Annotated[float, Field(ge=0.1, le=10)] = 1.0
    """The place, 0 to 1, to this power is the share of the scale: 2 is finer at the low end."""
    fine: bool = False
    """Whether the controller, below 32, is one of a pair of 14 bits with the one 32 higher."""
    velocity: bool = False
    """Whether the note sets a number by how hard it is struck."""
    mode: Mode | None = None
    """How a switch is worked; toggle for notes and program changes, momentary for controllers if left out."""
    pickup: bool | None = None
    """Whether nothing happens until the place crosses the present value; only for controllers if left out."""
    lit: tuple[Number, Number] = (0, 127)
    """What a pad is told (`[midi] output`) when its switch is off and on: velocities, often colours."""

    @property
    def binding(self) -> Binding:
        """The line as the map takes it; BadBinding, a ValueError, for one that cannot work."""
        kinds: tuple[Kind, ...] = ("note", "cc", "program", "bend", "pressure", "nrpn")
        given = [(kind, number) for kind in kinds if (number := getattr(self, kind)) is not None]
        if len(given) != 1:
            raise BadBinding("one of note, cc and program, bend, pressure, nrpn expected: what is played")
        kind, number = given[0]
        return Binding(
            kind,
            0 if number is True else number,
            self.control,
            self.channel or 0,
            self.values,
            self.scale,
            self.curve,
            self.fine,
            self.velocity,
            self.mode,
            self.pickup,
            self.lit,
        )

    @model_validator(mode="after")
    def _works(self) -> "MidiMapSection":
        _ = self.binding
        return self


class MidiSection(Section):
    """`[midi]`: ports that are listened to, and what pedals and keys do."""

    input: PortName | None = None
    """A port by its name or a part of it: clock, time code, and what `[[midi.map]]` says."""
    output: PortName | None = None
    """A port that is told present values: the lights of pads, motor faders."""
    clock_out: PortName | None = None
    """A port that the show's beat is sent to as MIDI clock."""
    defaults: bool = True
    """Whether pedals and the keys of channel 16 work the clock where there is no `[[midi.map]]`."""
    time_code_bpm: Annotated[float, Field(ge=20, le=400)] | None = None
    """MIDI time code has no beats: this tempo is counted along it; `[clock] bpm` if left out."""
    time_code_offset_s: Annotated[float, Field(ge=-360000, le=360000, allow_inf_nan=False)] = 0.0
    """The time code at which the first measure begins [s]."""
    map: Annotated[tuple[MidiMapSection, ...], Field(max_length=1000)] = ()
    """What notes, controllers and program changes do, in place of the defaults."""
    learned: Annotated[tuple[MidiMapSection, ...], Field(max_length=1000)] = ()
    """What was learned by moving something; the show writes it into NAME.midi.toml beside the patch."""

    @property
    def bindings(self) -> tuple[Binding, ...]:
        """The map in force: what was learned, and of the rest what is not played by the same."""
        return joined(self.written, [section.binding for section in self.learned])

    @property
    def written(self) -> tuple[Binding, ...]:
        """The map that a person wrote, or the defaults."""
        if self.map:
            return tuple(section.binding for section in self.map)
        return DEFAULTS if self.defaults else ()


class DmxSection(Section):
    """`[[dmx]]`: what one channel of the hall's lamps follows, or several in a row."""

    channel: Annotated[int, Field(ge=1, le=512)]
    """The first of its channels, from 1."""
    sends: Annotated[str, Field(min_length=1, max_length=200)]
    """beat, measure, steps, feet (flashes), tempo [bpm], dancer (x, then z, each coarse and fine), or the address of a
    value, as /dance/light/key/colour: a channel for each of its numbers, over its whole range."""
    dancer: Annotated[int, Field(ge=1, le=4000)] = 1
    """For `dancer`: which one, from 1."""
    beats: Annotated[float, Field(gt=0, le=64)] = 1.0
    """After how many beats a flash is gone."""
    fine: bool = False
    """Whether each number takes two channels, coarse and fine."""

    @model_validator(mode="after")
    def _known(self) -> Self:
        width = widths_of(self.sends) * (2 if self.fine and self.sends != "dancer" else 1)
        if not width:
            raise ValueError(f"nothing is called {self.sends!r}: {', '.join(SENDS)}, or the address of a number")
        if self.channel + width > 513:
            raise ValueError(f"it takes {width} channels from {self.channel} on, and there are 512")
        return self

    @property
    def made(self) -> Channel:
        """As the lamps' process knows it."""
        return Channel(self.channel, self.sends, self.dancer, self.beats, self.fine)


class LinkSection(Section):
    """`[link]`: other programs' and people's tempo and beat, over the local network (Ableton Link)."""

    mode: Literal["off", "follow", "lead"] = "off"
    """`follow`: the show takes the session's tempo, beat and measure line. `lead`: the session takes the show's."""
    start_stop: bool = False
    """Whether starts and stops are shared, too."""


AXES = r"^-?[xyz] -?[xyz]$"


class PsnSection(Section):
    """`[psn]`: trackers that come in by PosiStageNet (`live play PATCH --psn 236.10.10.10:56565`). One with the name,
    or the number, of a `[[mocap]]` is that performer; see [mocap.md](mocap.md)."""

    axes: Annotated[str, Field(pattern=AXES)] = "x z"
    """Which of the tracking system's axes go to the right as the audience sees it, and towards the audience: `x z`,
    `x -z`, `-y x`."""
    others: bool = True
    """Whether dancers go around trackers that are nobody of the patch, as around real dancers."""
    trackers: Annotated[tuple[Name, ...], Field(max_length=128)] = ()
    """The trackers that there are, by name or number: a `[[mocap]]` whose `tracker` is none of them is refused, so that
    a slip of the pen is found before the show. Left out: any."""

    def on_floor(self, place: tuple[float, float, float]) -> tuple[float, float]:
        """Where on the floor that is, x, z [m]."""
        right, front = (
            (-1.0 if axis.startswith("-") else 1.0) * place["xyz".index(axis[-1])] for axis in self.axes.split()
        )
        return right, front


class AudienceSection(Section):
    """`[audience]`: what phones may do in this show; `live play --audience` lets them in."""

    regions: Annotated[tuple[Name, ...], Field(max_length=8)] = ()
    """Rows or groups of seats, among which people choose their own: `["stalls", "balcony"]`; none if left out."""
    vote_measures: Annotated[int, Field(ge=1, le=64)] = 4
    """How many whole measures a vote lasts."""
    gain: Annotated[float, Field(ge=0, le=1, allow_inf_nan=False)] = 1.0
    """How strongly dancers hear the audience at first."""
    open: bool = True
    """Whether phones may play from the beginning."""
    shake: bool = True
    """Whether dancers spread when many phones are shaken."""
    visible: Annotated[int, Field(ge=0, le=24)] = 24
    """How many voices are seen as lights on the floor at a time."""
    phones: Annotated[int, Field(ge=1, le=8000)] = 4000
    """How many phones may play at a time."""
    phones_per_address: Annotated[int, Field(ge=1, le=8000)] = 4
    """How many of one network address may play at a time, where each has its own; together they have one voice. Behind
    one address for all (the venue's `network`) there is no such limit, nor where this is as high as `phones`."""


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
