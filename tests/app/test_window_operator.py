"""The operator at the window: keys and pointer become events, or change the window."""

from types import SimpleNamespace

import pytest

from live.app.window_operator import OperatorInput
from live.base.event_queue import EventQueue
from live.base.stage_snapshot import Camera, Scene
from live.control.events import events
from live.render.camera import project_points
from live.render.window.window_input import (
    CloseRequested,
    KeyPressed,
    MonitorsChanged,
    PointerMoved,
    PointerPressed,
    PointerReleased,
)

SIZE = (1280, 720)
SCENE = Scene((12.0, 8.0), Camera(), 1, 22)


class FakeWindow:
    """The window attributes used by the operator input."""

    size = SIZE
    fullscreen = False

    def toggle_fullscreen(self):
        self.fullscreen = not self.fullscreen


@pytest.fixture
def desk():
    inbox = EventQueue()
    patch = SimpleNamespace(formation=({"name": "wedge"}, {"name": "star"}))
    desk_ = SimpleNamespace(held=False, master=SimpleNamespace(frozen=False, goal=1.0, cards={}))
    session = SimpleNamespace(
        inbox=inbox,
        engine=SimpleNamespace(overlay=False, view=SimpleNamespace(picture=None)),
        show=SimpleNamespace(blackout=False, follower=SimpleNamespace(held=False), desk=desk_, patch=patch),
        status=SimpleNamespace(tool=""),
        midi=SimpleNamespace(learning=SimpleNamespace(pending_control="")),
    )
    window = FakeWindow()
    return SimpleNamespace(operator=OperatorInput(session, window, SCENE), inbox=inbox, session=session, window=window)


@pytest.mark.parametrize(
    ("name", "event"),
    [
        ("space", events.Tap(time=2.0, source="key")),
        ("1", events.One(time=2.0, source="key")),
        ("b", events.Blackout(time=2.0, source="key", on=True)),
        ("s", events.PlaceElement(time=2.0, source="key", kind="spread")),
    ],
)
def test_keys_post_events(desk, name, event):
    desk.operator.handle(KeyPressed(name), 2.0)
    assert desk.inbox.drain() == [event]


def test_b_key_ends_blackout(desk):
    desk.session.show.blackout = True
    desk.operator.handle(KeyPressed("b"), 2.0)
    assert desk.inbox.drain() == [events.Blackout(time=2.0, source="key", on=False)]


def test_z_key_holds_and_releases_tempo(desk):
    desk.operator.handle(KeyPressed("z"), 2.0)
    desk.session.show.follower.held = True
    desk.operator.handle(KeyPressed("z"), 2.0)
    assert [event.on for event in desk.inbox.drain()] == [True, False]


def test_arrow_and_punctuation_keys_nudge_and_shift_beat(desk):
    for name in ("left", "right", ",", ".", "j"):
        desk.operator.handle(KeyPressed(name), 2.0)
    pressed = desk.inbox.drain()
    assert [event.seconds for event in pressed[:2]] == [-0.01, 0.01]
    assert [event.beats for event in pressed[2:]] == [-1.0, 1.0, 0.5]


def test_f_and_o_keys_change_window_only(desk):
    desk.operator.handle(KeyPressed("f"), 2.0)
    desk.operator.handle(KeyPressed("o"), 2.0)
    assert desk.window.fullscreen
    assert desk.session.engine.overlay
    desk.operator.handle(KeyPressed("f12"), 2.0)
    desk.operator.handle(MonitorsChanged(), 2.0)
    assert desk.inbox.drain() == []
    assert not desk.operator.close_requested


def test_escape_never_ends_fullscreen_show(desk):
    desk.window.fullscreen = True
    desk.operator.handle(KeyPressed("escape"), 2.0)
    assert not desk.operator.close_requested
    desk.window.fullscreen = False
    desk.operator.handle(KeyPressed("escape"), 2.0)
    assert desk.operator.close_requested


def test_closed_window_ends_show(desk):
    desk.operator.handle(CloseRequested(), 2.0)
    assert desk.operator.close_requested


def test_drag_posts_attractor_on_floor_and_shift_posts_repulsor(desk):
    def pixel(x, z):
        return project_points(SCENE.camera, SIZE, [[x, 0.0, z]])[0]

    desk.operator.handle(PointerMoved(*pixel(0, 0)), 1.0)  # not pressed: nothing
    desk.operator.handle(PointerPressed(*pixel(1.5, -0.5)), 1.1)
    desk.operator.handle(PointerMoved(*pixel(2.0, 1.0)), 1.2)
    desk.operator.handle(PointerReleased(*pixel(2.0, 1.0)), 1.3)
    desk.operator.handle(PointerMoved(*pixel(3.0, 1.0)), 1.4)
    desk.operator.handle(PointerPressed(*pixel(-2.0, 1.0), shift=True), 1.5)
    desk.operator.handle(PointerPressed(640.0, 1.0), 1.6)  # the back wall is no floor
    first, second, third = desk.inbox.drain()
    assert [event.kind for event in (first, second, third)] == ["attract", "attract", "repel"]
    assert first.points[0] == pytest.approx((1.5, -0.5), abs=1e-6)
    assert second.points[0] == pytest.approx((2.0, 1.0), abs=1e-6)
    assert (third.points[0], third.source) == (pytest.approx((-2.0, 1.0)), "pointer")


def test_tool_key_selects_element_placed_by_stroke_on_release(desk):
    def pixel(x, z):
        return project_points(SCENE.camera, SIZE, [[x, 0.0, z]])[0]

    desk.operator.handle(KeyPressed("x"), 1.0)
    desk.operator.handle(PointerPressed(*pixel(-1.0, 0.0)), 1.1)
    desk.operator.handle(PointerMoved(*pixel(0.5, 0.5)), 1.2)
    desk.operator.handle(PointerMoved(*pixel(1.0, 0.0)), 1.3)
    assert not desk.inbox.drain()
    desk.operator.handle(PointerReleased(*pixel(1.0, 0.0)), 1.4)
    (event,) = desk.inbox.drain()
    assert event.kind == "cross"
    assert sum(event.points, ()) == pytest.approx((-1.0, 0.0, 1.0, 0.0), abs=1e-5)
    desk.operator.handle(KeyPressed("a"), 2.0)
    desk.operator.handle(PointerPressed(*pixel(1.0, 0.0)), 2.1)
    assert desk.inbox.drain()[0].kind == "attract"


def test_digit_keys_select_existing_formations_of_patch(desk):
    desk.operator.handle(KeyPressed("3"), 1.0)
    desk.operator.handle(KeyPressed("4"), 1.1)
    (event,) = desk.inbox.drain()
    assert (event.formation, event.next) == ("star", True)
