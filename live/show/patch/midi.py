"""MIDI of a patch."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from live.control.midi.midi_binding import DEFAULTS, BadBinding, Binding, Kind, Mode, joined
from live.show.patch.section_base import Section

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
