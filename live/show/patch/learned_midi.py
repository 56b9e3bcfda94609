"""Writer for learned MIDI mappings: NAME.midi.toml next to the patch, which is read as a part of it.

Everything that a person wrote in the file is kept.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import tomlkit
from tomlkit.exceptions import TOMLKitError

from live.base.errors import PersonError
from live.control.midi.midi_binding import Binding
from live.show.patch.midi_bindings import binding_of
from live.show.patch.patch_search_path import is_file, learned_path
from live.show.patch.section_base import Section
from live.show.patch.section_io import MidiMapSection
from live.show.patch.toml_model import parse_model, read_text
from live.show.patch_checks.entry_checks import ENTRY_CHECKS

HEAD: Final = "# MIDI mappings learned while the show ran (/dance/midi/learn); a part of {patch}.\n"


class _MidiTable(Section):
    learned: tuple[MidiMapSection, ...] = ()


class _LearnedFile(Section):
    """The whole file."""

    midi: _MidiTable = _MidiTable()


def updated_mapping_text(patch: Path, learned: Sequence[Binding], forgotten: Sequence[str]) -> str:
    """Return the new text of the file next to `patch`: without the mappings of the controls `forgotten`, and with
    `learned`, each of which replaces a mapping of the same MIDI message. PersonError if the present file is invalid."""
    path = learned_path(patch)
    before = read_text(path, "MIDI map") if is_file(path) else ""
    parse_model(before, str(path), _LearnedFile, "MIDI map", ENTRY_CHECKS)
    try:
        text = merge_mappings(before or HEAD.format(patch=patch.name), learned, forgotten)
    except TOMLKitError as error:
        raise PersonError(f"{path}: {error}", "repair it, and learn the mapping again") from None
    parse_model(text, str(path), _LearnedFile, "MIDI map", ENTRY_CHECKS)
    return text


def merge_mappings(text: str, learned: Sequence[Binding], forgotten: Sequence[str]) -> str:
    """Return the TOML `text` with these changes; comments and everything else are kept."""
    document = tomlkit.parse(text)
    if "midi" not in document:
        document["midi"] = tomlkit.table(is_super_table=True)
    midi: Any = document["midi"]
    if "learned" not in midi:
        midi["learned"] = tomlkit.aot()
    rows = midi["learned"]
    places = {(one.kind, one.number, one.channel) for one in learned}
    for index in reversed(range(len(rows))):
        row = rows[index]
        if row["control"] in forgotten or _binding_place(row) in places:
            del rows[index]
    for one in learned:
        rows.append(_table(one))
    if not len(rows):
        del midi["learned"]
    if not len(midi):
        del document["midi"]
    return tomlkit.dumps(document)


def _binding_place(row: Any) -> tuple[str, int, int]:
    return binding_of(MidiMapSection.model_validate(row.unwrap())).trigger


def _table(binding: Binding) -> Any:
    table = tomlkit.table()
    table[binding.kind] = True if binding.kind in ("bend", "pressure") else binding.number
    if binding.channel:
        table["channel"] = binding.channel
    table["control"] = binding.control
    if binding.values:
        values = tomlkit.inline_table()
        values.update(dict(binding.values))
        table["values"] = values
    for name in ("fine", "velocity"):
        if getattr(binding, name):
            table[name] = True
    table.add(tomlkit.nl())
    return table
