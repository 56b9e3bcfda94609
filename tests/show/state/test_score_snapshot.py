"""A show with sections, sequences, improvisation and calls continues identically from a snapshot at any tick."""

from pathlib import Path

from live.clock.ticks import TICK
from live.control.events import events
from live.show.loader import LoadedShow
from live.show.patch.patch_reader import parse_patch
from live.show.state.snapshot import restore
from tests.fixtures.mostly_long import mostly_long
from tests.show.made_show import GRAPH, PATCH
from tests.show.state.test_snapshot import capture_from, run

SCORE = (
    '[[section]]\nname = "a"\nmeasures = 2\nrepeat = 2\n[[section]]\nname = "b"\nmeasures = 3\nwait = true\n'
    '[[sequence]]\nsection = "a"\nmeasures = 2\nsteps = ["phrase"]\n[[improvise]]\nsection = "b"\nphrase = 1\n'
    'group = "front"\nmotion = [{call = "/dance/spread", values = [1]}, {}]\n'
    '[[improvise]]\nsection = "b"\ngroup = "back"\nphrase = 1\nanswers = "front"\nlistening = "sway"\n'
    '[[at]]\nsection = "a"\nmeasure = 2\nbeat = 3.5\nsignal = "hit"\n'
    '[[react]]\non = "hit"\nwhen = "beat"\ncall = "/dance/attract"\nvalues = [1, 1, 1, 2]\n'
)
LOADED = LoadedShow(Path("test.toml"), parse_patch(PATCH + SCORE, "test.toml"), GRAPH)
SCRIPT = {
    300: events.JumpTo(time=4.6, source="osc", section="b", when="section"),
    620: events.Improvise(time=9.6, source="osc", on=True, group="front"),
    700: events.Advance(time=10.9, source="osc"),
    900: events.HoldScore(time=14.0, source="osc", on=True),
}


@mostly_long("tick", [40, 220, 320, 560, 640, 905], quick=[0])
def test_restored_score_continues_bit_identically(tick):
    show = LOADED.start()
    run(show, 1, tick, SCRIPT)
    at, data = capture_from(show, tick, SCRIPT)
    restored = restore(LOADED, data)
    assert restored.score_runner.facts() == show.score_runner.facts()
    assert run(restored, at + 1, at + 300, SCRIPT) == run(show, at + 1, at + 300, SCRIPT)
    assert restored.score_runner.facts() == show.score_runner.facts()
    assert restored.score_runner.beat_scheduler.counters() == show.score_runner.beat_scheduler.counters()


def test_snapshot_leaves_out_the_written_score():
    """A long score makes no larger snapshots: its entries are read from the patch."""
    calls = "".join(
        f'[[at]]\nmeasure = {measure}\nbeat = {beat}\nsignal = "s{measure}"\n'
        f'[[sequence]]\nmeasure = {measure * 4 + beat}\nsteps = ["{step}"]\n'
        for measure in range(10, 260)
        for beat, step in ((1, "sway"), (2, "spin"), (3, "glide"), (4, "sway"))
    )
    long = LoadedShow(Path("test.toml"), parse_patch(PATCH + calls, "test.toml"), GRAPH)
    short = LoadedShow(Path("test.toml"), parse_patch(PATCH, "test.toml"), GRAPH)
    sizes = []
    for loaded in (long, short):
        show = loaded.start()
        show.tick(TICK)
        sizes.append(len(capture_from(show, 1)[1]))
    assert sizes[0] < 1.1 * sizes[1]
