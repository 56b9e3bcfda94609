"""Curves of the score: values that run over measures, tied to parameters and signals."""

from pathlib import Path

import numpy as np
import pytest

from live.base.errors import PersonError
from live.base.motion_parameters import LARGER
from live.clock.ticks import TICK
from live.show.loader import load_from_patch
from live.show.patch.patch_reader import parse_patch
from live.show.patch.section_score import CurveSection
from live.show.show import Show
from live.show.state.snapshot import SnapshotError, restore, snapshot

HEAD = """name = "x"
reserve = 0
[clock]
bpm = 120
[[group]]
name = "a"
dancers = 2
steps = ["groove"]
"""
CURVE = '[[curve]]\nname = "Swell"\nmeasure = 2\npoints = [[0, 0.2], [2, 1.0], [3.5, 0.0]]\n'
REACT = '[[react]]\nto = "curve:swell"\nsets = "larger"\nlow = 0.0\nhigh = 0.4\n'


def wanted(beats: float) -> float:
    """Return the curve's value so many danced beats after the start, by hand."""
    return float(np.interp(beats / 4 - 1, [0, 2, 3.5], [0.2, 1.0, 0.0]))


def start(text: str) -> Show:
    return load_from_patch(parse_patch(text, "x"), Path("x.toml")).start()


def run(show: Show, begin: float, end: float) -> list[tuple[float, float]]:
    """Run to `end` [s]; return danced beats and the motion's size at each tick."""
    rows = []
    for tick in range(int(begin / TICK) + 1, int(end / TICK) + 1):
        show.tick(tick * TICK)
        rows.append((show.danced_beats, float(show.variation[LARGER][0])))
    return rows


def test_a_parameter_follows_a_curve_four_times_a_beat() -> None:
    rows = run(start(HEAD + CURVE + REACT), 0.0, 8.8)
    inside = [(beat, size) for beat, size in rows if 4.1 < beat < 17.0]
    assert len(inside) > 300
    late = [abs(size - 0.4 * wanted(np.floor(beat * 4) / 4)) for beat, size in inside]
    assert np.median(late) < 1e-6
    assert max(late) < 0.4 * 0.4 / 4 / 4 * 1.5 + 0.02  # a tick after each value
    assert {size for beat, size in rows if beat < 3.9} == {rows[0][1]}  # not before it begins


@pytest.mark.long
def test_a_signal_is_given_when_the_curve_rises_to_its_level() -> None:
    signal = '[[signal]]\nname = "peak"\ncurve = "swell"\nlevel = 0.8\n'
    call = '[[react]]\non = "peak"\nwhen = "now"\ncall = "/dance/motion/larger"\nvalues = [0.5]\n'
    rows = run(start(HEAD + CURVE + signal + call), 0.0, 8.8)
    first = next(beat for beat, size in rows if size == 0.5)
    assert first == pytest.approx(4 * (1 + 1.5), abs=0.15)  # 0.8 lies one and a half measures after its beginning
    assert start(HEAD + CURVE + signal).score_runner.signals == {}


@pytest.mark.long
def test_a_smoothed_curve_and_one_in_a_repeated_section() -> None:
    smooth = run(start(HEAD + CURVE + REACT + "beats = 2\n"), 0.0, 6.0)
    exact = run(start(HEAD + CURVE + REACT), 0.0, 6.0)
    behind = [b - a for (beat, a), (_, b) in zip(smooth, exact, strict=True) if 6.0 < beat < 11.0]
    assert min(behind) > 0.01
    section = '[[section]]\nname = "v"\nmeasures = 2\nrepeat = 3\n'
    again = '[[curve]]\nname = "swell"\nsection = "v"\npoints = [[0, 0.0], [2, 1.0]]\n'
    rows = run(start(HEAD + section + again + REACT), 0.0, 11.5)
    for beat, size in rows:
        if beat % 8 > 0.2:
            assert size == pytest.approx(0.4 * np.floor(beat % 8 * 4) / 32, abs=0.03)


def test_a_snapshot_in_the_middle_of_a_curve_continues_bit_by_bit() -> None:
    loaded = load_from_patch(parse_patch(HEAD + CURVE + REACT, "x"), Path("x.toml"))
    show = loaded.start()
    run(show, 0.0, 5.0)
    tick = round(show.time / TICK)
    for _ in range(64):
        try:
            data = snapshot(show)
            break
        except SnapshotError:
            tick += 1
            show.tick(tick * TICK)
    other = restore(loaded, data)
    for later in range(tick + 1, tick + 200):
        show.tick(later * TICK)
        other.tick(later * TICK)
    assert other.state_hash() == show.state_hash()


def test_values_of_a_curve() -> None:
    curve = CurveSection(name="x", points=((0.5, 0.0), (1.0, 1.0), (1.0, 0.5), (2.0, 0.5)))
    found = [curve.value_at(x) for x in (0.4, 0.5, 0.75, 1.0, 1.5, 2.0, 2.1)]
    assert found == [None, 0.0, 0.5, 0.5, 0.5, 0.5, None]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (REACT, "line 10: react.1.to: no curve is called 'swell'; there are: none: write [[curve]]"),
        (CURVE + REACT.replace("swell", "swirl"), "there are: Swell"),
        (CURVE + '[[signal]]\nname = "p"\ncurve = "no"\n', "signal.1.curve: no curve is called 'no'"),
        (CURVE + '[[signal]]\nname = "p"\ncurve = "swell"\non = "drop"\n', "on and curve: leave one out"),
        (CURVE.replace("[2, 1.0]", "[9, 1.0]"), "3.5 after 9: the points of a curve go forward"),
        (CURVE.replace("[2, 1.0]", "[2, 1.5]"), "curve.1.points.2.2"),
        (CURVE.replace("measure = 2", 'measure = 2\nsection = "no"'), "curve.1.section: no section is called 'no'"),
        (CURVE + REACT.replace("curve:swell", "loudnes"), "react.1.to"),
    ],
)
def test_faulty_curves_are_refused_at_their_place(text: str, words: str) -> None:
    with pytest.raises(PersonError) as caught:
        parse_patch(HEAD + text, "x")
    assert words in str(caught.value)
