"""The `score` patch of the project: from the score to improvisation and back, as its comments state."""

from itertools import groupby

from live.clock.ticks import TICK
from live.control.events import events
from live.control.events.events import MusicHeard
from live.show.loader import load_show
from live.show.patch.patch_search_path import find_patch


def test_show_switches_from_score_to_improvisation_and_back():
    show = load_show(find_patch("score")).start()
    library, tick = show.graph.library, 0
    sections, asked, danced = [], [], []
    said = {
        2: events.JumpTo(time=0.0, source="osc", section="solo", when="section"),
        15: events.Advance(time=0.0, source="osc", when="measure"),
    }
    while show.span.number < 21:
        tick += 1
        if tick % 34 == 0:  # loud music: energy 0.9
            show.apply(
                MusicHeard(
                    time=tick * TICK, source="audio", beat_time=tick * TICK, loudness=0.9, density=5.4, brightness=0.5,
                    low=0.5, build=0.0, drop=False,
                )
            )  # fmt: skip
        if not show.tick(tick * TICK):
            continue
        facts = show.score_runner.facts()
        sections.append(facts["section"])
        programme = show.scheduler.programmes[0]
        asked.append(library.steps[programme.step_for(show.span.number, show.dancers.node[:0])])
        names = [library.steps[library.node_step[node]] for node in show.dancers.node[show.group == 0]]
        danced.append(max(set(names), key=names.count))
        if show.span.number in said:
            show.apply(said[show.span.number])
    assert [section for section, _ in groupby(sections)] == ["intro", "solo", "coda", None]
    solo = [step for step, section in zip(asked, sections, strict=True) if section == "solo"]
    assert len(solo) == 12
    assert max(len(list(same)) for _, same in groupby(solo)) <= 2
    assert "body roll" not in solo  # which loud music forbids
    assert asked[sections.index(None) - 1] == "bow"
    others = [(one, other) for one, other in zip(asked, danced, strict=True) if other not in (one, "walk")]
    assert not others  # what is danced is what was asked for, or the travel step where a formation is far
    assert show.refusals.count == 0
    assert show.score_runner.beat_scheduler.late_ticks_max <= 1
