"""Playhead: position in every measure, with sections that repeat, wait, jump, are held or practiced."""

import itertools
import random

import pytest

from live.show.score.playhead import END, Place, Playhead, SectionTiming

SONG = (
    SectionTiming("intro", 2, 1, 1),
    SectionTiming("verse", 3, 2, 2),
    SectionTiming("solo", 2, 0, 3),
    SectionTiming("coda", 1, 1, END),
)


def play_measures(playhead, count):
    """(section, measure) of the next `count` measures, begun one after another."""
    found = []
    for _ in range(count):
        playhead.begin_measure(playhead.measure + 1)
        place = playhead.place(playhead.measure)
        found.append((place.section, place.measure))
    return found


def test_position_without_sections_is_measure_modulo_length():
    playhead = Playhead([SectionTiming("", 5, 1, 0)])
    assert play_measures(playhead, 17) == [(0, measure % 5) for measure in range(17)]
    assert playhead.place(16).turn == 3
    endless = Playhead([SectionTiming("", None, 1, 0)])
    assert play_measures(endless, 9) == [(0, measure) for measure in range(9)]


def test_sections_repeat_wait_for_advance_and_end():
    playhead = Playhead(SONG)
    verse = [(1, 0), (1, 1), (1, 2)]
    assert play_measures(playhead, 8) == [(0, 0), (0, 1), *verse, *verse]
    assert play_measures(playhead, 7) == [(2, 0), (2, 1), (2, 0), (2, 1), (2, 0), (2, 1), (2, 0)]
    assert playhead.waiting
    playhead.advance()
    assert not playhead.waiting
    assert play_measures(playhead, 4) == [(2, 1), (3, 0), (END, 0), (END, 1)]
    assert not playhead.entered(playhead.measure)
    playhead.advance()
    assert play_measures(playhead, 2) == [(0, 0), (0, 1)]


def test_no_section_plays_before_first_downbeat():
    playhead = Playhead(SONG)
    playhead.begin_measure(-2)
    assert playhead.place(-2) == Place(END, -2)
    assert [playhead.place(measure).section for measure in (-1, 0, 1, 2)] == [END, 0, 0, 1]
    playhead.jump(2)
    playhead.begin_measure(-1)
    assert playhead.place(-1).section == END
    playhead.begin_measure(0)
    assert playhead.place(0) == Place(2, 0, 0)


def test_jump_acts_once_at_measure_or_section_end():
    playhead = Playhead(SONG)
    play_measures(playhead, 4)
    playhead.jump(0, 1)
    assert playhead.place(4) == Place(0, 1, 1)
    assert playhead.jumped(4)
    assert play_measures(playhead, 3) == [(0, 1), (1, 0), (1, 1)]
    assert playhead.place(playhead.measure).turn == 1
    playhead.jump(3, when="section")
    assert play_measures(playhead, 3) == [(1, 2), (3, 0), (END, 0)]


def test_advance_by_measure_enters_following_section():
    playhead = Playhead(SONG)
    play_measures(playhead, 3)
    playhead.advance("measure")
    assert play_measures(playhead, 2) == [(2, 0), (2, 1)]


def test_held_measure_repeats_without_new_entries():
    playhead = Playhead(SONG)
    play_measures(playhead, 2)
    playhead.hold(True)
    for _ in range(3):
        playhead.begin_measure(playhead.measure + 1)
        assert playhead.place(playhead.measure) == Place(0, 1, 0)
        assert not playhead.entered(playhead.measure)
    playhead.hold(False)
    assert playhead.entered(playhead.measure + 1)
    assert play_measures(playhead, 1) == [(1, 0)]


def test_practice_loops_written_measures_without_repeats():
    playhead = Playhead(SONG)
    play_measures(playhead, 1)
    playhead.loop((3, 6))
    assert play_measures(playhead, 9) == [*[(1, 1), (1, 2), (2, 0), (2, 1)] * 2, (1, 1)]
    playhead.loop(None)
    assert play_measures(playhead, 4) == [(1, 2), (2, 0), (2, 1), (2, 0)] or playhead.passes > 1
    with pytest.raises(ValueError, match="has no measure 9"):
        playhead.loop((2, 8))
    with pytest.raises(ValueError, match="comes last"):
        playhead.loop((3, 2))


def test_jump_to_unknown_position_is_refused_without_effect():
    playhead = Playhead(SONG)
    play_measures(playhead, 2)
    for section, measure in ((4, 0), (-1, 0), (0, 2), (1, -1)):
        with pytest.raises(ValueError, match="no "):
            playhead.jump(section, measure)
    assert play_measures(playhead, 1) == [(1, 0)]


def test_written_measures_map_one_to_one_to_positions():
    playhead = Playhead(SONG)
    assert playhead.length == 8
    assert [playhead.written_measure(playhead.place_of_written(measure)) for measure in range(8)] == list(range(8))


@pytest.mark.parametrize("seed", range(12))
def test_predicted_positions_match_played_positions(seed):
    """Predictions against actual playback, and every section's passes counted independently."""
    chance = random.Random(seed)
    playhead = Playhead(SONG)
    begun = dict.fromkeys(range(len(SONG)), 0)
    for _ in range(60):
        match chance.randrange(8):
            case 0:
                playhead.jump(chance.randrange(4), 0, chance.choice(["measure", "section"]))
            case 1:
                playhead.advance(chance.choice(["measure", "section"]))
            case 2:
                playhead.hold(not playhead.held)
            case 3:
                playhead.loop(chance.choice([None, (1, 5)]))
        measure = playhead.measure
        foreseen = [(playhead.place(m), playhead.entered(m), playhead.jumped(m)) for m in range(measure, measure + 9)]
        for offset in range(1, 1 + chance.randrange(1, 8)):
            playhead.begin_measure(measure + offset)
            now = playhead.place(measure + offset)
            assert (now, playhead.entered(measure + offset), playhead.jumped(measure + offset)) == foreseen[offset]
            if playhead.entered(measure + offset) and now != foreseen[offset - 1][0] and now.turn >= begun[now.section]:
                assert now.turn == begun[now.section]
                begun[now.section] += 1


def test_recent_measures_are_remembered():
    playhead = Playhead(SONG)
    seen = {}
    for measure in itertools.chain(range(6)):
        playhead.begin_measure(measure)
        seen[measure] = playhead.place(measure)
    assert [playhead.place(measure) for measure in (3, 4, 5)] == [seen[3], seen[4], seen[5]]


def test_edited_score_continues_by_section_name():
    playhead = Playhead([SectionTiming("a", 4, 1, 1), SectionTiming("b", 4, 1, 0)])
    for measure in range(7):
        playhead.begin_measure(measure)
    assert playhead.place(6) == Place(1, 2)
    playhead.jump(0, when="section")
    playhead.apply_patch(
        Playhead([SectionTiming("new", 2, 1, 1), SectionTiming("B", 8, 1, 2), SectionTiming("a", 3, 1, 0)])
    )
    assert [playhead.place(n) for n in (6, 7, 11)] == [Place(1, 2), Place(1, 3), Place(1, 7)]
    assert playhead.place(12) == Place(2, 0, 1)  # the jump that waits goes to where "a" is now
    playhead.apply_patch(Playhead([SectionTiming("b", 2, 1, 0)]))  # measure 3 of 2, and its jump leads nowhere
    assert [playhead.place(n) for n in (6, 7, 8)] == [Place(0, 0), Place(0, 1), Place(0, 0, 1)]


def test_removed_section_keeps_the_written_measure():
    playhead = Playhead([SectionTiming("", None)])
    for measure in range(6):
        playhead.begin_measure(measure)
    playhead.apply_patch(Playhead([SectionTiming("a", 4, 1, 1), SectionTiming("b", 4, 1, 0)]))
    assert playhead.place(5) == Place(1, 1)
    playhead.apply_patch(Playhead([SectionTiming("c", 2, 1, 0)]))
    assert [playhead.place(n).measure for n in (5, 6, 7)] == [0, 1, 0]
