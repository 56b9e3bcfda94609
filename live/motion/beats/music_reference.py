"""Beat reference of a recording (T017, T018): first beat, tempo and confidence."""

from dataclasses import dataclass, replace
from typing import Final, Literal

ReferenceSource = Literal["hand", "click", "claps", "song", "feet"]

BPM_RANGE: Final = (20.0, 400.0)
"""Allowed tempi of a recording [bpm]."""


@dataclass(frozen=True, slots=True)
class MusicReference:
    """beat(t) = (t - first_beat_s) · bpm / 60, from 0; times count from the first kept frame."""

    first_beat_s: float
    """Time of the first beat of the first measure [s]; not negative."""
    bpm: float
    """Tempo [beats per minute]."""
    confidence: float
    """0 to 1. For claps: 1 would be a clap within a millisecond of every beat of a long count, 0.5 is usable, below 0.3
    the claps contradict each other. An estimate from the feet is at most 0.6, because no music was heard. Manual: 1."""
    source: ReferenceSource
    """Origin: a manual anchor, claps to a click, claps alone, claps to a song, or the feet."""
    note: str
    """One line for display: the result and its uncertainties."""


def apply_manual(
    reference: MusicReference | None, *, anchor_s: float | None = None, bpm: float | None = None
) -> MusicReference | None:
    """Return the detected reference with manual values, which always take precedence.

    An anchor is the first beat of the first measure. A tempo alone keeps the detected first beat; an anchor alone
    needs a detected tempo. None if one of the two remains unknown.
    """
    if anchor_s is None and bpm is None:
        return reference
    if reference is None:
        if anchor_s is None or bpm is None:
            return None
        return MusicReference(anchor_s, bpm, 1.0, "hand", "first beat and tempo set by hand")
    if anchor_s is not None and bpm is not None:
        return MusicReference(anchor_s, bpm, 1.0, "hand", "first beat and tempo set by hand")
    if anchor_s is not None:
        note = f"first beat set by hand; tempo: {reference.note}"
        return replace(reference, first_beat_s=anchor_s, source="hand", note=note)
    assert bpm is not None
    return replace(reference, bpm=bpm, source="hand", note=f"tempo set by hand; first beat: {reference.note}")
