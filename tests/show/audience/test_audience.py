"""Tests of the audience in the show: elements, lights, turns, votes, and operator overrides within one tick."""

from pathlib import Path

import numpy as np
import pytest

from live.base.element_kinds import PARTICIPANT, REPULSOR
from live.base.errors import PersonError
from live.clock.ticks import TICK
from live.control.events import events
from live.control.events.event_json import event_from_json, event_to_row
from live.show.audience.audience import LED_GAIN
from live.show.audience.voting import Vote
from live.show.loader import LoadedShow
from live.show.patch.patch_reader import parse_patch
from live.show.state.snapshot import Snapshotter, restore
from tests.show.made_show import GRAPH, PATCH, made_show

REGIONS = '[audience]\nregions = ["stalls", "balcony"]\nvote_measures = 1\n'
EAST = ((500, 0, 1000, 1),)


class AudienceSession:
    """A show run tick by tick with repeated audience reports."""

    def __init__(self, extra=REGIONS):
        self.show, self.index, self.said = made_show(extra), 0, None

    def send(self, event_type, **values):
        assert self.show.apply(event_type(time=self.show.time, source="osc", **values)), self.show.refusals.last_reason

    def report(self, places=EAST, *, share=1000, **values):
        values = {"phones": 100, "order": self.show.audience.command_count, "share": share, "places": places} | values
        self.show.apply(events.AudienceHeard(time=self.show.time, source="audience", **values))

    def run(self, measures=1.0, **report):
        for _ in range(round(measures * 2.0 / TICK)):
            self.index += 1
            if report and self.index % 8 == 0:
                self.report(**report)
            self.show.tick(self.index * TICK)

    def active_elements(self):
        """Kinds and strengths of the active elements."""
        beat = self.show.timeline.beat_at(self.show.time)
        return {e.table_kind: e.strength for e in self.show.motion.elements.in_force if e.level(beat + 0.5) > 0.0}

    def mean_distance(self, x=5.0, z=0.0):
        """Mean distance of the dancers to a point [m]."""
        return float(np.hypot(*(self.show.state.position - (x, z)).T).mean())


@pytest.mark.long
def test_dancers_approach_gathering_points_and_leave_repulsors():
    coming, going, alone = AudienceSession(), AudienceSession(), AudienceSession()
    coming.run(4, places=EAST)
    going.run(4, places=((0, 0, 1000, 2),))
    alone.run(4)
    assert coming.mean_distance() < alone.mean_distance() - 1.0
    assert going.mean_distance(0.0, 0.0) > alone.mean_distance(0.0, 0.0) + 0.2
    assert set(coming.active_elements()) == {PARTICIPANT}
    assert set(going.active_elements()) == {REPULSOR}
    coming.run(3)  # without reports the element ends
    assert coming.active_elements() == {}


@pytest.mark.long
def test_close_and_mute_act_within_one_tick_and_stale_reports_are_ignored():
    session = AudienceSession()
    session.run(1, places=EAST, lights=((7, 500, 0, 300, 1),))
    stale = session.show.audience.command_count
    session.send(events.MuteAudience, on=True)
    session.run(1 / 128)
    assert session.active_elements() == {}
    assert session.show.audience.facts()["lights"]
    session.send(events.MuteAudience, on=False)
    session.run(1 / 128)
    assert set(session.active_elements()) == {PARTICIPANT}
    session.send(events.OpenAudience, on=False)
    session.run(1 / 128)
    assert session.active_elements() == {}
    assert session.show.audience.facts()["lights"] == []
    session.send(events.OpenAudience, on=True)
    session.report(order=stale)  # made before the operator spoke
    assert session.active_elements() == {}
    session.report()
    assert set(session.active_elements()) == {PARTICIPANT}
    session.send(events.Panic)
    assert session.active_elements() == {}
    assert session.show.audience.muted


def test_operator_gain_and_attractor_override_audience_strength():
    session = AudienceSession()
    session.report()
    assert session.active_elements() == {
        PARTICIPANT: pytest.approx(4.0)
    }  # as many voices as are needed for all of the force
    session.send(events.SetAudienceGain, gain=0.5)
    assert session.active_elements() == {PARTICIPANT: pytest.approx(2.0)}
    session.send(events.PlaceElement, kind="attract", points=((-5.0, 0.0),))
    session.run(0.5, places=EAST)
    assert session.active_elements()[PARTICIPANT] == pytest.approx(2.0 * LED_GAIN)


@pytest.mark.long
def test_moved_places_keep_elements_and_may_change_kind():
    session = AudienceSession()
    session.run(0.5, places=((500, 0, 1000, 1), (-300, 0, 500, 1)))
    session.report(((520, 0, 1000, 1), (0, 0, 0, 1), (100, 100, 400, 2)))
    beat = session.show.timeline.beat_at(session.show.time)
    there = {e.source: (e.x, e.table_kind, e.level(beat) > 0.5) for e in session.show.motion.elements.in_force}
    assert there["audience 1"] == (pytest.approx(5.2), PARTICIPANT, True)  # the element continues without a new fade-in
    assert there["audience 3"][:2] == (1.0, REPULSOR)
    session.report(((520, 0, 1000, 2),))
    session.run(1)
    assert set(session.active_elements()) == {REPULSOR}


def test_lights_follow_phones_and_fade_while_banned_lights_vanish():
    session = AudienceSession()
    session.run(0.5, lights=((7, 500, 0, 300, 1), (8, -500, 100, 600, 2)))
    view = session.show.view()
    session.show.fill(view, session.show.time)
    assert view.light_count == 2
    by_hue = {round(float(row[2]), 1): row for row in view.light[:2]}
    np.testing.assert_allclose(by_hue[0.3], (5.0, 0.0, 0.3, 1.0, 0.0), atol=0.01)
    np.testing.assert_allclose(by_hue[0.6], (-5.0, 1.0, 0.6, 1.0, 1.0), atol=0.01)
    session.report(lights=((7, 400, 0, 300, 1),))
    session.run(1 / 128)
    rows = {row[0]: row[1] for row in session.show.audience.facts()["lights"]}
    assert 4.0 < rows[7] < 5.0
    assert 8 in rows  # still fading
    session.run(1)
    assert [row[0] for row in session.show.audience.facts()["lights"]] == [7]
    session.send(events.BanPhone, number=7)
    session.run(1 / 128)
    assert session.show.audience.facts()["lights"] == []
    session.report(lights=((7, 400, 0, 300, 1),))
    assert session.show.audience.facts()["lights"] == []
    session.send(events.BanPhone, number=0, on=False)
    session.report(lights=((7, 400, 0, 300, 1),))
    assert session.show.audience.facts()["lights"] != []


@pytest.mark.long
def test_turn_begins_and_ends_at_measure_lines():
    session = AudienceSession()
    session.run(0.75)
    measure = session.show.span.number
    session.send(events.GiveTurn, name="Balcony", measures=2.0)
    session.send(events.WeighRegion, name="*", weight=0.5)
    weights = []
    for _ in range(5):
        weights.append(tuple(session.show.audience.region_weights(session.show.span.number)))
        session.run(1)
    assert session.show.span.number == measure + 5
    assert weights == [(0.5, 0.5), (0.0, 0.5), (0.0, 0.5), (0.5, 0.5), (0.5, 0.5)]
    assert session.show.audience.turn is None
    refused = session.show.refusals.count
    for name in ("gallery", "", "stalls, balcony"):
        session.show.apply(events.WeighRegion(time=0.0, source="osc", name=name or "?", weight=1.0))
    assert session.show.refusals.count == refused + 3


def test_vote_winner_is_called_at_measure_line_and_seed_breaks_ties():
    session = AudienceSession()
    session.send(events.AskVote, what="step", first="SPIN", second="sway")
    order = session.show.audience.command_count
    session.report(votes=(1, 100, 250), order=order)
    session.report(votes=(9, 900, 0), order=order)  # of another vote
    session.run(1)
    assert session.show.audience.vote is not None
    session.run(1)
    assert session.show.audience.vote is None
    assert session.show.audience.result == (1, "sway")
    session.run(3)
    library = session.show.graph.library
    danced = {library.steps[library.node_step[node]] for node in session.show.dancers.present.node}
    assert danced == {"sway"}
    session.send(events.AskVote, what="step", first="spin", second="sway")
    session.run(3)
    assert session.show.audience.result == (2, "")  # no votes
    ties = {Vote(number, "step", ("a", "b"), 1, (100, 100)).winner(3) for number in range(1, 30)}
    assert ties == {"a", "b"}
    assert Vote(5, "step", ("a", "b"), 1, (1, 1)).winner(3) == Vote(5, "step", ("a", "b"), 1, (2, 2)).winner(3)
    for values in (
        {"what": "step", "first": "spin", "second": "fly"}, {"what": "dancer", "first": "a", "second": "b"},
        {"what": "step", "first": "spin", "second": "Spin"}, {"what": "scene", "first": "x", "second": "y"},
    ):  # fmt: skip
        assert not session.show.apply(events.AskVote(time=0.0, source="osc", **values))


def test_many_shaken_phones_spread_dancers():
    session = AudienceSession()
    session.run(0.25, places=(), share=0, shaken=200)
    assert not session.show.motion.elements.has_source("audience shakes")
    session.run(0.25, places=(), share=0, shaken=700)
    assert session.show.motion.elements.has_source("audience shakes")


def test_journal_and_snapshots_contain_audience_and_invalid_reports_are_ignored():
    event = events.AudienceHeard(
        time=1.5, source="audience", phones=3, order=2, share=500, places=EAST, lights=(), votes=(1, 0, 100)
    )
    assert event_from_json(event_to_row(event)) == event
    session = AudienceSession()
    session.run(1.1, places=EAST, lights=((7, 500, 0, 300, 1),))
    session.send(events.AskVote, what="step", first="spin", second="sway")
    for row in ((0, 0, 0, 0), (-1, -1, -1, -1), (1 << 40, -(1 << 40), 1 << 40, 9)):
        session.report((row,) * 99, lights=((0, *row),) * 99, votes=(-1, *row))
    session.report()
    source = Snapshotter(session.show)
    while (taken := source.capture(session.index)) is None:
        session.run(1 / 128)
    loaded = LoadedShow(Path("test.toml"), parse_patch(PATCH + REGIONS, "test.toml"), GRAPH)
    again = restore(loaded, taken.seal())
    assert again.audience.facts() == session.show.audience.facts()
    for show in (session.show, again):
        for tick in range(session.index + 1, session.index + 200):
            show.tick(tick * TICK)
    assert again.state_hash() == session.show.state_hash()
    assert again.audience.result == session.show.audience.result


def test_new_patch_keeps_weights_of_remaining_regions():
    session, fresh = AudienceSession(), made_show('[audience]\nregions = ["balcony", "bar"]\n')
    session.send(events.WeighRegion, name="balcony", weight=2.0)
    order = session.show.audience.command_count
    session.show.audience.apply_patch(fresh.audience)
    assert session.show.audience.facts()["regions"] == {"balcony": 2.0, "bar": 1.0}
    assert session.show.audience.command_count == order + 1
    with pytest.raises(PersonError, match="no region"):
        session.show.audience._region_indices("stalls")


def caption(show):
    """The caption of the picture now, and its opacity."""
    view = show.view()
    show.fill(view, show.time)
    return view.caption, view.caption_level


@pytest.mark.long
def test_picture_shows_tally_then_winner_for_its_measures_unless_operator_hides_it():
    session = AudienceSession(REGIONS + "winner_measures = 2\n")
    assert caption(session.show) == ((), 1.0)
    session.send(events.AskVote, what="step", first="spin", second="sway")
    assert caption(session.show)[0] == (("spin", 0.0), ("sway", 0.0))
    session.report(votes=(1, 100, 300))
    assert caption(session.show) == ((("spin", 0.25), ("sway", 0.75)), 1.0)
    session.send(events.ShowTally, on=False)
    assert caption(session.show)[0] == ()
    session.send(events.ShowTally, on=True)
    session.report(votes=(1, 100, 300))
    while session.show.audience.vote is not None:
        session.run(1 / 128)
    closed = session.show.span.number
    assert caption(session.show) == ((("sway", -1.0),), 1.0)
    seen = {}
    while session.show.span.number < closed + 3:
        lines, level = caption(session.show)
        seen.setdefault(session.show.span.number - closed, []).append(level if lines else 0.0)
        session.run(1 / 32)
    assert min(seen[0]) == 1.0
    assert seen[1] == sorted(seen[1], reverse=True)
    assert 0.0 < seen[1][-1] < 0.2
    assert max(seen[2]) == 0.0
    session.send(events.AskVote, what="step", first="spin", second="sway")
    session.send(events.OpenAudience, on=False)  # nothing of the audience is seen
    assert caption(session.show)[0] == ()


def test_snapshot_keeps_winner_tally_switch_and_invitation():
    session = AudienceSession()
    session.send(events.AskVote, what="step", first="spin", second="sway")
    session.report(votes=(1, 100, 300))
    session.run(2.25)
    session.send(events.RenewInvitation)
    shown = caption(session.show)
    assert shown[0] == (("sway", -1.0),)
    source = Snapshotter(session.show)
    while (taken := source.capture(session.index)) is None:
        session.run(1 / 128)
    again = restore(LoadedShow(Path("test.toml"), parse_patch(PATCH + REGIONS, "test.toml"), GRAPH), taken.seal())
    assert caption(again)[0] == shown[0]
    assert (again.audience.invitation, again.audience.tally) == (2, True)
