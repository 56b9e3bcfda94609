"""Command `live devices`: lists the audio inputs and outputs, MIDI ports and monitors that a show can use."""

import json
from typing import Annotated

import typer

from live.app.machine.device_list import Item, Section, list_sections

_HEADINGS = {
    "audio_inputs": "Audio in",
    "audio_outputs": "Audio out",
    "midi_inputs": "MIDI in",
    "midi_outputs": "MIDI out",
    "monitors": "Monitors",
}


def _describe(item: Item) -> str:
    if "width" in item:
        text = f"{item['width']}×{item['height']}, {item['refresh_rate']:.4g} Hz, at {tuple(item['position'])}"
        return text + (", primary" if item["primary"] else "")
    if "channels" in item:
        text = f"{item['host']}, {item['channels']} channels, {item['sample_rate']:g} Hz"
        return text + (", default" if item["default"] else "")
    return ""


def _print(section: Section) -> None:
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
