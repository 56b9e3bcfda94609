"""The audience's words: what is refused, what waits, who approves, where they stand, and how they go."""

import itertools
import unicodedata

import pytest

from live.base.errors import PersonError
from live.clock.ticks import TICK
from live.control.events import events
from live.control.registry.registry import REGISTRY
from live.show.audience.words import FADE_BEATS, GATHER_BEATS, MAX_WAITING, check_word
from live.show.view.status import Status
from tests.show.made_show import made_show

BLOCKED = '[words]\nblocked = ["Scheiße", "bad word"]\n'


class WordSession:
    """A show run tick by tick."""

    def __init__(self, extra=""):
        self.show, self.index = made_show(extra), 0

    @property
    def words(self):
        return self.show.audience.words

    @property
    def beat(self):
        return self.show.timeline.beat_at(self.show.time)

    def call(self, address, *values):
        return self.show.apply(REGISTRY.call(address, values, self.show.time, "osc"))

    def run(self, beats):
        goal = self.beat + beats
        while self.beat < goal - 1e-9:
            self.index += 1
            self.show.tick(self.index * TICK)

    def texts(self):
        return [title.text for title in self.words.seen_at(self.beat)]


@pytest.mark.parametrize("word", ["hope", "  l'été ", "être-là", "mer d’or", "Жизнь", "希望", "e\u0301t\u0301"])
def test_words_of_letters_are_taken(word):
    assert check_word(word, ()) == " ".join(unicodedata.normalize("NFC", word).split())


@pytest.mark.parametrize(
    "word", ["", "   ", "x" * 25, "www.a.com", "a@b", "7", "<b>", "a|b", "\u202eevil1", "💥", "'-'", "a\x00b;"]
)
def test_other_signs_and_lengths_are_refused(word):
    with pytest.raises(PersonError):
        check_word(word, ())


@pytest.mark.parametrize(
    "word", ["SCHEISSE", "scheiße", "scheisse", "s-c-h-e-i-ß-e", "Bad Wörd", "badword", "abadwordly"]
)
def test_blocked_words_are_found_in_any_spelling(word):
    with pytest.raises(PersonError, match="blocks"):
        check_word(word, ("Scheiße", "bad word"))


def test_offered_words_wait_until_they_are_approved():
    session = WordSession(BLOCKED)
    assert session.call("/dance/word/offer", "hope")
    assert session.call("/dance/word/offer", "HOPE")  # the same word once
    assert session.call("/dance/word/offer", "fire")
    assert not session.call("/dance/word/offer", "bad word")
    assert session.words.facts() == {"waiting": ["hope", "fire"], "shown": [], "refused": 1}
    session.run(4.0)
    assert session.texts() == []
    status = Status(session.show, rejected=dict, memory=lambda: 0.0)
    assert status.snapshot(session.show.time)["words"]["waiting"] == ["hope", "fire"]
    assert "words wait: hope, fire" in status.overlay(session.show.time)
    assert session.call("/dance/word/approve", "Hope")
    assert session.call("/dance/word/reject", "fire")
    assert not session.call("/dance/word/approve", "fire")
    session.run(1.0)
    assert session.texts() == ["hope"]
    assert session.words.waiting == []
    for number in range(MAX_WAITING + 10):
        session.call("/dance/word/offer", "a" + chr(97 + number // 26) + chr(97 + number % 26))
    assert len(session.words.waiting) == MAX_WAITING
    session.call("/dance/word/clear")
    session.run(FADE_BEATS + 0.5)
    assert (session.words.waiting, session.texts()) == ([], [])


def test_patch_may_show_all_offered_words_at_once():
    session = WordSession('[words]\naccept = "all"\nblocked = ["bad"]\n')
    assert session.call("/dance/word/offer", "sea")
    assert not session.call("/dance/word/offer", "Bad")
    assert session.texts() == ["sea"]


def test_words_gather_without_covering_each_other_and_the_oldest_goes():
    session = WordSession("[words]\nmost = 12\nbeats = 0\n")
    for number in range(12):
        assert session.call("/dance/word", "word " + "abcdefghijkl"[number])
    session.run(GATHER_BEATS + 0.5)
    titles = session.words.seen_at(session.beat)
    for title, one in zip(titles, session.words.shown, strict=True):
        assert title.at == pytest.approx(one.title.at)  # it is in its place
    for one, other in itertools.combinations(titles, 2):
        apart_x = abs(one.at[0] - other.at[0]) - 0.5 * 0.95 * (one.size * len(one.text) + other.size * len(other.text))
        apart_y = abs(one.at[1] - other.at[1]) - 0.5 * 1.5 * (one.size + other.size)
        assert apart_x > -1e-6 or apart_y > -1e-6
    assert all(title.at[2] < -4.0 for title in titles)  # behind the stage's back edge
    session.call("/dance/word", "new")
    session.run(FADE_BEATS + 0.5)
    assert len(session.texts()) == 12
    assert "word a" not in session.texts()


def test_rain_falls_evenly_and_ends_on_the_floor():
    session = WordSession('[words]\nform = "rain"\nbeats = 8\nbottom = 0\ntop = 5\n')
    session.call("/dance/word", "rain")
    heights = []
    for _ in range(4):
        session.run(2.0)
        heights.append(session.words.seen_at(session.beat)[0].at[1])
    steps = [a - b for a, b in itertools.pairwise(heights)]
    assert min(steps) == pytest.approx(max(steps), rel=0.05)
    assert heights[-1] == pytest.approx(0.5 * session.words.shown[0].title.size, abs=0.1)
    session.run(FADE_BEATS + 0.5)
    assert session.texts() == []


def test_words_are_the_same_in_every_run():
    one, other = WordSession(), WordSession()
    for session in (one, other):
        for word in ("sea", "salt", "wind"):
            session.call("/dance/word", word)
            session.run(1.0)
    assert one.words.shown == other.words.shown
    assert len({shown.title.at for shown in one.words.shown}) == 3


def test_winner_of_a_vote_on_words_is_shown():
    session = WordSession('[words]\nvote = ["sea", "fire"]\n[audience]\nvote_measures = 1\n')
    assert session.call("/dance/audience/vote", "word", "sea", "Fire")
    assert not session.call("/dance/audience/vote", "word", "sea", "other")
    session.run(0.5)
    number = session.show.audience.vote.number
    session.show.apply(
        events.AudienceHeard(
            time=session.show.time, source="audience", phones=9, order=session.show.audience.command_count,
            votes=(number, 100, 300),
        )
    )  # fmt: skip
    session.run(9.0)
    assert session.texts() == ["fire"]
