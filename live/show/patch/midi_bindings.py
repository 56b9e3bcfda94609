"""MIDI bindings of a patch: `[[midi.map]]`, `[[midi.learned]]` and the defaults as `Binding`s."""

from live.control.midi.midi_binding import DEFAULTS, MAX_NUMBER, BadBinding, Binding, merge_bindings
from live.show.patch.section_io import MidiMapSection, MidiSection


def binding_of(section: MidiMapSection) -> Binding:
    """Return a mapping as a `Binding`; BadBinding, a ValueError, if it cannot work."""
    given = [(kind, number) for kind in MAX_NUMBER if (number := getattr(section, kind)) is not None]
    if len(given) != 1:
        raise BadBinding("one of note, cc and program, bend, pressure, nrpn expected: what is played")
    kind, number = given[0]
    return Binding(
        kind,
        0 if number is True else number,
        section.control,
        section.channel or 0,
        section.values,
        section.scale,
        section.curve,
        section.fine,
        section.velocity,
        section.mode,
        section.pickup,
        section.lit,
    )


def learned_bindings(section: MidiSection) -> tuple[Binding, ...]:
    """Return the learned mappings."""
    return tuple(binding_of(row) for row in section.learned)


def written_bindings(section: MidiSection) -> tuple[Binding, ...]:
    """Return the written map, or the defaults."""
    if section.map:
        return tuple(binding_of(row) for row in section.map)
    return DEFAULTS if section.defaults else ()


def bindings_of(section: MidiSection) -> tuple[Binding, ...]:
    """Return the map in force: learned mappings, and written ones for other MIDI messages."""
    return merge_bindings(written_bindings(section), learned_bindings(section))
