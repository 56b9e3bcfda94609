"""Cues that come back to themselves are found with how soon they do, whatever leads there, and soon enough."""

import time

import pytest

from live.show.patch.cue_cycle_check import cue_loops
from live.show.patch.patch_reader import parse_patch
from tests.show.made_show import PATCH


def loops(cues, within=1e9):
    return list(cue_loops(parse_patch(PATCH + cues, "made.toml"), within))


def cue(name, calls="", **keys):
    said = "".join(f"{key} = {value!r}\n" for key, value in keys.items())
    return f'[[cue]]\nname = "{name}"\n{said}' + (f'calls = [["/dance/cue", "{calls}"]]\n' if calls else "")


@pytest.mark.parametrize(
    ("cues", "beats"),
    [
        (cue("a", "b") + cue("b", "a"), 8.0),
        (cue("a", "b", when="beat") + cue("b", "A", when="beat"), 2.0),
        (cue("a", "b", when="now", count_in=3.0) + cue("b", "a", when="now"), 3.0),
        (cue("a", then="auto", after=2) + cue("b", then="auto") + cue("c", "a", when="now"), 16.0),
        (cue("a", "b", number=7.5) + cue("b", "7.5"), 8.0),
        (cue("a", "b") + cue("b", "c") + cue("c"), None),
        (cue("a", then="auto") + cue("b", then="auto"), None),
    ],
)
def test_a_loop_has_the_beats_of_all_that_is_waited_for(cues, beats):
    found = loops(cues)
    assert [loop.min_beats for loop in found] == ([] if beats is None else [beats])
    if beats is not None:
        assert loops(cues, within=beats - 0.5) == []


def test_a_signal_leads_on_to_what_reacts_to_it():
    signal = '[[signal]]\nname = "s"\n[[react]]\non = "S"\nwhen = "beat"\ncall = "/dance/cue"\nvalues = ["a"]\n'
    (loop,) = loops(signal + '[[cue]]\nname = "a"\nwhen = "now"\ncalls = [["/dance/spread"], ["/dance/signal", "s"]]\n')
    assert (loop.min_beats, loop.direct, loop.key_path) == (1.0, False, ("cue", 0, "calls", 1))


def test_two_thousand_cues_that_call_one_another_are_looked_through_at_once():
    patch = parse_patch(PATCH + "".join(cue(f"c{n}", f"c{(n + 1) % 2000}") for n in range(2000)), "made.toml")
    began = time.process_time()
    assert [loop.min_beats for loop in cue_loops(patch)] == [8000.0]
    assert time.process_time() - began < 2.0
