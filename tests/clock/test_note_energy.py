"""Note energy against closed formulas over the note strokes."""

import math

import numpy as np
import pytest

from live.clock.note_energy import DENSITY_WINDOW, ENERGY_HALF_LIFE, REPORT_INTERVAL, NoteEnergy, NoteFigures


def play_notes(notes: list[tuple[float, tuple[int, ...]]], end: float, *, tempo: float = 120.0) -> list[NoteFigures]:
    """All reports, polled every 10 ms."""
    found, energy, now = [], NoteEnergy(tempo=tempo), 0.0
    waiting = sorted(notes)
    while now < end:
        now += 0.01
        while waiting and waiting[0][0] <= now:
            time, message = waiting.pop(0)
            energy.receive(message, time)
        reports = energy.advance(now)
        if reports is not None:
            found.append(reports)
    return found


@pytest.mark.parametrize("tempo", [60.0, 120.0, 173.0])
def test_energy_and_density_match_closed_formulas(tempo: float) -> None:
    rng = np.random.default_rng(4)
    times = np.cumsum(rng.uniform(0.04, 0.5, 40))
    velocities = rng.integers(1, 128, 40)
    keys = rng.integers(30, 90, 40)
    notes = [(float(t), (0x90, int(k), int(v))) for t, v, k in zip(times, velocities, keys, strict=True)]
    reports = play_notes(notes, float(times[-1]) + 1.0, tempo=tempo)
    assert len(reports) > 60
    for figures in reports:
        beats = (figures.time - times[times <= figures.time]) * tempo / 60.0
        shares = velocities[: len(beats)] / 127.0
        assert figures.energy == pytest.approx(max(shares * 0.5 ** (beats / ENERGY_HALF_LIFE), default=0.0), abs=1e-9)
        assert figures.density == pytest.approx(sum(np.exp(-beats / DENSITY_WINDOW)) / DENSITY_WINDOW, abs=1e-9)
        assert figures.chord == len(set(keys[: len(beats)].tolist()))
    assert np.diff([figures.time for figures in reports]).min() >= REPORT_INTERVAL - 1e-9
    assert sum(figures.beats for figures in reports) == pytest.approx(reports[-1].time * tempo / 60.0)


def test_chord_counts_as_one_stroke_in_density() -> None:
    eighths = [(0.25 * i, (0x90, key, 80)) for i in range(120) for key in (60, 64, 67)]
    last = play_notes(eighths, 30.0)[-1]
    assert last.density == pytest.approx(2.0, rel=0.15)  # between strokes it falls by an eighth
    assert last.chord == 3


def test_energy_decays_to_zero_and_reports_end() -> None:
    reports = play_notes([(1.0, (0x90, 60, 127)), (1.5, (0x80, 60, 0))], 60.0)
    last = reports[-1]
    assert (last.energy, last.density, last.chord) == (0.0, 0.0, 0)
    assert last.time < 1.0 + 0.5 * DENSITY_WINDOW * math.log(1.0 / DENSITY_WINDOW / 0.01) + 0.2
    assert len(reports) < 150


def test_sounding_notes_include_pedal_and_resets() -> None:
    def chord(*messages: tuple[int, ...]) -> tuple[int, float]:
        energy = NoteEnergy()
        energy.receive((0x90, 60, 9), 0.0)
        energy.receive((0x91, 60, 9), 0.0)
        for message in messages:
            energy.receive(message, 0.5)
        reports = energy.advance(1.0)
        assert reports is not None
        return reports.chord, reports.pitch

    assert chord()[0] == 2
    assert chord((0x80, 60, 0))[0] == chord((0x90, 60, 0))[0] == 1
    assert chord((0xB0, 64, 127), (0x80, 60, 0))[0] == 2
    assert chord((0xB0, 64, 127), (0x80, 60, 0), (0xB0, 64, 0))[0] == 1
    assert chord((0xB1, 123, 0))[0] == 1
    assert chord((0xB0, 64, 127), (0x80, 60, 0), (0xB0, 120, 0))[0] == 1
    assert chord((0xFF,))[0] == 0
    assert chord((0x90, 108, 9), (0x80, 60, 0), (0x81, 60, 0)) == (1, 1.0)
    assert chord((0x90, 21, 9), (0x80, 60, 0), (0x81, 60, 0)) == (1, 0.0)


def test_random_bytes_give_finite_figures() -> None:
    energy = NoteEnergy()
    rng = np.random.default_rng(9)
    for message in rng.integers(0, 256, (2000, 3)).tolist():
        energy.receive(tuple(message[: rng.integers(0, 4)]), 1.0)
    reports = energy.advance(2.0)
    assert reports is not None
    assert all(math.isfinite(value) for value in (reports.energy, reports.density, reports.pitch))
    assert reports.chord <= 2000
