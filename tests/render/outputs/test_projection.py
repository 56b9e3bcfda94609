"""A show's picture in several windows on a real X server with two monitors."""

from collections.abc import Callable, Iterator
from time import monotonic
from typing import Any

import numpy as np
import pytest

from live.base.errors import PersonError
from live.base.stage_snapshot import Camera, Look, Scene, StageView
from live.render.outputs.output import Output, SoftEdge
from live.render.outputs.projection import Projection, WindowLayout
from live.render.window.monitors import UnknownMonitor, find_monitor
from live.render.window.window_input import KeyPressed, PointerPressed
from tests.fixtures.two_monitor_x import FIRST, SECOND, TwoMonitorX

SCENE = Scene((12.0, 8.0), Camera(), Look(background=(0.2, 0.4, 0.9)), 1, 22)
LEFT, RIGHT = Output("left", "1", crop=(0.0, 0.0, 0.5, 1.0)), Output("right", "2", crop=(0.5, 0.0, 0.5, 1.0))

Open = Callable[..., Projection]


@pytest.fixture
def opened(stage_x: TwoMonitorX) -> Iterator[Open]:
    """Opens projections; they are closed after the test."""
    there: list[Projection] = []

    def open_it(*outputs: Output, **options: Any) -> Projection:
        there.append(Projection(SCENE, WindowLayout(outputs or (Output(),), **{"size": (320, 200), **options})))
        return there[-1]

    yield open_it
    for projection in there:
        projection.close()


def moment(overlay: tuple[str, ...] = ()) -> StageView:
    view = StageView.allocate(1, 22)
    view.present[:] = False
    view.overlay = overlay
    return view


def thrown(projection: Projection, view: StageView, until: Callable[[], bool]) -> list[Any]:
    """Run a frame loop until a condition holds; what people did meanwhile."""
    deadline, done = monotonic() + 60.0, []
    while True:
        done += list(projection.poll())
        projection.draw(view)
        projection.show(monotonic())
        if until():
            return done
        assert monotonic() < deadline, f"not within a minute; there was {done}"


def frames(projection: Projection, view: StageView, count: int = 4) -> list[Any]:
    left = iter(range(count))
    return thrown(projection, view, lambda: next(left, None) is None)


def picture_of(projection: Projection) -> np.ndarray:
    """The whole picture, (H, W, 3), top row first."""
    width, height = projection.size
    data = projection.pictures.last.read(components=3, alignment=1)
    return np.frombuffer(data, np.uint8).reshape(height, width, 3)[::-1]


def monitors_of(x_server: TwoMonitorX) -> tuple[np.ndarray, np.ndarray]:
    """What the first and the second monitor show."""
    seen = x_server.screenshot()
    return seen[: FIRST[1], : FIRST[0]], seen[: SECOND[1], FIRST[0] : FIRST[0] + SECOND[0]]


@pytest.mark.x11
def test_a_plain_output_is_the_picture_to_the_pixel(opened: Open, stage_x: TwoMonitorX) -> None:
    projection = opened(monitor=find_monitor("2"), fullscreen=True)
    frames(projection, moment())
    assert projection.size == SECOND
    _, second = monitors_of(stage_x)
    np.testing.assert_array_equal(second, picture_of(projection))
    assert second.max() > 60


@pytest.mark.x11
def test_two_projectors_show_the_two_halves_of_one_picture(opened: Open, stage_x: TwoMonitorX) -> None:
    projection = opened(LEFT, RIGHT, fullscreen=True)
    frames(projection, moment())
    assert projection.size == (1600, 600)  # no projector has more pixels than its part of the picture
    first, second = monitors_of(stage_x)
    picture = picture_of(projection).astype(int)
    np.testing.assert_array_equal(second, picture[:, 800:])
    across = picture[:, :800].reshape(600, 800, 3)
    rows, columns = (np.arange(360) * 600) // 360, (np.arange(640) * 800) // 640
    assert np.abs(first.astype(int) - across[np.ix_(rows, columns)]).mean() < 2.0


@pytest.mark.long
@pytest.mark.x11
def test_a_projector_is_unplugged_and_plugged_in_again_while_the_other_goes_on(
    opened: Open, stage_x: TwoMonitorX
) -> None:
    projection = opened(LEFT, RIGHT, fullscreen=True)
    frames(projection, moment())
    stage_x.unplug_second()
    thrown(projection, moment(), lambda: projection.screens[1].window.size == (320, 200))
    frames(projection, moment())
    first, _ = monitors_of(stage_x)
    assert first[5, 5].max() > 20  # the first projector shows its part all the while
    stage_x.plug_both()
    thrown(projection, moment(), lambda: projection.screens[1].window.size == SECOND)
    frames(projection, moment())
    _, second = monitors_of(stage_x)
    np.testing.assert_array_equal(second, picture_of(projection)[:, 800:])


@pytest.mark.x11
def test_the_overlay_is_the_operators_alone(opened: Open, stage_x: TwoMonitorX) -> None:
    words = moment(("measure 12", "beat 3 of 4"))
    without = opened(Output(monitor="2"), fullscreen=True)
    frames(without, moment())
    _, expected = monitors_of(stage_x)
    without.close()
    projection = opened(Output(monitor="2"), fullscreen=True, operator=find_monitor("1"), size=(320, 180))
    frames(projection, words)
    first, second = monitors_of(stage_x)
    np.testing.assert_array_equal(second, expected)
    own = first[90:270, 160:480].astype(int)
    assert own.max() >= 235 > expected.max()  # letters
    assert not own[:, :39].any()  # the picture keeps its shape: black beside it
    assert own[90, 160].max() > 20
    assert first[0, 0].max() == 0  # the desk's monitor is not covered
    assert words.overlay == ("measure 12", "beat 3 of 4")


@pytest.mark.x11
def test_inputs_come_from_the_window_they_were_made_at(opened: Open, stage_x: TwoMonitorX) -> None:
    projection = opened(LEFT, RIGHT, fullscreen=True)
    frames(projection, moment())
    stage_x.run("xdotool", "mousemove", "740", "150", "mousedown", "1", "mouseup", "1")
    done: list[Any] = []
    while not any(isinstance(value, PointerPressed) for _, value in done):
        done += frames(projection, moment(), 1)
    ((screen, pressed),) = [each for each in done if isinstance(each[1], PointerPressed)]
    assert screen is projection.screens[1]
    assert projection.to_picture(screen, pressed) == PointerPressed(900.0, 150.0)
    assert projection.to_picture(screen, KeyPressed("b")) == KeyPressed("b")


@pytest.mark.x11
def test_a_picture_that_fails_leaves_the_last_one(opened: Open, stage_x: TwoMonitorX, monkeypatch) -> None:
    projection = opened(Output(monitor="2"), fullscreen=True)
    frames(projection, moment())
    before = monitors_of(stage_x)[1]

    def half(view: StageView, target: Any) -> None:
        target.clear(1.0, 0.0, 0.0)
        raise RuntimeError("the pass has failed")

    monkeypatch.setattr(projection.renderer, "draw", half)
    for _ in range(3):
        with pytest.raises(RuntimeError):
            projection.draw(moment())
        projection.show(monotonic())
    np.testing.assert_array_equal(monitors_of(stage_x)[1], before)


@pytest.mark.x11
def test_full_screen_and_back_for_all_outputs(opened: Open) -> None:
    projection = opened(LEFT, RIGHT)
    frames(projection, moment())
    projection.toggle_fullscreen()
    thrown(projection, moment(), lambda: [s.window.size for s in projection.screens] == [FIRST, SECOND])
    projection.toggle_fullscreen()
    thrown(projection, moment(), lambda: [s.window.size for s in projection.screens] == [(320, 200)] * 2)
    assert projection.size == (640, 200)


@pytest.mark.x11
def test_what_cannot_be_opened_leaves_no_window(opened: Open, stage_x: TwoMonitorX, tmp_path) -> None:
    with pytest.raises(UnknownMonitor, match="right of DUMMY1"):
        opened(LEFT, Output("b", monitor="right of DUMMY1"))
    with pytest.raises(PersonError, match="no such file"):
        opened(Output(mask=tmp_path / "none.png"))
    assert b"ChoreoGraphics" not in stage_x.run("xwininfo", "-root", "-tree")
    frames(opened(Output(edge=SoftEdge(left=0.1))), moment(), 1)


@pytest.mark.x11
def test_a_corner_is_dragged_on_the_projector_itself(opened: Open, stage_x: TwoMonitorX) -> None:
    projection = opened(Output(monitor="2"), fullscreen=True)
    (screen,) = projection.screens
    screen.edit(True)
    screen.lines = ("drag a point",)
    assert screen.editing is not None
    assert screen.editing.grab((0.0, 0.0), SECOND[0] / SECOND[1])
    screen.editing.drag((0.2, 0.25))
    screen.set(screen.editing.output)
    frames(projection, moment())
    _, second = monitors_of(stage_x)
    assert not second[:80, :80].any()  # nothing beside the picture
    around = second[130:170, 140:180].astype(int)
    assert ((around[..., 0] > 200) & (around[..., 2] < 120)).any()  # the chosen point glows at (160, 150)
    screen.edit(False)
    frames(projection, moment())
    _, after = monitors_of(stage_x)
    around = after[130:170, 140:180].astype(int)
    assert not ((around[..., 0] > 200) & (around[..., 2] < 120)).any()
    assert projection.to_picture(screen, PointerPressed(160.0, 150.0)) == PointerPressed(
        pytest.approx(0.0, abs=0.01), pytest.approx(0.0, abs=0.01)
    )


@pytest.mark.x11
def test_a_strobe_is_damped_on_the_projector_until_the_operator_lifts_the_limit(
    opened: Open, stage_x: TwoMonitorX
) -> None:
    projection = opened(Output(monitor="2"), size=(160, 90))
    view, held, taken = moment(), projection.flash_limiter, []
    projection.prepare_output_frame()

    def strobe(pictures: int) -> None:
        for number in range(pictures):
            view.brightness = float(number % 8 < 4)
            list(projection.poll())
            projection.draw(view)
            projection.pictures.last.clear(*[view.brightness] * 3, 1.0)
            projection.show(strobe.time)
            strobe.time += 1 / 60
            taken.append(int(np.frombuffer(projection.output_frame().read(components=3), np.uint8)[0]))

    strobe.time = 0.0
    strobe(60)
    assert held.dimmed_count > 10
    assert np.count_nonzero(np.diff([0, *taken]) > 100) == 3  # who films or shares it gets no more flashes either
    before = held.dimmed_count
    taken.clear()
    view.flash_limit_lifted = True
    strobe(60)
    assert held.dimmed_count == before
    assert np.count_nonzero(np.diff(taken) > 100) >= 6


@pytest.mark.x11
def test_hidden_windows_are_revealed_with_everything_ready(opened: Open, stage_x: TwoMonitorX) -> None:
    projection = opened(LEFT, RIGHT, fullscreen=True, hidden=True, operator=None)
    projection.draw(moment())
    assert projection.size == (1600, 600)  # as it will be once it is seen
    assert not any(monitor.any() for monitor in monitors_of(stage_x))
    projection.reveal(fullscreen=True)
    frames(projection, moment())
    assert [screen.window.size for screen in projection.screens] == [FIRST, SECOND]
    assert projection.fullscreen
    _, second = monitors_of(stage_x)
    np.testing.assert_array_equal(second, picture_of(projection)[:, 800:])
