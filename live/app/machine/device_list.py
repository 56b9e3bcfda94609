"""The audio inputs and outputs, MIDI ports and monitors of this machine.

The functions never raise: a missing library, server or screen becomes the section's `why`.
"""

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any, Literal

from live.base.system.native_stderr import suppress_native_stderr

Item = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Section:
    """Devices of one kind; `why`: one sentence why `items` is empty, None if it is not."""

    title: str
    items: tuple[Item, ...]
    why: str | None = None


def one_line(error: BaseException) -> str:
    """Return the error's text on one line, or the name of its type if it has no text."""
    return " ".join(str(error).split()) or type(error).__name__


def audio_sections() -> tuple[Section, Section]:
    """Return audio inputs and outputs: index, name, host (ALSA, JACK, …), channels, sample_rate [Hz], default."""
    from live.control.audio import devices

    def section(direction: str, find: Callable[[], list[devices.SoundDevice]]) -> Section:
        try:
            with suppress_native_stderr():
                items = tuple(asdict(device) for device in find())
        except devices.SoundUnavailable as error:
            return Section(f"audio_{direction}s", (), one_line(error))
        why = f"PortAudio finds no {direction}: no sound card, and no reachable PulseAudio, PipeWire or JACK server"
        return Section(f"audio_{direction}s", items, None if items else why)

    return section("input", devices.list_input_devices), section("output", devices.list_output_devices)


def midi_sections() -> tuple[Section, Section]:
    """Return MIDI inputs and outputs by name, of all running MIDI systems (ALSA, JACK, Core MIDI)."""
    from live.control.midi.midi_ports import port_names
    from live.control.midi.midi_system import MidiUnavailable

    def section(title: str, direction: Literal["input", "output"]) -> Section:
        try:
            with suppress_native_stderr():
                systems = port_names(direction)
        except MidiUnavailable as error:
            return Section(title, (), one_line(error))
        names = [name for found in systems.values() for name in found]
        nothing = "MIDI is available, but no device is connected"
        return Section(title, tuple({"name": name} for name in names), None if names else nothing)

    return section("midi_inputs", "input"), section("midi_outputs", "output")


def monitor_section() -> Section:
    """Return monitors by number (from 1): name, width and height [pixels], refresh_rate [Hz], position, primary."""
    from live.render.window.monitors import list_monitors, screen_problem, stop_glfw

    with suppress_native_stderr():
        found = list_monitors()
        problem = screen_problem()
        stop_glfw()
    items = tuple(
        {
            "number": monitor.index,
            "name": monitor.name,
            "width": monitor.size[0],
            "height": monitor.size[1],
            "refresh_rate": monitor.refresh_hz,
            "position": list(monitor.position),
            "primary": monitor.index == 1,
        }
        for monitor in found
    )
    nothing = problem or "the display server is reachable, but no monitor is switched on"
    return Section("monitors", items, None if items else nothing)


def list_sections() -> list[Section]:
    """Return all sections in display order."""
    return [*audio_sections(), *midi_sections(), monitor_section()]
