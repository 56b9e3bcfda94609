"""Another piece of music for a show: the edits that replace it with its measure map, as one revision (T007)."""

from dataclasses import replace
from typing import TYPE_CHECKING, Final

from live.clock.measure_map import MeasureMap
from live.document.document import Document
from live.document.edit import Edit, Fault
from live.document.place import refuse
from live.rehearse.music_lint import music_notes
from live.show.patch.patch import Patch
from live.show.patch.toml_model import key_text

if TYPE_CHECKING:
    from live.document.document_store import Accepted, DocumentStore

MAX_NOTES: Final = 100
"""Maximum number of notes in an answer."""


def replace_music(store: "DocumentStore", file: str | None, measures: MeasureMap | None, by: str) -> "Accepted":
    """Replace the music's file (None: it stays) and its measure lines as one revision, and tell what of the score does
    not fit them; EditRefused with all faults changes nothing."""

    def make(patch: Patch) -> list[Edit]:
        edits = music_edits(patch, file, measures)
        if not edits:
            raise refuse(("music",), "it is the same music with the same measures")
        return edits

    accepted = store.edit_together(make, "music", by)
    return replace(accepted, notes=tuple(music_faults(store.document)))


def music_edits(patch: Patch, file: str | None, measures: MeasureMap | None) -> list[Edit]:
    """Return the edits that replace the music's file (None: it stays) and its measures (None: they are unknown)."""
    music, edits = patch.music, list[Edit]()
    if file is not None and file != music.file:
        edits.append(Edit("set", ("music", "file"), file))
    for key in ("bpm", "one_at_s"):  # of the former music
        if getattr(music, key) is not None:
            edits.append(Edit("set", ("music", key), None))
    for names, rows in (("line", music.line), ("phrase", music.phrase)):
        edits += [Edit("delete", ("music", names, number)) for number in range(len(rows), 0, -1)]
    for line in () if measures is None else measures.lines:
        value = {"time_s": round(line.time_s, 6), "measure": line.measure, "beats": line.beats}
        edits.append(Edit("insert", ("music", "line"), value | ({"tempo": "ramp"} if line.tempo == "ramp" else {})))
    for phrase in () if measures is None else measures.phrases:
        name = {"name": phrase.name} if phrase.name else {}
        edits.append(Edit("insert", ("music", "phrase"), {"measure": phrase.measure, **name}))
    return edits


def music_faults(document: Document) -> list[Fault]:
    """Return what of a document does not fit the measures of its music, with file, line and measure."""
    faults = []
    for note in music_notes(document.patch)[:MAX_NOTES]:
        file, line = document.location(note.key_path)
        faults.append(Fault(note.what, file, line, key_text(note.key_path), note.remedy, note.measure))
    return faults
