"""The audience in the show: elements, lights, turns, votes; what the operator says holds within a tick."""

from pathlib import Path

import numpy as np
import pytest

from live.base.errors import PersonError
from live.base.stage_snapshot import PARTICIPANT, REPULSOR
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
EAST = "500 0 1000 1"


class Hands:
    """A show, run tick by tick, and an audience that goes on playing."""

    def __init__(self, extra=REGIONS):
        self.show, self.index, self.said = made_show(extra), 0, None

    def say(self, kind, **values):
        assert self.show.apply(kind(time=self.show.time, source="osc", **values)), self.show.refusals.last_reason

    def heard(self, places=EAST, *, share=1000, **values):
        values = {"phones": 100, "order": self.show.audience.command_count, "share": share, "places": places} | values
        self.show.apply(events.AudienceHeard(time=self.show.time, source="audience", **values))

    def run(self, measures=1.0, **heard):
        for _ in range(round(measures * 2.0 / TICK)):
            self.index += 1
            if heard and self.index % 8 == 0:
                self.heard(**heard)
            self.show.tick(self.index * TICK)

    def acting(self):
        """Kinds and strengths of the elements in force."""
        beat = self.show.timeline.beat_at(self.show.time)
        return {e.table_kind: e.strength for e in self.show.motion.elements.in_force if e.level(beat + 0.5) > 0.0}

    def away(self, x=5.0, z=0.0):
        """How far dancers are from a point on the average [m]."""
        return float(np.hypot(*(self.show.state.position - (x, z)).T).mean())


def test_dancers_come_to_where_the_audience_gathers_and_leave_what_it_repels():
    coming, going, alone = Hands(), Hands(), Hands()
    coming.run(4, places=EAST)
    going.run(4, places="0 0 1000 2")
    alone.run(4)
    assert coming.away() < alone.away() - 1.0
    assert going.away(0.0, 0.0) > alone.away(0.0, 0.0) + 0.2
    assert set(coming.acting()) == {PARTICIPANT}
    assert set(going.acting()) == {REPULSOR}
    coming.run(3)  # nobody plays any more: it ends by itself
    assert coming.acting() == {}


def test_close_and_mute_act_within_one_tick_and_stale_words_are_not_heard():
    hands = Hands()
    hands.run(1, places=EAST, lights="7 500 0 300 1")
    stale = hands.show.audience.command_count
    hands.say(events.MuteAudience, on=True)
    hands.run(1 / 128)
    assert hands.acting() == {}
    assert hands.show.audience.facts()["lights"]
    hands.say(events.MuteAudience, on=False)
    hands.run(1 / 128)
    assert set(hands.acting()) == {PARTICIPANT}
    hands.say(events.OpenAudience, on=False)
    hands.run(1 / 128)
    assert hands.acting() == {}
    assert hands.show.audience.facts()["lights"] == []
    hands.say(events.OpenAudience, on=True)
    hands.heard(order=stale)  # made before the operator spoke
    assert hands.acting() == {}
    hands.heard()
    assert set(hands.acting()) == {PARTICIPANT}
    hands.say(events.Panic)
    assert hands.acting() == {}
    assert hands.show.audience.muted


def test_the_operators_gain_and_whoever_leads_rank_over_the_audience():
    hands = Hands()
    hands.heard()
    assert hands.acting() == {PARTICIPANT: pytest.approx(4.0)}  # as many voices as are needed for all of the force
    hands.say(events.SetAudienceGain, gain=0.5)
    assert hands.acting() == {PARTICIPANT: pytest.approx(2.0)}
    hands.say(events.Attract, x=-5.0, z=0.0)
    hands.run(0.5, places=EAST)
    assert hands.acting()[PARTICIPANT] == pytest.approx(2.0 * LED_GAIN)


def test_places_keep_their_element_when_they_move_and_change_their_kind():
    hands = Hands()
    hands.run(0.5, places="500 0 1000 1,-300 0 500 1")
    hands.heard("520 0 1000 1,0 0 0 1,100 100 400 2")
    beat = hands.show.timeline.beat_at(hands.show.time)
    there = {e.source: (e.x, e.table_kind, e.level(beat) > 0.5) for e in hands.show.motion.elements.in_force}
    assert there["audience 1"] == (pytest.approx(5.2), PARTICIPANT, True)  # it goes on, and does not fade in anew
    assert there["audience 3"][:2] == (1.0, REPULSOR)
    hands.heard("520 0 1000 2")
    hands.run(1)
    assert set(hands.acting()) == {REPULSOR}


def test_lights_follow_their_phones_come_and_go_softly_and_a_banned_one_at_once():
    hands = Hands()
    hands.run(0.5, lights="7 500 0 300 1,8 -500 100 600 2")
    view = hands.show.view()
    hands.show.fill(view, hands.show.time)
    assert view.light_count == 2
    by_hue = {round(float(row[2]), 1): row for row in view.light[:2]}
    np.testing.assert_allclose(by_hue[0.3], (5.0, 0.0, 0.3, 1.0, 0.0), atol=0.01)
    np.testing.assert_allclose(by_hue[0.6], (-5.0, 1.0, 0.6, 1.0, 1.0), atol=0.01)
    hands.heard(lights="7 400 0 300 1")
    hands.run(1 / 128)
    rows = {row[0]: row[1] for row in hands.show.audience.facts()["lights"]}
    assert 4.0 < rows[7] < 5.0
    assert 8 in rows  # still fading
    hands.run(1)
    assert [row[0] for row in hands.show.audience.facts()["lights"]] == [7]
    hands.say(events.BanPhone, number=7)
    hands.run(1 / 128)
    assert hands.show.audience.facts()["lights"] == []
    hands.heard(lights="7 400 0 300 1")
    assert hands.show.audience.facts()["lights"] == []
    hands.say(events.BanPhone, number=0, on=False)
    hands.heard(lights="7 400 0 300 1")
    assert hands.show.audience.facts()["lights"] != []


def test_a_turn_begins_and_ends_at_measure_lines():
    hands = Hands()
    hands.run(0.75)
    measure = hands.show.span.number
    hands.say(events.GiveTurn, name="Balcony", measures=2.0)
    hands.say(events.WeighRegion, name="*", weight=0.5)
    heard = []
    for _ in range(5):
        heard.append(tuple(hands.show.audience.region_weights(hands.show.span.number)))
        hands.run(1)
    assert hands.show.span.number == measure + 5
    assert heard == [(0.5, 0.5), (0.0, 0.5), (0.0, 0.5), (0.5, 0.5), (0.5, 0.5)]
    assert hands.show.audience.turn is None
    refused = hands.show.refusals.count
    for name in ("gallery", "", "stalls, balcony"):
        hands.show.apply(events.WeighRegion(time=0.0, source="osc", name=name or "?", weight=1.0))
    assert hands.show.refusals.count == refused + 3


def test_the_winner_of_a_vote_is_called_at_the_measure_line_and_ties_are_drawn_from_the_seed():
    hands = Hands()
    hands.say(events.AskVote, what="step", first="SPIN", second="sway")
    order = hands.show.audience.command_count
    hands.heard(votes="1 100 250", order=order)
    hands.heard(votes="9 900 0", order=order)  # of another vote
    hands.run(1)
    assert hands.show.audience.vote is not None
    hands.run(1)
    assert hands.show.audience.vote is None
    assert hands.show.audience.result == (1, "sway")
    hands.run(3)
    library = hands.show.graph.library
    danced = {library.steps[library.node_step[node]] for node in hands.show.dancers.present.node}
    assert danced == {"sway"}
    hands.say(events.AskVote, what="step", first="spin", second="sway")
    hands.run(3)
    assert hands.show.audience.result == (2, "")  # nobody voted
    ties = {Vote(number, "step", ("a", "b"), 1, (100, 100)).winner(3) for number in range(1, 30)}
    assert ties == {"a", "b"}
    assert Vote(5, "step", ("a", "b"), 1, (1, 1)).winner(3) == Vote(5, "step", ("a", "b"), 1, (2, 2)).winner(3)
    for values in (
        {"what": "step", "first": "spin", "second": "fly"}, {"what": "dancer", "first": "a", "second": "b"},
        {"what": "step", "first": "spin", "second": "Spin"}, {"what": "scene", "first": "x", "second": "y"},
    ):  # fmt: skip
        assert not hands.show.apply(events.AskVote(time=0.0, source="osc", **values))


def test_many_shaken_phones_spread_the_dancers_once():
    hands = Hands()
    hands.run(0.25, places="-", share=0, shaken=200)
    assert not hands.show.motion.elements.has_source("audience shakes")
    hands.run(0.25, places="-", share=0, shaken=700)
    assert hands.show.motion.elements.has_source("audience shakes")


def test_the_journal_and_snapshots_have_the_audience_and_rubbish_changes_nothing():
    event = events.AudienceHeard(
        time=1.5, source="audience", phones=3, order=2, share=500, places=EAST, lights="-", votes="1 0 100"
    )
    assert event_from_json(event_to_row(event)) == event
    hands = Hands()
    hands.run(1.1, places=EAST, lights="7 500 0 300 1")
    hands.say(events.AskVote, what="step", first="spin", second="sway")
    for rubbish in ("x", "1 2", "1,2,3", "9" * 400, "1 2 3 4 5 6", ",,,", "nan 0 1 1", "1e9 0 0 0", "-1 -1 -1 -1 -1"):
        hands.heard(rubbish, lights=rubbish, votes=rubbish)
    hands.heard()
    source = Snapshotter(hands.show)
    while (taken := source.capture(hands.index)) is None:
        hands.run(1 / 128)
    loaded = LoadedShow(Path("test.toml"), parse_patch(PATCH + REGIONS, "test.toml"), GRAPH)
    again = restore(loaded, taken.seal())
    assert again.audience.facts() == hands.show.audience.facts()
    for show in (hands.show, again):
        for tick in range(hands.index + 1, hands.index + 200):
            show.tick(tick * TICK)
    assert again.state_hash() == hands.show.state_hash()
    assert again.audience.result == hands.show.audience.result


def test_another_patch_keeps_the_weights_of_regions_that_are_still_there():
    hands, fresh = Hands(), made_show('[audience]\nregions = ["balcony", "bar"]\n')
    hands.say(events.WeighRegion, name="balcony", weight=2.0)
    order = hands.show.audience.command_count
    hands.show.audience.apply_patch(fresh.audience)
    assert hands.show.audience.facts()["regions"] == {"balcony": 2.0, "bar": 1.0}
    assert hands.show.audience.command_count == order + 1
    with pytest.raises(PersonError, match="no region"):
        hands.show.audience._region_indices("stalls")
