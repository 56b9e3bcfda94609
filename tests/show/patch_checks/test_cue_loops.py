"""Detection of cue loops: shortest period in beats, indirect calls by signals, and speed."""

import time

import pytest

from live.show.patch.patch_reader import parse_patch
from live.show.patch_checks.cue_cycle_check import cue_loops
from tests.show.made_show import PATCH


def find_loops(cues, within=1e9):
    return list(cue_loops(parse_patch(PATCH + cues, "made.toml"), within))


def cue_toml(name, calls="", **keys):
    said = "".join(f"{key} = {value!r}\n" for key, value in keys.items())
    return f'[[cue]]\nname = "{name}"\n{said}' + (f'calls = [["/dance/cue", "{calls}"]]\n' if calls else "")


@pytest.mark.parametrize(
    ("cues", "beats"),
    [
        (cue_toml("a", "b") + cue_toml("b", "a"), 8.0),
        (cue_toml("a", "b", when="beat") + cue_toml("b", "A", when="beat"), 2.0),
        (cue_toml("a", "b", when="now", count_in=3.0) + cue_toml("b", "a", when="now"), 3.0),
        (cue_toml("a", then="auto", after=2) + cue_toml("b", then="auto") + cue_toml("c", "a", when="now"), 16.0),
        (cue_toml("a", "b", number=7.5) + cue_toml("b", "7.5"), 8.0),
        (cue_toml("a", "b") + cue_toml("b", "c") + cue_toml("c"), None),
        (cue_toml("a", then="auto") + cue_toml("b", then="auto"), None),
    ],
)
def test_loop_period_is_sum_of_waiting_times(cues, beats):
    found = find_loops(cues)
    assert [loop.min_beats for loop in found] == ([] if beats is None else [beats])
    if beats is not None:
        assert find_loops(cues, within=beats - 0.5) == []


def test_loop_is_followed_through_signals_and_reactions():
    signal = '[[signal]]\nname = "s"\n[[react]]\non = "S"\nwhen = "beat"\ncall = "/dance/cue"\nvalues = ["a"]\n'
    (loop,) = find_loops(
        signal + '[[cue]]\nname = "a"\nwhen = "now"\ncalls = [["/dance/spread"], ["/dance/signal", "s"]]\n'
    )
    assert (loop.min_beats, loop.direct, loop.key_path) == (1.0, False, ("cue", 0, "calls", 1))


def test_two_thousand_chained_cues_are_checked_within_two_seconds():
    patch = parse_patch(PATCH + "".join(cue_toml(f"c{n}", f"c{(n + 1) % 2000}") for n in range(2000)), "made.toml")
    began = time.process_time()
    assert [loop.min_beats for loop in cue_loops(patch)] == [8000.0]
    assert time.process_time() - began < 2.0
