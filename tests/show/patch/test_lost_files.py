"""Files that are lost while a show runs: a restart with `whole=False` needs none of them."""

import pytest

from live.base.errors import PersonError
from live.show.loader import LoadedShow, load_show
from tests.show.made_show import GRAPH

PATCH = """name = "lost"
reserve = 0
[clock]
bpm = 120
[[background]]
name = "wall"
file = "gone.png"
[[character]]
name = "anna"
file = "gone.glb"
[[group]]
name = "all"
dancers = 4
steps = ["sway"]
"""


def test_show_without_files_is_refused_but_can_continue(tmp_path, monkeypatch):
    path = tmp_path / "show.toml"
    path.write_text(PATCH)
    monkeypatch.setattr(
        "live.show.loader.load_from_patch", lambda patch, path, **options: LoadedShow(path, patch, GRAPH)
    )
    with pytest.raises(PersonError, match=r"line 10: character\.1\.file"):
        load_show(path)
    loaded = load_show(path, whole=False)
    with pytest.raises(PersonError, match=r"gone"):
        loaded.scene()
    scene = loaded.scene(whole=False)
    assert [one.file for one in scene.backgrounds] == [""]
    assert scene.characters == ()
    assert set(scene.bodies) == {"dancer"}
