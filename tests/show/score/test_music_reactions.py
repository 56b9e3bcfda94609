"""Reactions to detected music: followed values, calls at the measure line, and validation of the patch."""

from itertools import pairwise

import pytest

from live.base.errors import PersonError
from live.control.events.events import CallStep, MusicHeard, NotesHeard, SetParameter
from live.show.patch.patch_reader import parse_patch
from live.show.score.music_reactions import Reactions
from tests.show.made_show import made_show

GROUP = '\n[[group]]\nname = "ember"\ndancers = 4\nsteps = ["sway"]\n'


def beat(time: float, *, loudness: float = 0.5, build: float = 0.0, drop: bool = False) -> MusicHeard:
    return MusicHeard(
        time=time, source="audio", beat_time=time, loudness=loudness, density=3.0, brightness=0.5, low=0.5, build=build,
        drop=drop,
    )  # fmt: skip


def reactions(text: str) -> Reactions:
    return Reactions(parse_patch('name = "a show"\n' + text + GROUP, "show.toml"))


def test_a_parameter_follows_the_loudness_smoothly() -> None:
    heard = reactions(
        '[[react]]\nto = "loudness"\nsets = "larger"\nlow = -0.3\nhigh = 0.3\ngroup = "ember"\nbeats = 4\n'
    )
    values = []
    for n in range(24):
        (change,) = heard.handle_music(beat(n * 0.5, loudness=0.0 if n < 4 else 1.0))
        assert isinstance(change, SetParameter)
        assert (change.address, change.group) == ("/dance/motion/larger", "ember")
        values.append(change.value[0])
    assert values[:4] == [-0.3] * 4
    assert all(one < other for one, other in pairwise(values[3:]))
    assert values[7] == pytest.approx(-0.3 + 0.6 * (1.0 - 2.718281828**-1.0))  # four beats: all but 1/e of the way
    assert values[-1] == pytest.approx(0.3, abs=0.01)


def notes(time: float, *, beats: float = 0.125, **figures: float) -> NotesHeard:
    said = {"energy": 0.0, "density": 0.0, "chord": 0, "pitch": 0.5} | figures
    return NotesHeard(time=time, source="midi", beats=beats, **said)  # type: ignore[arg-type]


def test_notes_and_music_drive_their_own_parameters_only() -> None:
    heard = reactions(
        '[[react]]\nto = "chord"\nsets = "larger"\nlow = 0.0\nhigh = 0.4\nbeats = 4\n'
        '[[react]]\nto = "note_energy"\nsets = "/dance/light/rim"\nbeats = 0\n'
        '[[react]]\nto = "loudness"\nsets = "head"\nbeats = 0\n'
    )
    larger, rim = heard.handle_notes(notes(1.0, chord=4, energy=0.7))
    assert isinstance(larger, SetParameter) and isinstance(rim, SetParameter)  # noqa: PT018
    assert (larger.address, larger.value) == ("/dance/motion/larger", (0.2,))
    assert (rim.address, rim.value) == ("/dance/light/rim", (0.7,))
    larger, rim = heard.handle_notes(notes(3.0, beats=4.0, chord=8))
    assert isinstance(larger, SetParameter) and isinstance(rim, SetParameter)  # noqa: PT018
    assert larger.value[0] == pytest.approx(0.4 - 0.2 / 2.718281828)  # four beats: all but 1/e of the way
    assert rim.value == (0.0,)
    (head,) = heard.handle_music(beat(3.5, loudness=0.25))
    assert isinstance(head, SetParameter)
    assert (head.address, head.value) == ("/dance/motion/head", (0.25,))


def test_notes_set_the_mood_of_improvisation_and_light() -> None:
    show = made_show()
    mood = show.score_runner.mood
    assert (mood.value("energy"), mood.value("note_energy"), mood.value("chord")) == (0.5, 0.0, 0.0)
    show.apply(notes(0.0, energy=0.8, density=3.0, chord=2, pitch=0.25))
    assert (mood.value("note_energy"), mood.value("chord"), mood.value("pitch")) == (0.8, 0.25, 0.25)
    assert mood.value("energy") == pytest.approx(0.5 * (0.8 + 0.5))
    show.apply(beat(0.5, loudness=1.0))
    assert mood.value("energy") == pytest.approx(0.75)  # the band has more of it
    before = show.desk.energy
    for tick in range(1, 65):
        show.tick(tick / 64)
    assert show.desk.energy > before


def test_strength_of_new_elements_follows_density() -> None:
    heard = reactions('[[react]]\nto = "density"\nsets = "strength"\nlow = 0.0\nhigh = 2.0\nbeats = 0\n')
    assert heard.handle_music(beat(0.0)) == []
    assert heard.strength == pytest.approx(1.0)


def test_drop_calls_a_step_once_at_next_measure_line() -> None:
    heard = reactions('[[react]]\non = "drop"\ncall = "/dance/step"\nvalues = ["sway", 2]\n')
    assert heard.cross_measure_line(0.0) == []
    assert heard.handle_music(beat(1.0, drop=True)) == []
    heard.handle_music(beat(1.5))
    (called,) = heard.cross_measure_line(2.0)
    assert isinstance(called, CallStep)
    assert (called.name, called.measures, called.time, called.source) == ("sway", 2.0, 2.0, "music")
    assert heard.cross_measure_line(4.0) == []
    assert heard.facts()["drops"] == 1


def test_build_up_triggers_one_call_when_it_begins() -> None:
    heard = reactions('[[react]]\non = "build"\ncall = "/dance/spread"\n')
    called = 0
    for n, build in enumerate([0.0, 0.6, 0.9, 0.45, 0.7, 0.1, 0.0, 0.8]):
        heard.handle_music(beat(n * 0.5, build=build))
        called += len(heard.cross_measure_line(n * 0.5))
    assert called == 2


@pytest.mark.parametrize(
    ("table", "why"),
    [
        ('to = "loudness"\n', "`to` goes with `sets`"),
        ('to = "loudness"\nsets = "larger"\non = "drop"\ncall = "/dance/spread"\n', "either"),
        ("", "either"),
        ('on = "drop"\ncall = "/dance/step"\n', "/dance/step"),
        ('on = "drop"\ncall = "/dance/nothing"\n', "/dance/nothing"),
        ('on = "drop"\ncall = "/dance/spread"\nvalues = [1e9]\n', "/dance/spread"),
        ('to = "volume"\nsets = "larger"\n', "react.1.to"),
    ],
)
def test_invalid_reaction_is_refused_with_line(table: str, why: str) -> None:
    with pytest.raises(PersonError) as caught:
        reactions("[[react]]\n" + table)
    assert "show.toml, line " in str(caught.value)
    assert why in str(caught.value)


def test_light_follows_the_music_smoothly_from_beat_to_beat() -> None:
    show = made_show('[[react]]\nto = "loudness"\nsets = "/dance/light/rim"\nlow = 0.5\nhigh = 2.5\nbeats = 0\n')
    first = show.desk.parameters.table.find("/dance/light/rim")[0].first
    show.apply(beat(0.0, loudness=1.0))
    values = []
    for tick in range(1, 40):
        show.tick(tick / 64)
        values.append(float(show.desk.parameters.value[first]))
    assert values[15] == pytest.approx(1.75)  # half a beat later: half way from 1 to 2.5
    assert values[31:] == [2.5] * 8
    assert show.desk.undo_history.facts()["edits"] == 0


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ('sets = "/dance/light/rmi"', "there are: /dance/light/level"),
        ('sets = "/dance/light/floor"', "no number of the picture"),
        ('sets = "/dance/light/ambient"\nhigh = 3', "0 to 1 expected"),
        ('sets = "/dance/light/rim"\ngroup = "front"', "belong to no group"),
    ],
)
def test_invalid_light_reaction_is_refused_with_reason(line: str, words: str) -> None:
    with pytest.raises(PersonError, match=words):
        made_show(f'[[react]]\nto = "loudness"\n{line}\n')
