"""The registry: one table of every control, whoever uses it (OSC, keys, web pages).

The reference in docs/osc.md is written from this table.

Readings: what can only be read of a running show, under /dance/status, as the values of controls are.

Values: what everything that has a present value is now, as the show said it last, for whoever asks or listens.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal

from live.control.registry.audience_controls import AUDIENCE_CONTROLS
from live.control.registry.audio_controls import AUDIO_CONTROLS
from live.control.registry.capture_controls import MOCAP_CONTROLS
from live.control.registry.clock_controls import CLOCK_CONTROLS
from live.control.registry.control import Control, Plain, Result
from live.control.registry.cues_controls import CUE_CONTROLS
from live.control.registry.elements_controls import ELEMENT_CONTROLS
from live.control.registry.groups_controls import GROUP_CONTROLS
from live.control.registry.midi_controls import MIDI_CONTROLS
from live.control.registry.motion_controls import MOTION_CONTROLS, STEP_CONTROLS
from live.control.registry.output_controls import OUTPUT_CONTROLS
from live.control.registry.partners_controls import PARTNER_CONTROLS
from live.control.registry.rejections import Reason, Rejection
from live.control.registry.scenes_controls import SCENE_CONTROLS
from live.control.registry.score_controls import SCORE_CONTROLS
from live.control.registry.system_controls import ASKING_CONTROLS, MACHINE_CONTROLS

_PASS: Final = "/dance/pass/"
_MOCAP: Final = "/dance/mocap/"
"""Below it the performer's name may stand in the address: `/dance/mocap/anna/mirrored`."""


class Registry:
    """Controls by their exact address; patterns are for the port to find out (`osc_pattern`)."""

    def __init__(self, controls: Sequence[Control]) -> None:
        self._controls: Mapping[str, Control] = {control.address: control for control in controls}
        if len(self._controls) != len(controls):
            raise ValueError("two controls have one address")

    def __iter__(self) -> Iterator[Control]:
        return iter(self._controls.values())

    def __getitem__(self, address: str) -> Control:
        return self._controls[address]

    def find(self, address: str) -> Control | None:
        """The control at an address; None if there is none."""
        return self._controls.get(address)

    def meant(self, address: str) -> Control | None:
        """The control that answers to an address: of a patch's own passes only the show knows the names."""
        control = self._controls.get(address)
        if control is None and address.startswith(_PASS):
            return self._controls.get(f"{_PASS}set" if address.count("/") == 4 else _PASS.rstrip("/"))
        if control is None and address.startswith(_MOCAP) and address.count("/") == 4:
            return self._controls.get(_MOCAP + address.rpartition("/")[2])
        return control

    def call(self, address: str, values: Sequence[object], time: float, source: str) -> Result:
        """What the control at `address` makes of `values`, received at `time` [s of the show] from `source`.

        Thread: any. Never raises for anything a sender can choose.
        """
        control = self.meant(address)
        if control is None:
            return Rejection(Reason.UNKNOWN_ADDRESS, address)
        return control.call(self.whole(address, values), time, source)

    def whole(self, address: str, values: Sequence[object]) -> Sequence[object]:
        """The values of a message, with those before them that stand in its address."""
        if address in self._controls or self.meant(address) is None:
            return values
        within = address.removeprefix(_PASS).split("/")
        return [*(address.split("/")[3:4] if address.startswith(_MOCAP) else within), *values]

    def kept_at(self, address: str) -> tuple[str, str]:
        """The address under which the show tells the value of `address`, and the name that this has in it, or ""."""
        control = None if address in self._controls else self.meant(address)
        return (address, "") if control is None or not control.named else (control.address, address.split("/")[3])


REGISTRY: Final = Registry(
    (
        *ELEMENT_CONTROLS,
        *GROUP_CONTROLS,
        *STEP_CONTROLS,
        *MOTION_CONTROLS,
        *PARTNER_CONTROLS,
        *SCENE_CONTROLS,
        *CUE_CONTROLS,
        *OUTPUT_CONTROLS,
        *AUDIENCE_CONTROLS,
        *CLOCK_CONTROLS,
        *AUDIO_CONTROLS,
        *SCORE_CONTROLS,
        *MOCAP_CONTROLS,
        *MACHINE_CONTROLS,
        *MIDI_CONTROLS,
        *ASKING_CONTROLS,
    )
)
"""Every control there is."""


STATUS: Final = "/dance/status/"


@dataclass(frozen=True, slots=True)
class Reading:
    """One figure of a running show."""

    name: str
    type: Literal["float", "int", "text"]
    description: str
    unit: str = ""

    @property
    def address(self) -> str:
        """Its OSC address."""
        return STATUS + self.name


READINGS: Final = (
    Reading("measure", "int", "The measure of the show, from 1."),
    Reading("beat", "int", "The beat of the measure, from 1."),
    Reading("bpm", "float", "The tempo that is danced.", "bpm"),
    Reading("source", "text", "Which source the beat comes from."),
    Reading("clock", "text", "How sure that source is: internal, listening, following or locked."),
    Reading("dancers", "int", "Dancers on the stage."),
    Reading("phones", "int", "Phones of the audience that play along."),
    Reading("section", "text", "The section of the score; empty outside of all."),
    Reading("cue", "text", "The cue that stands by; empty if none does."),
    Reading("count_in", "float", "Beats until the cue comes that counts in; 0 if none does.", "beats"),
    Reading("note_energy", "float", "How hard notes over MIDI are struck, dying away; 0 to 1."),
    Reading("note_density", "float", "Strokes of notes over MIDI per beat.", "1/beat"),
    Reading("notes", "int", "Notes over MIDI that sound."),
    Reading("pitch", "float", "Where on the piano's keys they lie, 0 to 1."),
    Reading("fading", "int", "Numbers that are on their way to another value."),
    Reading("frame_ms", "float", "From one frame to the next; 99 of 100 are not longer.", "ms"),
    Reading("late_frames", "int", "Frames that came late, since the start."),
    Reading("accepted", "int", "Events that acted, since the start."),
    Reading("refused", "int", "Messages and events that were refused, since the start."),
)
"""All of them."""


Rows = tuple[tuple[str, tuple[Plain, ...]], ...]
"""A value of all ("", numbers), or that of each group, or of each that a control names, by its name."""
Changes = Mapping[str, Rows]
"""What has another value than before, by address."""

READABLE: Final = (
    *(control.address for control in REGISTRY if control.value),
    *(reading.address for reading in READINGS),
)
"""Every address that may have a present value, in the order of the registry."""


class Values:
    """The present values by address. Thread: one writes, any reads."""

    def __init__(self) -> None:
        self._rows: dict[str, Rows] = {}

    def take(self, changes: Changes) -> None:
        """These have new values."""
        self._rows.update(changes)

    def __contains__(self, address: str) -> bool:
        return bool(self.rows(address))

    def rows(self, address: str) -> Rows:
        """The value at an address; empty if it has none now."""
        rows = self._rows.get(address)
        if rows is not None:
            return rows
        kept, whose = REGISTRY.kept_at(address)
        return tuple(("", values) for name, values in self._rows.get(kept, ()) if name == whose) if whose else ()

    def messages(self, address: str) -> Iterator[tuple[str, tuple[Plain, ...]]]:
        """Addresses and values of the messages that would set an address to what it is: one, or one for each group or
        name."""
        control = REGISTRY.find(address)
        for name, values in self.rows(address):
            if control is None or not control.named:
                yield address, (*values, name) if name else values
            elif (own := control.address_of(name)) is not None:
                yield own, values
            else:
                yield address, (name, *values)

    def all(self) -> Changes:
        """Everything that has a value now: a copy."""
        return dict(self._rows)


def changed(before: Changes, now: Changes) -> dict[str, Rows]:
    """What of `now` is not equal to what was `before`."""
    return {address: rows for address, rows in now.items() if before.get(address) != rows}
