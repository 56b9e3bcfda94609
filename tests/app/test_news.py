"""News: an operator without the overlay reads what was refused and what has joined, each once."""

import threading

from live.app.session import Notifier


class Part:
    """Something that refuses, or tells."""

    def __init__(self):
        self.words = ""

    def __call__(self):
        return self.words


def made_news():
    osc, show, library, said = Part(), Part(), Part(), []
    return Notifier([osc, show], [library], said.append), osc, show, library, said


def test_each_change_is_said_once():
    news, osc, show, library, said = made_news()
    news.check()
    assert said == []
    show.words, library.words = "there is no step 'sambaa'", "new steps: bow can be danced"
    news.check()
    news.check()
    assert said == ["refused: there is no step 'sambaa'", "new steps: bow can be danced"]
    osc.words, show.words = "unknown address", "no group is called 'b'"
    news.check()
    assert said[2:] == ["refused: unknown address", "refused: no group is called 'b'"]


def test_the_last_refusal_is_the_newest_of_all_parts():
    """An old refusal of one part hides no new one of another, and what is mended is not the last any more."""
    news, osc, show, library, _ = made_news()
    for part, words in ((osc, "first"), (show, "second"), (osc, "third"), (show, "fourth")):
        part.words = words
        news.check()
        assert news.refused == words
    library.words = "new steps: bow can be danced"
    news.check()
    assert news.refused == "fourth"
    osc.words = ""
    news.check()
    assert news.refused == "fourth"
    show.words = ""
    news.check()
    assert news.refused == ""


def test_what_is_new_at_the_end_is_said_and_the_thread_ends():
    news, _, show, _, said = made_news()
    threads = threading.active_count()
    news.start()
    show.words = "too late for the last look"
    news.stop()
    assert said == ["refused: too late for the last look"]
    assert threading.active_count() == threads


def test_without_a_start_it_can_be_stopped():
    news, *_, said = made_news()
    news.stop()
    assert said == []
