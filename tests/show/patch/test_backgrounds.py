"""Backgrounds of a patch: errors before the show, and switching by name."""

import pytest

from live.base.errors import PersonError
from live.base.picture_parameters import BY_ADDRESS
from live.show.loader import load_show
from live.show.patch.patch_search_path import DEFAULT_PATCH
from tests.render.media import write_image
from tests.show.desk.desk_show import DESK, DeskSession

TWO = DESK + '[[background]]\nname = "sea"\nfile = "sea.png"\n[[background]]\nname = "town"\nfile = "t.png"\nseen = 1\n'


def test_selected_background_fades_in_and_others_fade_out():
    hands = DeskSession(TWO).run(beats=1)
    assert (hands.value("/dance/background/1"), hands.value("/dance/background/2")) == (0.0, 1.0)
    hands.say("/dance/background", "Sea", 1)
    hands.run(beats=2)
    assert 0.2 < hands.value("/dance/background/1") < 0.8
    hands.run(beats=3)
    assert (hands.value("/dance/background/1"), hands.value("/dance/background/2")) == (1.0, 0.0)
    hands.say("/dance/background", "none")
    assert hands.run(beats=1).value("/dance/background/1") == 0.0
    assert not hands.say("/dance/background", "moon")
    assert "moon" in str(hands.words)
    assert "sea, town, none" in str(hands.words)


@pytest.mark.long
def test_missing_and_broken_files_are_reported_with_file_and_line(tmp_path):
    patch = tmp_path / "my.toml"
    text = DEFAULT_PATCH.read_text(encoding="utf-8")
    line = len(text.splitlines()) + 3
    patch.write_text(text + '[[background]]\nname = "a"\nfile = "sea.png"\n', encoding="utf-8")
    with pytest.raises(PersonError, match=rf"my.toml, line {line}.*sea.png"):
        load_show(patch).scene()
    (tmp_path / "sea.png").write_bytes(b"no image")
    with pytest.raises(PersonError, match=rf"my.toml, line {line}.*cannot be read"):
        load_show(patch).scene()
    write_image(tmp_path / "sea.png")
    assert load_show(patch).scene().backgrounds[0].file == str(tmp_path / "sea.png")
    assert BY_ADDRESS["/dance/background/1"].size == 1
