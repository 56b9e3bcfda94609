"""MIDI files made for tests."""

from pathlib import Path

import mido


def write_song(path: Path, *, bars: int = 8) -> Path:
    """A waltz that speeds up by half in its second half, then a chord; ticks of 96, two tracks, a late control."""
    file = mido.MidiFile(ticks_per_beat=96)
    beats = bars * 4
    tempo = mido.MidiTrack([
        mido.MetaMessage("set_tempo", tempo=600_000),
        mido.MetaMessage("time_signature", numerator=4, denominator=4),
        mido.MetaMessage("set_tempo", tempo=400_000, time=96 * beats // 2),
    ])  # fmt: skip
    notes = mido.MidiTrack()
    for beat in range(beats):
        for key in (48, 60 + beat % 12):
            notes.append(mido.Message("note_on", note=key, velocity=40 + beat))
        notes.append(mido.Message("note_off", note=48, time=48))
        notes.append(mido.Message("note_off", note=60 + beat % 12, time=48))
    notes.append(mido.Message("control_change", control=7, value=127))
    file.tracks += [tempo, notes]
    file.save(path)
    return path
