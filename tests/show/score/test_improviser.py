"""Improvisation: seeded choice, weights, limits, rules, call and response, and the return to the score."""

from itertools import groupby

import pytest

from live.base.errors import PersonError
from live.control.events import events
from live.control.events.events import MusicHeard
from live.show.score.improviser import Improviser, resolve_table
from live.show.score.music_reactions import Mood
from live.show.score.playhead import Playhead
from live.show.score.score import Score, section_timings
from live.show.score.step_history import StepHistory
from tests.fixtures.mostly_long import mostly_long
from tests.show.made_show import GRAPH, PATCH, made_show
from tests.show.score.test_sequences import steps_of

LIBRARY = GRAPH.library
STEPS = {name: LIBRARY.steps.index(name) for name in ("sway", "glide", "spin", "phrase")}
OWN = [STEPS["sway"], STEPS["glide"], STEPS["spin"]]


class ImproviserPair:
    """Improvisers of the two groups of PATCH without a show: what each chooses, measure by measure."""

    def __init__(self, extra, seed=3):
        from live.show.patch.patch_reader import parse_patch

        patch = parse_patch(PATCH + extra, "test.toml")
        self.score = Score(patch, Playhead(section_timings(patch)))
        self.mood, self.ledger = Mood(), StepHistory()
        names = ["front", "back"]
        self.groups = []
        for group, name in enumerate(names):
            own = [section for section in patch.improvise if section.group in ("*", name)]
            tables = [resolve_table(section, self.score, GRAPH, OWN, names, group) for section in own]
            tables = [table for table in tables if table is not None]
            usual = tables[0] if tables else None
            self.groups.append(
                Improviser(tables, usual, self.score, self.ledger, self.mood, group=group, seed=seed, graph=GRAPH)
            )
        self.measure = -1

    def dance(self, measures):
        """(step name, measure within the step) of both groups in the next measures."""
        danced = [[], []]
        for _ in range(measures):
            self.measure += 1
            self.score.playhead.begin_measure(self.measure)
            for group, improviser in enumerate(self.groups):
                told = improviser.choose(self.measure, GRAPH.entries(OWN[0])[:0], standing=False)
                if told is not None:
                    improviser.record(self.measure, told[0], told[2])
                    danced[group].append((LIBRARY.steps[told[0]], told[2]))
        return danced


def run_lengths(danced):
    """The lengths of runs in which the same step begins again."""
    begun = [step for step, into in danced if into == 0]
    return [len(list(same)) for _, same in groupby(begun)]


def test_same_seed_repeats_the_steps_and_another_differs():
    table = '[[improvise]]\ngroup = "front"\n'
    one, other = ImproviserPair(table).dance(64)[0], ImproviserPair(table).dance(64)[0]
    assert one == other
    assert ImproviserPair(table, seed=4).dance(64)[0] != one


@mostly_long(("at_least", "most"), [(1, 1), (1, 2), (2, 2), (2, 3)], quick=[0, 2])
def test_step_repetitions_stay_within_the_limits(at_least, most):
    steps = "steps = {sway = 8, glide = 1, phrase = 1}"
    stage = ImproviserPair(f'[[improvise]]\ngroup = "front"\n{steps}\nat_least = {at_least}\nmost = {most}\n')
    found = run_lengths(stage.dance(600)[0])
    assert max(found) == most
    assert min(found[:-1]) == at_least


def test_steps_of_several_measures_are_completed():
    danced = ImproviserPair('[[improvise]]\ngroup = "front"\nsteps = {phrase = 1, sway = 1}\n').dance(200)[0]
    intos = [into for step, into in danced if step == "phrase"]
    assert intos[: len(intos) // 2 * 2] == [0, 1] * (len(intos) // 2)


def test_step_frequencies_match_their_weights():
    """With most = 1000 draws are independent: frequencies within four standard deviations."""
    danced = ImproviserPair('[[improvise]]\ngroup = "front"\nsteps = {sway = 3, glide = 1}\nmost = 1000\n').dance(2000)[
        0
    ]
    share = sum(step == "sway" for step, _ in danced) / 2000
    assert abs(share - 0.75) < 4.0 * (0.75 * 0.25 / 2000) ** 0.5


def test_music_rules_favor_and_forbid_steps():
    stage = ImproviserPair(
        '[[improvise]]\ngroup = "front"\nsteps = {sway = 1, glide = 1, spin = 1}\nmost = 2\n'
        '[[improvise.rule]]\nof = "energy"\nabove = 0.7\nfavours = {sway = 0}\n'
        '[[improvise.rule]]\nof = "energy"\nbelow = 0.3\nfavours = {spin = 0, glide = 0}\n'
    )
    assert {step for step, _ in stage.dance(60)[0]} == {"sway", "glide", "spin"}
    set_loudness(stage.mood, 1.0)
    assert {step for step, _ in stage.dance(60)[0][3:]} == {"glide", "spin"}
    set_loudness(stage.mood, 0.0)
    quiet = [step for step, _ in stage.dance(60)[0]]
    assert quiet.count("sway") >= 39  # the limit counts more than the rule: two of three
    assert max(run_lengths([(step, 0) for step in quiet])) == 2


def set_loudness(mood, loud):
    for _ in range(60):
        mood.update(
            MusicHeard(
                time=0.0, source="audio", beat_time=0.0, loudness=loud, density=6.0 * loud, brightness=0.5, low=0.5,
                build=0.0, drop=False,
            )
        )  # fmt: skip


def test_group_answers_with_the_steps_of_its_caller():
    front, back = ImproviserPair(
        '[[improvise]]\ngroup = "front"\n[[improvise]]\ngroup = "back"\n'
        'answers = "front"\nphrase = 4\nlistening = "sway"\n'
    ).dance(64)
    for phrase in range(0, 16, 2):
        calls, answers = slice(4 * phrase, 4 * phrase + 4), slice(4 * phrase + 4, 4 * phrase + 8)
        assert [step for step, _ in back[calls]] == ["sway"] * 4
        assert back[answers] == front[calls]


def test_group_answers_with_steps_its_caller_left_out():
    front, back = ImproviserPair(
        '[[improvise]]\ngroup = "front"\nmost = 2\n'
        '[[improvise]]\ngroup = "back"\nanswers = "front"\nanswer = "other"\nphrase = 2\nmost = 1000\n'
    ).dance(80)
    for phrase in range(0, 40, 2):
        called = {step for step, _ in front[2 * phrase : 2 * phrase + 2]}
        assert not called & {step for step, _ in back[2 * phrase + 2 : 2 * phrase + 4]}


def test_every_pass_of_a_section_differs_for_each_group():
    stage = ImproviserPair('[[section]]\nname = "solo"\nmeasures = 16\nwait = true\n[[improvise]]\nsection = "solo"\n')
    front, back = stage.dance(64)
    turns = [tuple(front[turn : turn + 16]) for turn in range(0, 64, 16)]
    assert len(set(turns)) == 4
    assert front != back


def test_impossible_limits_and_unknown_names_are_refused():
    for table, words in (
        ("steps = {sway = 1}", "more than 2 times in a row"),
        ("steps = {moonwalk = 1}", "no step is called 'moonwalk'"),
        ('steps = {sway = 1, spin = 1}\nrule = [{of = "low", above = 0.5, favours = {jete = 2}}]', "'jete'"),
    ):
        with pytest.raises(PersonError, match=r"improvise of group 'front' in measure 5") as caught:
            made_show(f'[[improvise]]\ngroup = "front"\nmeasure = 5\n{table}\n')
        assert words in str(caught.value)


@pytest.mark.long
def test_show_switches_from_score_to_improvisation_and_back_by_event():
    score = (
        '[[sequence]]\nmeasures = 64\nsteps = ["sway"]\n[[improvise]]\nmeasure = 65\nsteps = {glide = 1, spin = 1}\n'
    )
    at = {
        64 * 5: lambda time: events.Improvise(time=time, source="osc", on=True, group="front"),
        64 * 13: lambda time: events.Improvise(time=time, source="osc", on=False, group="front"),
    }
    danced = steps_of(made_show(score), 22, does=at)
    assert danced[:3] == ["sway"] * 3
    assert set(danced[3:7]) == {"glide", "spin"}
    assert danced[8:] == ["sway"] * len(danced[8:])
    assert len(danced) > 9


def test_two_shows_improvise_identical_steps_and_motion():
    extra = (
        '[[improvise]]\nphrase = 2\nmotion = [{weight = 1, call = "/dance/formation", values = ["circle", 1]},'
        ' {call = "/dance/attract", values = [2, 1, 1, 1]}, {weight = 1}]\n'
    )
    shows = [made_show(extra) for _ in range(2)]
    danced = [steps_of(show, 17) for show in shows]
    assert danced[0] == danced[1]
    assert shows[0].state_hash() == shows[1].state_hash()
    assert shows[0].score_runner.beat_scheduler.fired >= 2
