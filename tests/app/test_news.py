"""News: an operator without the overlay reads refusals and joined parts, each once."""

import threading

from live.app.session import Notifier


class MessageSource:
    """A source of refusals or messages."""

    def __init__(self):
        self.words = ""

    def __call__(self):
        return self.words


def make_news():
    osc, show, library, said = MessageSource(), MessageSource(), MessageSource(), []
    return Notifier([osc, show], [library], said.append), osc, show, library, said


def test_each_change_is_printed_once():
    news, osc, show, library, said = make_news()
    news.check()
    assert said == []
    show.words, library.words = "there is no step 'sambaa'", "new steps: bow can be danced"
    news.check()
    news.check()
    assert said == ["refused: there is no step 'sambaa'", "new steps: bow can be danced"]
    osc.words, show.words = "unknown address", "no group is called 'b'"
    news.check()
    assert said[2:] == ["refused: unknown address", "refused: no group is called 'b'"]


def test_last_refusal_is_newest_of_all_sources():
    """An old refusal of one source hides no new one of another, and a resolved refusal is no longer the last."""
    news, osc, show, library, _ = make_news()
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


def test_final_change_is_printed_and_thread_ends():
    news, _, show, _, said = make_news()
    threads = threading.active_count()
    news.start()
    show.words = "too late for the last look"
    news.stop()
    assert said == ["refused: too late for the last look"]
    assert threading.active_count() == threads


def test_notifier_stops_without_start():
    news, *_, said = make_news()
    news.stop()
    assert said == []
