"""Command `live devices`: lists the audio inputs and outputs, MIDI ports and monitors that a show can use.

The functions never raise: a missing library, server or screen becomes the section's `why`.
"""

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Annotated, Any, Literal

import typer

from live.base.native_stderr import suppress_native_stderr

_HEADINGS = {
    "audio_inputs": "Audio in",
    "audio_outputs": "Audio out",
    "midi_inputs": "MIDI in",
    "midi_outputs": "MIDI out",
    "monitors": "Monitors",
}


def _describe(item: "Item") -> str:
    if "width" in item:
        text = f"{item['width']}×{item['height']}, {item['refresh_rate']:.4g} Hz, at {tuple(item['position'])}"
        return text + (", primary" if item["primary"] else "")
    if "channels" in item:
        text = f"{item['host']}, {item['channels']} channels, {item['sample_rate']:g} Hz"
        return text + (", default" if item["default"] else "")
    return ""


def _print(section: "Section") -> None:
    from rich.console import Console
    from rich.text import Text

    console = Console(highlight=False, soft_wrap=True)
    console.print(Text(_HEADINGS[section.title], "bold"))
    if section.why is not None:
        console.print(Text(f"  none: {section.why}"))
    for position, item in enumerate(section.items):
        number = item.get("index", item.get("number", position))
        console.print(Text.assemble((f"  {number}  ", "cyan"), item["name"], ("  " + _describe(item), "dim")))


def devices(
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object instead.")] = False,
) -> None:
    """List audio inputs and outputs, MIDI ports and monitors."""

    sections = list_sections()
    if as_json:
        print(json.dumps({section.title: {"items": section.items, "why": section.why} for section in sections}))
        return
    for section in sections:
        _print(section)


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
    from live.control.midi.midi_ports import MidiUnavailable, port_names

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
