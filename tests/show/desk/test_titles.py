"""Titles and planes in the show: entrances on the beat, ends, replacement, cues, snapshots, ages."""

from pathlib import Path

import pytest

from live.base.errors import PersonError
from live.base.picture_parameters import BY_ADDRESS
from live.clock.ticks import TICK
from live.control.registry.registry import REGISTRY
from live.show.desk.titles import EXIT_BEATS, MAX_SHOWN, clean_text
from live.show.loader import LoadedShow
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_search_path import PatchError
from live.show.state.snapshot import Snapshotter, restore
from live.show.view.render_scene import make_backgrounds, make_fonts, make_scene
from tests.show.made_show import GRAPH, PATCH, made_show

TITLES = """
[[title]]
name = "Opening"
text = "DESIRE LINES"
place = "behind"
at = [1.0, 2.5]
size = 1.5
colour = [0.5, 0.25, 1.0]
brightness = 2.0
entrance = "rise"
measures = 1
hold = 2

[[title]]
name = "line"
place = "front"
entrance = "cut"
measures = 0
"""


class TitleSession:
    """A show run tick by tick."""

    def __init__(self, extra=TITLES):
        self.show, self.index = made_show(extra), 0

    def call(self, address, *values):
        event = REGISTRY.call(address, values, self.show.time, "osc")
        return self.show.apply(event)

    def run(self, beats):
        goal = self.beat + beats
        while self.beat < goal - 1e-9:
            self.index += 1
            self.show.tick(self.index * TICK)

    @property
    def beat(self):
        return self.show.timeline.beat_at(self.show.time)

    def seen(self):
        return self.show.desk.titles.seen_at(self.beat)


def test_title_enters_on_the_next_beat_holds_and_fades_out():
    session = TitleSession()
    session.run(1.3)
    assert session.call("/dance/title", "opening")
    assert session.seen() == ()
    session.run(0.6)
    assert session.seen() == ()  # beat 2 has not come
    session.run(1.1)  # beat 3: one of four beats of the entrance
    (title,) = session.seen()
    assert (title.text, title.place, title.at) == ("DESIRE LINES", "stage", (1.0, 2.5, -5.0))
    assert title.colour == pytest.approx((1.0, 0.5, 2.0))
    assert title.progress == pytest.approx(0.25, abs=0.02)
    session.run(3.5)
    assert session.seen()[0].progress == 1.0
    assert session.seen()[0].level == 1.0
    session.run(8.0)  # entrance of 4 beats, then 8: from beat 14 on it fades
    assert 0.5 < session.seen()[0].level < 1.0
    session.run(EXIT_BEATS)
    assert session.seen() == ()


def test_any_text_is_shown_in_a_style_and_replaces_the_one_before_it():
    session = TitleSession()
    assert session.call("/dance/title", "first words", "line")
    session.run(1.1)
    assert [title.text for title in session.seen()] == ["first words"]
    assert session.call("/dance/title", "second | words", "line")
    session.run(1.5)
    first, second = session.seen()
    assert first.level < 1.0
    assert (second.text, second.level) == ("second | words", 1.0)
    session.run(2.0)
    assert [title.text for title in session.seen()] == ["second | words"]
    assert session.call("/dance/title/hide")
    session.run(1.0 + EXIT_BEATS)
    assert session.seen() == ()


def test_titles_need_no_table_and_unknown_names_are_refused():
    session = TitleSession("")
    assert session.call("/dance/title", "plain")
    session.run(8.0)
    (title,) = session.seen()
    assert (title.text, title.place, title.progress) == ("plain", "picture", 1.0)
    assert not session.call("/dance/title", "x", "nobody")
    assert "no title is called 'nobody'" in session.show.refusals.last_reason
    assert not session.call("/dance/title/hide", "other")
    for number in range(2 * MAX_SHOWN):
        session.call("/dance/title", f"title {number}")
    assert len(session.show.desk.titles.shown) == MAX_SHOWN


def test_panic_takes_titles_and_cues_show_them():
    session = TitleSession(
        TITLES + '[[cue]]\nname = "one"\nwhen = "now"\ncalls = [["/dance/title", "opening"], ["/dance/word", "hope"]]\n'
    )
    assert session.call("/dance/go")
    session.run(2.0)
    assert [title.text for title in session.seen()] == ["DESIRE LINES"]
    view = session.show.view()
    session.show.fill(view, session.show.time)
    assert [title.text for title in view.titles] == ["hope", "DESIRE LINES"]
    assert session.call("/dance/panic")
    session.run(EXIT_BEATS + 0.5)
    assert session.seen() == ()


def test_restored_show_has_the_same_titles():
    session = TitleSession()
    session.call("/dance/title", "opening")
    session.call("/dance/word", "sea")
    session.run(2.0)
    source = Snapshotter(session.show)
    while (taken := source.capture(session.index)) is None:
        session.run(1 / 32)
    again = restore(LoadedShow(Path("a.toml"), parse_patch(PATCH + TITLES, "a.toml"), GRAPH), taken.seal())
    assert again.desk.titles.shown == session.show.desk.titles.shown
    assert again.audience.words.shown == session.show.audience.words.shown
    for show in (session.show, again):
        show.tick((session.index + 1) * TICK)
    views = [show.view() for show in (session.show, again)]
    for show, view in zip((session.show, again), views, strict=True):
        show.fill(view, show.time)
    assert views[0].titles == views[1].titles
    assert len(views[0].titles) == 2


def test_background_age_counts_from_when_it_was_dark():
    session = TitleSession()
    session.run(2.0)
    age = session.show.desk.background_age
    assert not age.any()
    session.call("/dance/background/2", 0.5)
    session.run(3.0)
    assert age[1] == pytest.approx((3.0 * 60.0 / session.show.timeline.tempo, 3.0), abs=0.1)
    assert not age[[0, *range(2, 8)]].any()
    session.call("/dance/background/2", 0.0)
    session.run(0.5)
    assert not age.any()


def test_background_replaces_only_those_at_its_place():
    tables = "".join(
        f'[[background]]\nname = "{name}"\nfile = "{name}.png"\nplace = "{place}"\n'
        for name, place in (("sky", "behind"), ("sea", "behind"), ("tiles", "floor"), ("rain", "front"))
    )
    session = TitleSession(tables)

    def amounts():
        session.run(0.2)
        row = session.show.desk.parameters.picture
        return [float(row[BY_ADDRESS[f"/dance/background/{number}"].first]) for number in range(1, 5)]

    for name in ("sky", "tiles", "rain"):
        session.call("/dance/background", name)
    assert amounts() == [1.0, 0.0, 1.0, 1.0]
    session.call("/dance/background", "sea")
    assert amounts() == [0.0, 1.0, 1.0, 1.0]
    session.call("/dance/background", "none")
    assert amounts() == [0.0] * 4


def test_text_is_cleaned():
    assert clean_text("  e\u0301te\u0301 \n\t au  lac ") == "été au lac"
    assert clean_text("a\u202eb\x07") == "a b"


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ('[[background]]\nname = "a"\n', "needs a file or an input"),
        ('[[background]]\nname = "a"\nfile = "a.png"\ninput = "camera:0"\n', "one of them only"),
        ('[[background]]\nname = "a"\ninput = "tv"\n', "no live input"),
        ('[[background]]\nname = "a"\nfile = "a.png"\nplace = "floor"\nfit = "picture"\n', "cannot fill the picture"),
        ('[[scenery]]\nname = "a"\nfile = "a.glb"\nheight = 0\n', "height"),
        ('[[title]]\nname = "a"\n[[title]]\nname = "A"\n', "two titles are called"),
        ("[words]\nbottom = 3\ntop = 2\n", "has to be above"),
    ],
)
def test_wrong_tables_are_refused_with_reason(table, words):
    with pytest.raises(PatchError, match=words):
        parse_patch(PATCH + table, "a.toml")


def test_missing_and_damaged_files_are_told_with_their_line(tmp_path):
    path = tmp_path / "a.toml"
    (tmp_path / "bad.glb").write_bytes(b"bad")
    (tmp_path / "bad.ttf").write_bytes(b"bad")
    for table, words in (
        ('[[scenery]]\nname = "a"\nfile = "none.glb"\n', "no 'none.glb'"),
        ('[[scenery]]\nname = "a"\nfile = "bad.glb"\n', "'bad.glb'"),
        ('[[background]]\nname = "a"\nfile = "rain_##.png"\n', "no image 'rain_##.png'"),
        ('[[title]]\nname = "a"\nfont = "bad.ttf"\n', "no font"),
    ):
        patch = parse_patch(PATCH + table, "a.toml")
        with pytest.raises(PersonError, match=words) as raised:
            make_scene(patch, path)
        assert raised.value.key_path[-1] in ("file", "font")
        assert make_scene(patch, path, whole=False) is not None  # a show that goes on leaves it out
    live = parse_patch(PATCH + '[[background]]\nname = "a"\ninput = "camera:0"\n', "a.toml")
    assert make_backgrounds(live, path)[0].input == "camera:0"
    assert make_fonts(live, path) == ()
