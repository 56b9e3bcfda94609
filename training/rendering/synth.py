"""FluidSynth through its C library: fonts stay loaded in the process, each piece gets a fresh synthesiser.

Rendering is exact: same notes, same font, same library: same bytes. Reverberation and chorus are off (the rooms
are ours), the output is float, so that no dither is added. Notes start on blocks of 64 samples (1.5 ms).
"""

import ctypes
import ctypes.util
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import numpy as np
import numpy.typing as npt

from training.music.piece import Sounding
from training.rendering.tone import Control

RATE = 44100
FOLDERS = (Path("/usr/share/sounds/sf2"), Path("/usr/share/sounds/sf3"))
FONTS = {
    "FluidR3_GM.sf2": 4.0, "TimGM6mb.sf2": 3.0, "OPL-3_FM_128M.sf2": 0.7, "MuseScore_General_Full.sf3": 2.3,
}  # fmt: skip
"""Fonts of Debian's packages and how often each is drawn."""

LATENCY = {"OPL-3_FM_128M.sf2": 0.006}
"""Seconds from a note's time to the attack of a percussive sample beyond which one hears it, by font (else 2.5 ms)."""

Mono = npt.NDArray[np.float32]


def fonts() -> dict[str, Path]:
    """The fonts that this machine has."""
    return {name: folder / name for name in FONTS for folder in FOLDERS if (folder / name).is_file()}


def available() -> str | None:
    """Why nothing can be rendered here; None where it can."""
    if ctypes.util.find_library("fluidsynth") is None:
        return "FluidSynth's library is not installed (apt: fluidsynth)"
    return None if fonts() else "none of the fonts is installed (apt: timgm6mb-soundfont fluid-soundfont-gm)"


@cache
def _library() -> ctypes.CDLL:
    name = ctypes.util.find_library("fluidsynth")
    if name is None:
        raise RuntimeError(available())
    library = ctypes.CDLL(name)
    handle, text, number = ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int
    library.fluid_set_log_function.argtypes = [number, handle, handle]
    for level in (1, 2):  # errors are returned anyhow; some fonts lack some kits, and the standard kit is taken
        library.fluid_set_log_function(level, None, None)
    library.new_fluid_settings.restype = handle
    library.new_fluid_synth.restype = handle
    library.new_fluid_synth.argtypes = [handle]
    library.delete_fluid_synth.argtypes = [handle]
    library.fluid_settings_setnum.argtypes = [handle, text, ctypes.c_double]
    library.fluid_settings_setint.argtypes = [handle, text, number]
    library.fluid_synth_sfload.argtypes = [handle, text, number]
    library.fluid_synth_noteon.argtypes = [handle, number, number, number]
    library.fluid_synth_cc.argtypes = [handle, number, number, number]
    library.fluid_synth_set_gen.argtypes = [handle, number, number, ctypes.c_float]
    library.fluid_synth_set_interp_method.argtypes = [handle, number, number]
    library.fluid_synth_noteoff.argtypes = [handle, number, number]
    library.fluid_synth_program_change.argtypes = [handle, number, number]
    library.fluid_synth_write_float.argtypes = [handle, number, handle, number, number, handle, number, number]
    return library


@cache
def _settings() -> int:
    library = _library()
    settings = library.new_fluid_settings()
    library.fluid_settings_setnum(settings, b"synth.sample-rate", float(RATE))
    library.fluid_settings_setnum(settings, b"synth.gain", 0.35)
    for name, value in ((b"synth.reverb.active", 0), (b"synth.chorus.active", 0), (b"synth.polyphony", 200)):
        library.fluid_settings_setint(settings, name, value)
    return int(settings)


@cache
def _keep(font: Path) -> int:
    """A synthesiser that only holds the font's samples in memory for those that come after it."""
    return _open(font)


def _open(font: Path) -> int:
    library = _library()
    synth = int(library.new_fluid_synth(_settings()))
    library.fluid_synth_set_interp_method(synth, -1, 1)  # linear: half the time of the default, nobody hears it here
    if library.fluid_synth_sfload(synth, str(font).encode(), 1) < 0:
        raise RuntimeError(f"FluidSynth cannot read {font}")
    return synth


def synthesise(
    notes: list[Sounding], programs: list[tuple[int, int]], font: Path, seconds: float, controls: Sequence[Control] = ()
) -> Mono:
    """The notes as sound, mono float32 at 44.1 kHz from second 0 on; note times are those of the attacks."""
    library = _library()
    _keep(font)
    synth = _open(font)
    count = int(seconds * RATE)
    sound = np.zeros((2, count), np.float32)
    left, right = sound[0].ctypes.data, sound[1].ctypes.data
    try:
        for channel, program in programs:
            library.fluid_synth_program_change(synth, channel, program)
        for control in controls:
            if control.kind == "cc":
                library.fluid_synth_cc(synth, control.channel, control.number, int(control.value))
            else:
                library.fluid_synth_set_gen(synth, control.channel, control.number, control.value)
        at = 0
        for sample, on, channel, pitch, velocity in _events(notes, LATENCY.get(font.name, 0.0025)):
            sample = min(sample, count)
            if sample > at:
                library.fluid_synth_write_float(synth, sample - at, left + 4 * at, 0, 1, right + 4 * at, 0, 1)
                at = sample
            if at >= count:
                break
            if on:
                library.fluid_synth_noteon(synth, channel, pitch, velocity)
            else:
                library.fluid_synth_noteoff(synth, channel, pitch)
        if at < count:
            library.fluid_synth_write_float(synth, count - at, left + 4 * at, 0, 1, right + 4 * at, 0, 1)
    finally:
        library.delete_fluid_synth(synth)
    return np.asarray(sound.mean(axis=0), np.float32)


def _events(notes: list[Sounding], latency: float) -> list[tuple[int, int, int, int, int]]:
    """Sample, on (1) or off (0), channel, pitch, velocity in order; offs first. A pitch struck again ends before."""
    events = []
    for note in notes:
        start = max(0, round((note.time - latency) * RATE / 64) * 64)
        end = max(start + 640, round((note.time - latency + note.duration) * RATE / 64) * 64)
        events.append((start, 1, note.channel, note.pitch, note.velocity))
        events.append((end, 0, note.channel, note.pitch, 0))
    return sorted(events)
