"""Test cards and warping at the windows: handled keys, selected outputs, saved values."""

from types import SimpleNamespace

import pytest

from live.app.output_config import VenueWriter
from live.app.projector_setup import OutputSetup
from live.control.events.events import ShowCard
from live.render.outputs.output import FULL_WINDOW, Output
from live.render.outputs.warp_editor import FloorEditor, WarpEditor
from live.render.window.window_input import KeyPressed, PointerMoved, PointerPressed, PointerReleased
from live.show.venue.venue import read_venue


class FakeScreen:
    """A screen of 1000 x 500 pixels without a window."""

    def __init__(self, name):
        self.output, self.card, self.editing, self.lines = Output(name), "off", None, ()
        monitor = SimpleNamespace(name="DP-1")
        self.window = SimpleNamespace(size=(1000, 500), monitor=monitor, on_monitor=True)

    def set(self, output):
        self.output = output

    def edit(self, on):
        self.editing = WarpEditor(self.output) if on else None

    def edit_floor(self, corners):
        self.editing = FloorEditor(self.output, corners)


class FakeFloor:
    """The position of the real floor in the picture."""

    def __init__(self):
        self.kept, self.words = [], ""

    def corners(self):
        return (0.2, 0.4), (0.8, 0.4), (0.9, 0.9), (0.1, 0.9)

    def save(self, corners):
        self.kept.append(corners)
        return self.words


@pytest.fixture
def hall():
    left, right, desk = FakeScreen("left"), FakeScreen("right"), FakeScreen("operator")
    kept, refused, asked = [], [], []
    floor = FakeFloor()
    setup = OutputSetup(
        SimpleNamespace(screens=[left, right]), kept.append, refused.append, lambda *words: asked.append(words), floor
    )
    return SimpleNamespace(
        setup=setup, left=left, right=right, desk=desk, kept=kept, refused=refused, asked=asked, floor=floor
    )


def press(hall, screen, *names, shift=False):
    return [hall.setup.handle_input(screen, KeyPressed(name, shift)) for name in names]


def test_show_keys_are_not_handled_by_setup(hall):
    assert press(hall, hall.left, "space", "b", "tab", "left", "m", "enter", "escape") == [False] * 7
    press(hall, hall.left, "f9")
    assert press(hall, hall.left, "space", "b") == [False] * 2
    assert press(hall, hall.left, "tab", "left", "m", "enter", "escape") == [True] * 5
    assert press(hall, hall.left, "left") == [False]


def test_arrows_move_corner_by_pixels_and_leaving_saves(hall):
    press(hall, hall.left, "f9", "tab", "down")
    press(hall, hall.left, "left", shift=True)
    assert hall.left.output.corners[1] == pytest.approx((0.99, 0.002))
    assert "left: corner 2 of 4" in hall.left.lines
    assert hall.kept == []
    press(hall, hall.left, "f9")
    assert hall.kept == [hall.left.output]
    assert hall.left.editing is None


def test_mouse_moves_only_edited_output(hall):
    drag = [PointerPressed(5, 5), PointerMoved(100, 50), PointerReleased(100, 50)]
    assert [hall.setup.handle_input(hall.left, value) for value in drag] == [False] * 3
    press(hall, hall.left, "f9")
    assert [hall.setup.handle_input(hall.right, value) for value in drag] == [False] * 3
    assert [hall.setup.handle_input(hall.left, value) for value in drag] == [True] * 3
    assert hall.left.output.corners[0] == (0.1, 0.1)
    assert hall.right.output.corners == FULL_WINDOW
    press(hall, hall.left, "u")
    assert hall.left.output.corners == FULL_WINDOW


def test_operator_window_edits_outputs_in_turn(hall):
    seen = []
    for _ in range(3):
        press(hall, hall.desk, "f9")
        press(hall, hall.desk, "right")
        seen.append([one.editing is not None for one in (hall.left, hall.right)])
    assert seen == [[True, False], [False, True], [False, False]]
    assert [one.name for one in hall.kept] == ["left", "right"]


def test_real_floor_corners_are_marked_on_projector(hall):
    hall.left.output = Output("left", crop=(0.0, 0.0, 0.5, 1.0), corners=((0.1, 0), (1, 0), (1, 1), (0.1, 1)))
    press(hall, hall.left, "f9", "p")
    assert hall.left.lines[0] == "left: the floor's back left corner"
    at = 100 + 0.4 * 900, 0.4 * 500  # of the window: 0.2 of the picture is 0.4 of what this output shows
    for value in (PointerPressed(*at), PointerMoved(at[0] + 90, at[1] + 25), PointerReleased(0, 0)):
        assert hall.setup.handle_input(hall.left, value)
    press(hall, hall.left, "tab", "down", shift=False)
    assert hall.floor.kept == []
    press(hall, hall.left, "enter")
    (corners,) = hall.floor.kept
    assert corners[0] == pytest.approx((0.25, 0.45))
    assert corners[2:] == [(0.9, 0.9), (0.1, 0.9)]
    assert hall.left.lines[0] == "left: the floor's back right corner"
    press(hall, hall.left, "p")  # back, with nothing new to keep
    assert isinstance(hall.left.editing, WarpEditor)
    assert len(hall.floor.kept) == 1
    assert hall.kept == []
    assert hall.left.output.mesh == ()


def test_floor_without_area_is_refused_and_save_failure_is_reported(hall):
    press(hall, hall.left, "f9", "p")
    before = hall.left.editing.corners
    (x, y), (there, _) = before[0], before[1]
    for value in (PointerPressed(x * 1000, y * 500), PointerMoved(there * 1000, y * 500)):
        hall.setup.handle_input(hall.left, value)
    assert hall.left.editing.corners == before
    assert "span no floor" in hall.left.lines[-1]
    hall.setup.handle_input(hall.left, PointerMoved(300, 150))
    hall.floor.words = "NOT SAVED: for a reason"
    press(hall, hall.left, "enter")
    assert hall.left.lines[-1] == "NOT SAVED: for a reason"
    assert hall.left.editing.is_changed
    press(hall, hall.left, "u", "u")
    assert hall.left.editing.corners == before
    press(hall, hall.left, "left", "r")
    assert hall.left.editing.corners == before


def test_unchanged_output_is_not_saved(hall):
    press(hall, hall.left, "f9", "tab", "m", "m", "f9")
    assert [one.mesh for one in hall.kept] == [hall.left.output.mesh]
    press(hall, hall.left, "f9", "tab", "f9")
    assert len(hall.kept) == 1


def test_cards_are_selected_by_key_and_by_osc(hall):
    press(hall, hall.left, "f8", "f8")
    assert (hall.left.card, hall.right.card) == ("bars", "off")
    hall.setup.handle(ShowCard(time=0.0, source="osc", output="RIGHT", card="focus"))
    assert hall.right.card == "focus"
    hall.setup.handle(ShowCard(time=0.0, source="osc", output="*", card="off"))
    assert (hall.left.card, hall.right.card) == ("off", "off")
    press(hall, hall.desk, "f8")
    assert (hall.left.card, hall.right.card) == ("grid", "grid")
    assert [one["card"] for one in hall.setup.facts()] == ["grid", "grid"]
    assert hall.asked == [("left", "grid"), ("left", "bars"), ("left", "grid"), ("right", "grid")]


def test_resumed_show_restores_cards(hall):
    hall.setup.restore_cards({"*": "grid", "left": "focus", "gone": "bars"})
    assert (hall.left.card, hall.right.card) == ("focus", "grid")
    hall.setup.restore_cards({"right": "off", "left": "smiley"})
    assert (hall.left.card, hall.right.card) == ("focus", "off")


@pytest.mark.parametrize(("output", "card", "words"), [("middle", "grid", "left, right"), ("left", "smiley", "focus")])
def test_unknown_output_or_card_is_refused(hall, output, card, words):
    hall.setup.handle(ShowCard(time=0.0, source="osc", output=output, card=card))
    assert words in hall.refused[0]
    assert hall.left.card == "off"


def test_saved_output_is_read_from_venue(tmp_path, monkeypatch):
    monkeypatch.setenv("LIVE_CONFIG_DIR", str(tmp_path))
    told = []
    keeping = VenueWriter("hall", told.append)
    keeping.save_output(Output("left", corners=((0.1, 0.1), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))))
    keeping.wait()
    assert told == [f"saved in {tmp_path / 'venues' / 'hall.toml'}"]
    assert read_venue("hall").output[0].corners[0] == (0.1, 0.1)
    assert [path.name for path in (tmp_path / "venues").iterdir()] == ["hall.toml"]


def test_save_failure_is_reported_and_file_is_unchanged(tmp_path, monkeypatch):
    monkeypatch.setenv("LIVE_CONFIG_DIR", str(tmp_path))
    (tmp_path / "venues").mkdir()
    path = tmp_path / "venues" / "hall.toml"
    path.write_text("name = 3\n")
    told = []
    keeping = VenueWriter("hall", told.append)
    keeping.save_output(Output("left"))
    keeping.wait()
    assert told[0].startswith("NOT SAVED: ")
    assert "line 1: name" in told[0]
    assert path.read_text() == "name = 3\n"
    VenueWriter(None, told.append).save_output(Output())
    assert told[1] == "not saved: start with --venue NAME"
