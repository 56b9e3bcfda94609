"""Inputs of `live simulate` and `live sim`: scenarios, and the simulated band as sound or as MIDI clock."""

from pathlib import Path
from typing import Any

import typer

from live.agents.scenarios.generate import SCENARIOS
from live.agents.scenarios.reading import MAX_BYTES, read_scenario, unknown_fields
from live.agents.scenarios.scenario import Scenario
from live.base.errors import PersonError
from live.control.midi.midi_ports import UnknownPort, open_port
from live.control.midi.midi_system import MidiUnavailable
from live.rehearse.simulated_band import DRIFT, Irregularities, SimulatedBand, render_audio, write_sound


def load_scenario(path: Path, seed: int = 0) -> Scenario:
    """Return the scenario in a file, or the built-in one of that name; raise PersonError if there is neither."""
    if str(path) in SCENARIOS and not path.exists():
        return SCENARIOS[str(path)](seed)
    try:
        if path.is_file() and path.stat().st_size > MAX_BYTES:
            raise PersonError(f"{path}: larger than {MAX_BYTES:,} bytes", "give a smaller scenario")
        text = path.read_bytes()
    except OSError as error:
        remedy = f"give a scenario (JSON), or one of {', '.join(SCENARIOS)}"
        raise PersonError(f"{path}: cannot be read: {error.strerror}", remedy) from None
    scenario = read_scenario(text, str(path))
    for name in unknown_fields(text):
        typer.echo(f"{path}: unknown key {name!r} ignored", err=True)
    return scenario


def make_band(seed: int, bpm: float, beats: int, irregularity: float) -> SimulatedBand:
    """Return a band whose irregularities are `irregularity` times as frequent as usual (0: none)."""
    usual = Irregularities()
    manners = Irregularities(
        stop=usual.stop * irregularity,
        fill=min(usual.fill * irregularity, 1.0),
        wrong_downbeat=usual.wrong_downbeat * irregularity,
        tempo_jump=usual.tempo_jump * irregularity,
        drift=DRIFT * min(irregularity, 4.0),
    )
    return SimulatedBand(seed, bpm=bpm, beats_per_measure=beats, irregularities=manners)


def write_band_audio(path: Path, band: SimulatedBand, seconds: float, seed: int, console: Any) -> None:
    """Write the band as a sound file; raise PersonError if that fails."""
    if seconds > 7200.0:
        raise PersonError(f"--seconds {seconds:g}: a sound file has at most two hours", "--seconds 600")
    try:
        write_sound(path, render_audio(band, seconds, seed=seed))
    except OSError as error:
        raise PersonError(f"cannot write --audio {path}: {error.strerror}") from None
    did = ", ".join(f"{count} × {what}" for what, count in band.counts.items() if count) or "no irregularities"
    console.print(f"band written: {path.resolve()} ({did})", soft_wrap=True, markup=False)


def open_midi_output(name: str) -> Any:
    """Open a MIDI output by name; raise PersonError if there is none."""
    try:
        return open_port("output", name)
    except (MidiUnavailable, UnknownPort) as error:
        raise PersonError(f"--midi {name!r}: {error}", "see `live devices`") from None
