"""Signals, calls at beats and jumps in a running show: their effects and ticks."""

import pytest

from live.base.errors import PersonError
from live.clock.ticks import TICK
from live.control.events import events
from live.control.events.events import MusicHeard
from live.show.score.music_reactions import Reactions
from live.show.score.score_runner import ScoreRunner
from tests.fixtures.mostly_long import mostly_long
from tests.show.made_show import PATCH, made_show


def run(show, seconds, *, at=None, seen=None):
    """Runs ticks; `at`: events by tick; `seen(tick)` is called after every tick."""
    first = round(show.time / TICK) + 1
    for tick in range(first, first + round(64 * seconds)):
        if at and tick in at:
            show.apply(at[tick](tick * TICK))
        show.tick(tick * TICK)
        if seen:
            seen(tick)
    return show


def record_events(show, monkeypatch):
    """Records the applied events as (tick, event), including those of the score and of reactions."""
    acted = []
    router = show.frame.router
    act = router.handle
    monkeypatch.setattr(router, "handle", lambda event: (acted.append((round(show.time / TICK), event)), act(event))[1])
    return acted


def test_calls_act_at_the_tick_of_their_beat(monkeypatch):
    """At 120 bpm a beat is 32 ticks, and the measure 128."""
    calls = "".join(
        f'[[at]]\nmeasure = {measure}\nbeat = {beat}\ncall = "/dance/motion/larger"\nvalues = [0.1]\n'
        for measure, beat in ((2, 1.0), (2, 2.5), (2, 4.99), (3, 1.0))
    )
    show = made_show(calls)
    acted = record_events(show, monkeypatch)
    run(show, 6)
    assert [tick for tick, event in acted if isinstance(event, events.SetParameter)] == [128, 176, 256, 256]
    figures = show.score_runner.beat_scheduler.counters()
    assert (figures["fired"], figures["late_ticks_max"], figures["waiting"]) == (4, 0, 0)


def test_score_signal_triggers_reactions_now_at_beat_or_measure(monkeypatch):
    reacts = "".join(
        f'[[react]]\non = "Hit"\nwhen = "{when}"\ncall = "/dance/attract"\nvalues = [{n}, 0]\n'
        for n, when in enumerate(("now", "beat", "measure"))
    )
    show = made_show('[[signal]]\nname = "hit"\nmeasure = 1\nbeat = 2.5\n' + reacts)
    acted = record_events(show, monkeypatch)
    run(show, 3)
    assert [(tick, event.points[0][0]) for tick, event in acted if isinstance(event, events.PlaceElement)] == [
        (48, 0.0), (64, 1.0), (128, 2.0),
    ]  # fmt: skip
    assert show.score_runner.signals == {"hit": 1}


def test_signals_come_from_operator_score_and_music():
    show = made_show(
        '[[signal]]\nname = "big"\non = "loud"\nlevel = 0.8\n[[at]]\nmeasure = 1\nbeat = 3.0\nsignal = "big"\n'
        '[[react]]\non = "big"\nwhen = "now"\ncall = "/dance/spread"\n'
    )
    by_hand = {10: lambda time: events.Signal(time=time, source="osc", name="BIG")}
    run(show, 1.5, at=by_hand)
    assert show.score_runner.signals["big"] == 2
    for loud in (0.5, 0.85, 0.9, 0.75, 0.85, 0.6, 0.85):  # it counts again once it has been left by a tenth
        show.apply(
            MusicHeard(
                time=show.time, source="audio", beat_time=show.time, loudness=loud, density=3.0, brightness=0.5,
                low=0.5, build=0.0, drop=False,
            )
        )  # fmt: skip
    assert show.score_runner.signals["big"] == 4
    run(show, 0.1)
    assert show.score_runner.beat_scheduler.fired == 1 + 4


def test_unknown_signal_is_refused_and_counted():
    show = made_show()
    assert not show.apply(events.Signal(time=0.0, source="osc", name="hit"))
    assert show.refusals.count == 1
    assert "no signal is called 'hit'" in show.refusals.last_reason
    assert show.apply(events.Signal(time=0.0, source="osc", name="drop"))


def test_signal_reaction_jumps_to_another_section():
    show = made_show(
        '[[section]]\nname = "a"\nmeasures = 4\n[[section]]\nname = "b"\nmeasures = 2\nthen = "end"\n'
        '[[at]]\nsection = "a"\nmeasure = 2\nbeat = 2.0\nsignal = "now"\n'
        '[[react]]\non = "now"\nwhen = "now"\ncall = "/dance/section"\nvalues = ["b"]\n'
    )
    places = {}
    run(show, 11, seen=lambda tick: places.setdefault(show.span.number, show.score_runner.facts()["section"]))
    assert list(places.values()) == ["a", "a", "b", "b", None, None]


@pytest.mark.long
def test_jump_ends_score_elements_and_keeps_live_elements():
    show = made_show(
        '[[section]]\nname = "a"\nmeasures = 8\n[[section]]\nname = "b"\nmeasures = 8\n'
        '[[element]]\nkind = "spread"\nsection = "a"\nmeasure = 2\nmeasures = 6\n'
    )
    at = {
        200: lambda time: events.PlaceElement(
            time=time, source="osc", kind="attract", points=((1.0, 1.0),), measures=20.0
        ),
        300: lambda time: events.JumpTo(time=time, source="osc", section="b"),
    }
    run(show, 5.9, at=at)
    assert {element.source for element in show.motion.elements.in_force} == {"score", "osc"}
    run(show, 3.0)
    assert {element.source for element in show.motion.elements.in_force} == {"osc"}


@mostly_long("beat", [4.2, 6.1, 6.6, 7.6], quick=[2])
def test_jump_removes_entries_placed_for_next_measure(beat):
    """Elements and segments of measure 3 of `a` exist from beat 6.25 on; the jump to `b` removes them."""
    show = made_show(
        '[[section]]\nname = "a"\nmeasures = 8\n[[section]]\nname = "b"\nmeasures = 8\n'
        '[[element]]\nkind = "spread"\nsection = "a"\nmeasure = 3\nmeasures = 6\n'
        '[[segment]]\nsection = "a"\nmeasure = 3\nformation = "line"\n'
        '[[segment]]\nsection = "b"\nmeasure = 1\nformation = "circle"\n'
    )
    jump = {round(32 * beat): lambda time: events.JumpTo(time=time, source="osc", section="b")}
    run(show, 5, at=jump)
    assert not show.motion.elements.in_force
    assert [motion.intention.formation for motion in show.motion.evolutions._plan.motions] == ["circle"]


def test_invalid_jumps_are_refused_without_effect():
    show, plain = made_show(), made_show()
    for event in (
        events.JumpTo(time=0.0, source="osc", section="coda"),
        events.JumpTo(time=0.0, source="osc", section="coda", when="soon"),
        events.Advance(time=0.0, source="osc", when="never"),
        events.Practice(time=0.0, source="osc", first=9, last=3),
        events.Practice(time=0.0, source="osc", first=0, last=3),
        events.Improvise(time=0.0, source="osc", on=True, group="choir"),
    ):
        assert not show.apply(event)
    assert show.refusals.count == 6
    run(show, 3)
    run(plain, 3)
    assert show.state_hash() == plain.state_hash()


@pytest.mark.long
def test_practice_loops_until_it_is_ended():
    show = made_show("loop_measures = 8\n", top=True)
    at = {
        10: lambda time: events.Practice(time=time, source="osc", first=3, last=4),
        64 * 11: lambda time: events.Practice(time=time, source="osc", first=0, last=0),
    }
    places = {}
    run(
        show,
        15,
        at=at,
        seen=lambda tick: places.setdefault(show.span.number, show.score_runner.facts()["section_measure"]),
    )
    assert list(places.values()) == [1, 3, 4, 3, 4, 3, 4, 5]


def test_endless_signals_are_limited_per_tick():
    """A patch loop is reported at load; here events create one: the scheduler fires a bounded number per tick."""
    from live.show.patch.patch_reader import parse_patch

    patch = parse_patch(PATCH, "x")
    prompter = ScoreRunner(patch, Reactions(patch), seed=1)
    for _ in range(3000):
        prompter.beat_scheduler.schedule(0.0, events.Signal(time=0.0, source="score", name="drop"))
    assert len(prompter.beat_scheduler.fire(0.0)) < 3000
    with pytest.raises(PersonError, match="the patch has none"):
        prompter.section_index("x")


@pytest.mark.long
def test_overlay_shows_score_position_and_waiting():
    assert made_show().score_runner.status_lines() == ()
    show = made_show(
        '[[section]]\nname = "a"\nmeasures = 2\nrepeat = 2\n[[section]]\nname = "b"\nmeasures = 2\nwait = true\n'
    )
    assert show.score_runner.status_lines() == ("a: measure 1 of 2, pass 1 of 2",)
    show.apply(events.JumpTo(time=0.0, source="osc", section="b", when="section", measure=2))
    assert show.score_runner.status_lines() == ("a: measure 1 of 2, pass 1 of 2, goes to b 2 at the section's end",)
    show.apply(events.HoldScore(time=0.0, source="osc", on=True))
    run(show, 2.1)
    assert show.score_runner.status_lines()[0].startswith("a: measure 1 of 2, pass 1 of 2, held, goes to b")
    show.apply(events.HoldScore(time=0.0, source="osc", on=False))
    run(show, 4.0)
    assert show.score_runner.status_lines() == ("b: measure 2 of 2, waits for GO",)
