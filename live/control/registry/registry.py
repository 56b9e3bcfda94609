"""Registry of all controls (for OSC, keys and web pages) and readings, and the store of their current values.

The reference in `live docs osc` is generated from it. Readings are figures of a running show, under /dance/status.
"""

import difflib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, Literal

from live.control.events.events import MODULES
from live.control.events.parameters import SetParameter
from live.control.registry.command import controls_of
from live.control.registry.control import ArgumentValue, Control, Query, Result
from live.control.registry.element_controls import ELEMENT_CONTROLS
from live.control.registry.parameter_controls import PARAMETER_CONTROLS
from live.control.registry.rejections import Reason, Rejection

_ROOT: Final = "/dance/"
"""Beginning of all addresses."""
_PASS: Final = "/dance/pass/"
_MOCAP: Final = "/dance/mocap/"
"""Controls under it accept the performer's name in the address: `/dance/mocap/anna/mirrored`."""


class Registry:
    """Controls by their exact address; patterns are resolved by the port (`osc_pattern`)."""

    def __init__(self, controls: Sequence[Control]) -> None:
        self._controls: Mapping[str, Control] = {control.address: control for control in controls}
        if len(self._controls) != len(controls):
            raise ValueError("two controls have one address")

    def __iter__(self) -> Iterator[Control]:
        return iter(self._controls.values())

    def __getitem__(self, address: str) -> Control:
        return self._controls[address]

    def find(self, address: str) -> Control | None:
        """Return the control at an address; None if there is none."""
        return self._controls.get(address)

    def resolve(self, address: str) -> tuple[Control | None, tuple[str, ...]]:
        """Return the control for an address (None if there is none) and the values in the address.

        A pass or performer may be named in the address; those names precede the values of the message.
        """
        control = self._controls.get(address)
        if control is not None:
            return control, ()
        if address.startswith(_PASS):
            parts = tuple(address.removeprefix(_PASS).split("/"))
            return self._controls.get(f"{_PASS}set" if len(parts) == 2 else _PASS.rstrip("/")), parts
        if address.startswith(_MOCAP) and address.count("/") == 4:
            performer, setting = address.removeprefix(_MOCAP).split("/")
            return self._controls.get(_MOCAP + setting), (performer,)
        return None, ()

    def near(self, address: str) -> str | None:
        """Return the address that a person may have meant who wrote this unknown one; None if none is like it.

        What follows a name may belong into the message, as in "/dance/look warm".
        """
        known = {each.removeprefix(_ROOT): each for each in self._controls}
        own = address.strip("/").removeprefix(_ROOT.strip("/")).strip("/")
        for written in (own, own.partition("/")[0]):
            found = difflib.get_close_matches(written, known, n=1, cutoff=0.7)
            if found:
                return known[found[0]]
        return None

    def call(self, address: str, values: Sequence[object], time: float, source: str) -> Result:
        """Call the control at `address` with `values` received at `time` [s of the show] from `source`.

        Call from any thread. Never raises for anything that a sender can choose.
        """
        control, names = self.resolve(address)
        if control is None:
            return Rejection(Reason.UNKNOWN_ADDRESS, address)
        return control.call([*names, *values], time, source)

    def storage_key(self, address: str) -> tuple[str, str]:
        """Return the address under which the value of `address` is stored, and the name in `address` or ""."""
        control, names = self.resolve(address)
        return (control.address, names[0]) if control is not None and control.named and names else (address, "")


COMMANDS: Final = tuple(
    cls
    for module in MODULES
    for cls in vars(module).values()
    if isinstance(cls, type) and cls.__module__ == module.__name__
)
"""The classes that the modules of events declare."""


def _controls(cls: type) -> tuple[Control, ...]:
    """Return the controls of a class of `COMMANDS`; those of all parameters make the same event."""
    return PARAMETER_CONTROLS if cls is SetParameter else controls_of(cls)


REGISTRY: Final = Registry((*ELEMENT_CONTROLS, *(control for cls in COMMANDS for control in _controls(cls))))
"""All controls."""
QUERIES: Final = frozenset(control.address for cls in COMMANDS if issubclass(cls, Query) for control in _controls(cls))
"""Addresses of controls that only ask."""
FIRST_NAMES: Final = {control.address: control.arguments[0].names for control in REGISTRY if control.arguments}
"""What the first value of each control names, see `Argument`; empty: nothing."""


STATUS: Final = "/dance/status/"


@dataclass(frozen=True, slots=True)
class Reading:
    """One read-only figure of a running show."""

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
    Reading("bpm", "float", "The tempo of the dance.", "bpm"),
    Reading("source", "text", "The source of the beat."),
    Reading("clock", "text", "The state of that source: internal, listening, following or locked."),
    Reading("dancers", "int", "Number of dancers on the stage."),
    Reading("phones", "int", "Number of phones of the audience that take part."),
    Reading("section", "text", "The current section of the score; empty if none."),
    Reading("cue", "text", "The cue on standby; empty if none."),
    Reading("seen_step", "text", "Steps of captured performers in the last measure, and how sure each is (0 to 1)."),
    Reading("count_in", "float", "Beats until the cue that is counting in; 0 if none.", "beats"),
    Reading("note_energy", "float", "Velocity of MIDI notes, decaying after each; 0 to 1."),
    Reading("note_density", "float", "MIDI note-ons per beat.", "1/beat"),
    Reading("notes", "int", "Number of MIDI notes that sound."),
    Reading("pitch", "float", "Their mean position on the piano's keys, 0 to 1."),
    Reading(
        "next",
        "text",
        "What could follow the element that has ended, as JSON: after which kind, for whom (`who`), and "
        "`pads` with `pad` and `measures` for /dance/launch, the best one first; empty if nothing is suggested.",
    ),
    Reading("fading", "int", "Number of values that are fading."),
    Reading("frame_ms", "float", "Frame time, 99th percentile.", "ms"),
    Reading(
        "clock_asks",
        "float",
        "By how many beats later the music has its one, if it has spoken against yours for many measures; else 0.",
        "beats",
    ),
    Reading("late_frames", "int", "Late frames since the start."),
    Reading("document", "int", "The revision of the show's files; nothing before their first edit by the show."),
    Reading("document_answers", "text", "The latest answers to edits of the show's files, as JSON."),
    Reading("document_log", "text", "The latest revisions of the show's files, as JSON."),
    Reading("accepted", "int", "Events applied since the start."),
    Reading("refused", "int", "Messages and events refused since the start."),
)
"""All readings."""


Rows = tuple[tuple[str, tuple[ArgumentValue, ...]], ...]
"""A value for all ("", values), or one for each group or each name of a named control."""
Changes = Mapping[str, Rows]
"""Changed values by address."""

READABLE: Final = (
    *(control.address for control in REGISTRY if control.value),
    *(reading.address for reading in READINGS),
)
"""Every address that may have a current value, in the order of the registry."""


class Values:
    """The current values by address. Write from one thread, read from any."""

    def __init__(self) -> None:
        self._rows: dict[str, Rows] = {}

    def update(self, changes: Changes) -> None:
        """Store new values."""
        self._rows.update(changes)

    def __contains__(self, address: str) -> bool:
        return bool(self.rows(address))

    def rows(self, address: str) -> Rows:
        """Return the value at an address; empty if it has none now."""
        rows = self._rows.get(address)
        if rows is not None:
            return rows
        kept, whose = REGISTRY.storage_key(address)
        return tuple(("", values) for name, values in self._rows.get(kept, ()) if name == whose) if whose else ()

    def messages(self, address: str) -> Iterator[tuple[str, tuple[ArgumentValue, ...]]]:
        """Yield address and values of the messages that would set the current value: one, or one per group or name."""
        control = REGISTRY.find(address)
        for name, values in self.rows(address):
            if control is None or not control.named:
                yield address, (*values, name) if name else values
            elif (own := control.address_of(name)) is not None:
                yield own, values
            else:
                yield address, (name, *values)

    def all(self) -> Changes:
        """Return a copy of all current values."""
        return dict(self._rows)
