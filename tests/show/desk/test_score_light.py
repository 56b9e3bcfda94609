"""Tests of the light that follows the score: what it shows, what it leaves alone, and that it never flashes."""

import numpy as np
import pytest

from live.base import picture_parameters as pp
from live.clock.ticks import TICK
from live.control.events.audio import MusicHeard
from live.show.desk.score_light import AMOUNT, BEAMS, KEY, LEVEL, PRESET, SPOTS
from tests.fixtures.mostly_long import mostly_long
from tests.show.desk.desk_show import DeskSession

ENDING = '[[section]]\nname = "all"\nmeasures = 4\nthen = "end"\n'


def row_of(session):
    view = session.show.view()
    session.show.fill(view, session.ticks * TICK)
    return view.picture.copy(), view.spot.copy()


def level(session):
    return float(row_of(session)[0][LEVEL])


def hear(session, beats, **features):
    """Let the show hear so many beats of music while it runs."""
    said = {"loudness": 0.5, "density": 2.0, "brightness": 0.5, "low": 0.5, "build": 0.0} | features
    for _ in range(beats):
        now = session.ticks * TICK
        event = MusicHeard(time=now, source="audio", beat_time=now, **said)
        said["drop"] = False
        session.show.apply(event)
        session.run(1)
    return session


def test_show_begins_in_half_light_and_fades_up_within_a_measure():
    session = DeskSession("")
    first = level(session.run(ticks=1))
    assert first == pytest.approx(PRESET, abs=0.1)
    assert level(session.run(8)) == pytest.approx(1.0)


@pytest.mark.long
def test_piece_that_ends_fades_to_black_and_comes_back_when_it_goes_on():
    session = DeskSession(ENDING)
    while session.show.span.number < 2:
        session.run(1)
    levels = [level(session.run(1)) for _ in range(24)]
    assert levels[0] > 0.9
    assert levels[-1] == pytest.approx(0.0, abs=1e-6)
    assert np.diff(levels).max() < 1e-6
    session.say("/dance/advance")
    assert level(session.run(16)) > 0.9


@pytest.mark.long
def test_dark_end_is_only_that_of_the_score():
    session = DeskSession("").run(8)
    assert min(level(session.run(2)) for _ in range(40)) > 0.7


@pytest.mark.long
def test_loud_music_is_brighter_and_quiet_music_cooler():
    quiet = row_of(hear(DeskSession("").run(8), 24, loudness=0.05, density=0.2))[0]
    loud = row_of(hear(DeskSession("").run(8), 24, loudness=0.95, density=6.0))[0]
    assert quiet[LEVEL] < 0.9 < 1.1 < loud[LEVEL]
    colour = pp.BY_ADDRESS["/dance/light/key/colour"].row_slice
    assert quiet[colour][2] / quiet[colour][0] > 1.2 * loud[colour][2] / loud[colour][0]


def test_build_up_raises_beams_and_a_drop_opens_them():
    session = DeskSession("").run(8)
    fan = pp.BY_ADDRESS["/dance/light/beams/fan"].first
    before = row_of(session)[0]
    built = row_of(hear(session, 8, build=0.9))[0]
    assert built[BEAMS] > before[BEAMS] + 0.5
    assert built[fan] < before[fan] - 0.3
    dropped = row_of(hear(session, 1, drop=True))[0]
    assert dropped[fan] > before[fan] + 0.2
    assert row_of(hear(session, 24))[0][BEAMS] == pytest.approx(before[BEAMS], abs=0.05)


@pytest.mark.long
def test_only_dancer_is_lit_where_they_dance():
    session = DeskSession("").run(8)
    assert row_of(session)[0][list(SPOTS)].max() == 0.0
    assert session.say("/dance/leave", "front + back - 2"), session.words
    while np.count_nonzero(session.show.motion.present) > 1 and session.ticks < 64 * 120:
        session.run(4)
    row, spot = row_of(session.run(8))
    assert row[SPOTS[-1]] > 0.5
    hips = session.show.dancers.drawn_hips[session.show.motion.present][0]
    assert np.linalg.norm(spot[-1] - hips) < 0.6
    assert session.say("/dance/enter", 4.0), session.words
    session.run(60)
    assert np.count_nonzero(session.show.motion.present) > 1
    assert row_of(session)[0][SPOTS[-1]] == 0.0


@mostly_long(
    ("call", "place"),
    [(("/dance/light/level", 0.6), LEVEL), (("/dance/light/key", 0.7), KEY), (("/dance/light/beams", 0.2), BEAMS)],
    quick=[],
    ids=lambda one: str(one),
)  # fmt: skip
def test_touched_parameter_belongs_to_the_hand_until_it_is_released(call, place):
    session = hear(DeskSession("").run(8), 12, build=0.9, loudness=0.1)
    assert row_of(session)[0][place] != pytest.approx(session.desk.parameters.value[place], abs=1e-3)
    session.say(*call)
    hear(session, 8, build=0.9, loudness=0.1)
    assert row_of(session)[0][place] == call[1]
    assert session.say("/dance/light/score", 1.0)
    hear(session, 8, build=0.9, loudness=0.1)
    assert row_of(session)[0][place] != pytest.approx(call[1], abs=1e-3)


@pytest.mark.long
def test_scene_claims_its_values_and_the_start_scene_gives_them_back():
    session = hear(DeskSession().run(8), 8, loudness=0.1)
    session.say("/dance/scene", "low", 0.0)
    hear(session, 8, loudness=0.1)
    assert row_of(session)[0][LEVEL] == 0.25
    session.say("/dance/scene", "start", 0.0)
    hear(session, 8, loudness=0.1)
    assert row_of(session)[0][LEVEL] < 0.95


@pytest.mark.long
def test_panic_switches_it_off_until_the_show_goes_on():
    session = hear(DeskSession().run(8), 12, loudness=0.1)
    assert level(session) < 0.95
    session.say("/dance/panic")
    hear(session, 8, loudness=0.1)
    assert level(session) == 1.0
    session.say("/dance/go")
    assert level(hear(session, 2, loudness=0.1)) < 0.95


@pytest.mark.long
def test_amount_of_zero_changes_nothing():
    session = DeskSession("[look]\nfollow_score = 0\n")
    for _ in range(6):
        hear(session, 4, build=0.8, loudness=0.1)
        row, _ = row_of(session)
        assert (row == session.desk.parameters.picture).all()
    assert row[AMOUNT] == 0.0


@pytest.mark.long
def test_light_changes_slower_than_a_flash():
    """Even with a drop at every beat: never 10 % down and up again within a third of a second (WCAG 2.2, 2.3.1)."""
    session, levels = DeskSession("").run(8), []
    for beat in range(32):
        hear_once = MusicHeard(
            time=session.ticks * TICK, source="audio", beat_time=session.ticks * TICK, loudness=float(beat % 2),
            density=6.0 * (beat % 2), brightness=0.5, low=0.5, build=float(beat % 2), drop=True,
        )  # fmt: skip
        session.show.apply(hear_once)
        for _ in range(8):
            row, _ = row_of(session.run(ticks=4))
            levels.append(float(row[LEVEL] * (0.5 + 0.5 * row[KEY])))
    turns = [
        at for at in range(1, len(levels) - 1) if (levels[at] - levels[at - 1]) * (levels[at + 1] - levels[at]) < 0
    ]
    steps = np.abs(np.diff([levels[at] for at in turns]))
    assert len(steps) == 0 or steps.max() < 0.1 * max(levels)


def test_parameters_themselves_never_change():
    session = DeskSession("").run(1)
    before = session.desk.parameters.value.copy()
    hear(session, 12, build=0.9, loudness=0.9, drop=True)
    assert (session.desk.parameters.value == before).all()
    assert not session.desk.parameters.touched
