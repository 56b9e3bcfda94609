"""The picture of a show in several windows on a real X server with two monitors."""

from collections.abc import Callable, Iterator
from time import monotonic
from typing import Any

import numpy as np
import pytest

from live.base.errors import PersonError
from live.base.picture_parameters import BY_ADDRESS, picture_row
from live.base.stage_snapshot import Camera, Scene, StageView
from live.render.outputs.output import Output, SoftEdge
from live.render.outputs.projection import Projection, WindowLayout
from live.render.window.monitors import UnknownMonitor, find_monitor
from live.render.window.window_input import KeyPressed, PointerPressed
from tests.fixtures.two_monitor_x import FIRST, SECOND, TwoMonitorX

SCENE = Scene((12.0, 8.0), Camera(), 1, 22, start_values=(("/dance/light/background", (0.2, 0.4, 0.9)),))
LEFT, RIGHT = Output("left", "1", crop=(0.0, 0.0, 0.5, 1.0)), Output("right", "2", crop=(0.5, 0.0, 0.5, 1.0))

Open = Callable[..., Projection]


@pytest.fixture
def open_projection(stage_x: TwoMonitorX) -> Iterator[Open]:
    """Opens projections; they are closed after the test."""
    there: list[Projection] = []

    def open_it(*outputs: Output, **options: Any) -> Projection:
        there.append(Projection(SCENE, WindowLayout(outputs or (Output(),), **{"size": (320, 200), **options})))
        return there[-1]

    yield open_it
    for projection in there:
        projection.close()


def empty_view(overlay: tuple[str, ...] = ()) -> StageView:
    view = StageView.allocate(1, 22)
    view.present[:] = False
    view.overlay = overlay
    return view


def run_until(projection: Projection, view: StageView, until: Callable[[], bool]) -> list[Any]:
    """Run the frame loop until a condition holds; returns the inputs received meanwhile."""
    deadline, done = monotonic() + 60.0, []
    while True:
        done += list(projection.poll())
        projection.draw(view)
        projection.show(monotonic())
        if until():
            return done
        assert monotonic() < deadline, f"not within a minute; there was {done}"


def run_frames(projection: Projection, view: StageView, count: int = 4) -> list[Any]:
    left = iter(range(count))
    return run_until(projection, view, lambda: next(left, None) is None)


def picture_of(projection: Projection) -> np.ndarray:
    """The whole picture, (H, W, 3), top row first."""
    width, height = projection.size
    data = projection.pictures.last.read(components=3, alignment=1)
    return np.frombuffer(data, np.uint8).reshape(height, width, 3)[::-1]


def capture_monitors(x_server: TwoMonitorX) -> tuple[np.ndarray, np.ndarray]:
    """Screenshots of the first and the second monitor."""
    seen = x_server.screenshot()
    return seen[: FIRST[1], : FIRST[0]], seen[: SECOND[1], FIRST[0] : FIRST[0] + SECOND[0]]


@pytest.mark.long
@pytest.mark.x11
def test_plain_output_matches_picture_exactly(open_projection: Open, stage_x: TwoMonitorX) -> None:
    projection = open_projection(monitor=find_monitor("2"), fullscreen=True)
    run_frames(projection, empty_view())
    assert projection.size == SECOND
    _, second = capture_monitors(stage_x)
    np.testing.assert_array_equal(second, picture_of(projection))
    assert second.max() > 60


@pytest.mark.long
@pytest.mark.x11
def test_two_projectors_show_halves_of_one_picture(open_projection: Open, stage_x: TwoMonitorX) -> None:
    projection = open_projection(LEFT, RIGHT, fullscreen=True)
    run_frames(projection, empty_view())
    assert projection.size == (1600, 600)  # no projector has more pixels than its part of the picture
    first, second = capture_monitors(stage_x)
    picture = picture_of(projection).astype(int)
    np.testing.assert_array_equal(second, picture[:, 800:])
    across = picture[:, :800].reshape(600, 800, 3)
    rows, columns = (np.arange(360) * 600) // 360, (np.arange(640) * 800) // 640
    assert np.abs(first.astype(int) - across[np.ix_(rows, columns)]).mean() < 2.0


@pytest.mark.long
@pytest.mark.x11
def test_unplugged_projector_recovers_while_other_continues(open_projection: Open, stage_x: TwoMonitorX) -> None:
    projection = open_projection(LEFT, RIGHT, fullscreen=True)
    run_frames(projection, empty_view())
    stage_x.unplug_second()
    run_until(projection, empty_view(), lambda: projection.screens[1].window.size == (320, 200))
    run_frames(projection, empty_view())
    first, _ = capture_monitors(stage_x)
    assert first[5, 5].max() > 20  # the first projector shows its part all the while
    stage_x.plug_both()
    run_until(projection, empty_view(), lambda: projection.screens[1].window.size == SECOND)
    run_frames(projection, empty_view())
    _, second = capture_monitors(stage_x)
    np.testing.assert_array_equal(second, picture_of(projection)[:, 800:])


@pytest.mark.long
@pytest.mark.x11
def test_overlay_is_shown_only_to_operator(open_projection: Open, stage_x: TwoMonitorX) -> None:
    words = empty_view(("measure 12", "beat 3 of 4"))
    without = open_projection(Output(monitor="2"), fullscreen=True)
    run_frames(without, empty_view())
    _, expected = capture_monitors(stage_x)
    without.close()
    projection = open_projection(Output(monitor="2"), fullscreen=True, operator=find_monitor("1"), size=(320, 180))
    run_frames(projection, words)
    first, second = capture_monitors(stage_x)
    np.testing.assert_array_equal(second, expected)
    own = first[90:270, 160:480].astype(int)
    assert own.max() >= 235 > expected.max()  # letters
    assert not own[:, :39].any()  # the picture keeps its shape: black beside it
    assert own[90, 160].max() > 20
    assert first[0, 0].max() == 0  # the desk's monitor is not covered
    assert words.overlay == ("measure 12", "beat 3 of 4")


@pytest.mark.long
@pytest.mark.x11
def test_inputs_are_attributed_to_window_of_origin(open_projection: Open, stage_x: TwoMonitorX) -> None:
    projection = open_projection(LEFT, RIGHT, fullscreen=True)
    run_frames(projection, empty_view())
    stage_x.run("xdotool", "mousemove", "740", "150", "mousedown", "1", "mouseup", "1")
    done: list[Any] = []
    while not any(isinstance(value, PointerPressed) for _, value in done):
        done += run_frames(projection, empty_view(), 1)
    ((screen, pressed),) = [each for each in done if isinstance(each[1], PointerPressed)]
    assert screen is projection.screens[1]
    assert projection.to_picture(screen, pressed) == PointerPressed(900.0, 150.0)
    assert projection.to_picture(screen, KeyPressed("b")) == KeyPressed("b")


@pytest.mark.long
@pytest.mark.x11
def test_last_picture_stays_after_failed_draw(open_projection: Open, stage_x: TwoMonitorX, monkeypatch) -> None:
    projection = open_projection(Output(monitor="2"), fullscreen=True)
    run_frames(projection, empty_view())
    before = capture_monitors(stage_x)[1]

    def half(view: StageView, target: Any) -> None:
        target.clear(1.0, 0.0, 0.0)
        raise RuntimeError("the pass has failed")

    monkeypatch.setattr(projection.renderer, "draw", half)
    for _ in range(3):
        with pytest.raises(RuntimeError):
            projection.draw(empty_view())
        projection.show(monotonic())
    np.testing.assert_array_equal(capture_monitors(stage_x)[1], before)


@pytest.mark.long
@pytest.mark.x11
def test_all_outputs_toggle_fullscreen(open_projection: Open) -> None:
    projection = open_projection(LEFT, RIGHT)
    run_frames(projection, empty_view())
    projection.toggle_fullscreen()
    run_until(projection, empty_view(), lambda: [s.window.size for s in projection.screens] == [FIRST, SECOND])
    projection.toggle_fullscreen()
    run_until(projection, empty_view(), lambda: [s.window.size for s in projection.screens] == [(320, 200)] * 2)
    assert projection.size == (640, 200)


@pytest.mark.x11
def test_failed_opening_leaves_no_window(open_projection: Open, stage_x: TwoMonitorX, tmp_path) -> None:
    with pytest.raises(UnknownMonitor, match="right of DUMMY1"):
        open_projection(LEFT, Output("b", monitor="right of DUMMY1"))
    with pytest.raises(PersonError, match="no such file"):
        open_projection(Output(mask=tmp_path / "none.png"))
    assert b"ChoreoGraphics" not in stage_x.run("xwininfo", "-root", "-tree")
    run_frames(open_projection(Output(edge=SoftEdge(left=0.1))), empty_view(), 1)


@pytest.mark.long
@pytest.mark.x11
def test_corner_is_dragged_on_projector(open_projection: Open, stage_x: TwoMonitorX) -> None:
    projection = open_projection(Output(monitor="2"), fullscreen=True)
    (screen,) = projection.screens
    screen.edit(True)
    screen.lines = ("drag a point",)
    assert screen.editing is not None
    assert screen.editing.grab((0.0, 0.0), SECOND[0] / SECOND[1])
    screen.editing.drag((0.2, 0.25))
    screen.set(screen.editing.output)
    run_frames(projection, empty_view())
    _, second = capture_monitors(stage_x)
    assert not second[:80, :80].any()  # nothing beside the picture
    around = second[130:170, 140:180].astype(int)
    assert ((around[..., 0] > 200) & (around[..., 2] < 120)).any()  # the chosen point glows at (160, 150)
    screen.edit(False)
    run_frames(projection, empty_view())
    _, after = capture_monitors(stage_x)
    around = after[130:170, 140:180].astype(int)
    assert not ((around[..., 0] > 200) & (around[..., 2] < 120)).any()
    assert projection.to_picture(screen, PointerPressed(160.0, 150.0)) == PointerPressed(
        pytest.approx(0.0, abs=0.01), pytest.approx(0.0, abs=0.01)
    )


@pytest.mark.long
@pytest.mark.x11
def test_strobe_is_limited_on_projector_until_limit_is_lifted(open_projection: Open, stage_x: TwoMonitorX) -> None:
    projection = open_projection(Output(monitor="2"), size=(160, 90))
    view, held, taken = empty_view(), projection.flash_limiter, []
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


@pytest.mark.long
@pytest.mark.x11
def test_hidden_windows_are_revealed_fully_prepared(open_projection: Open, stage_x: TwoMonitorX) -> None:
    projection = open_projection(LEFT, RIGHT, fullscreen=True, hidden=True, operator=None)
    projection.draw(empty_view())
    assert projection.size == (1600, 600)  # as it will be once it is seen
    assert not any(monitor.any() for monitor in capture_monitors(stage_x))
    projection.reveal(fullscreen=True)
    run_frames(projection, empty_view())
    assert [screen.window.size for screen in projection.screens] == [FIRST, SECOND]
    assert projection.fullscreen
    _, second = capture_monitors(stage_x)
    np.testing.assert_array_equal(second, picture_of(projection)[:, 800:])


@pytest.mark.long
@pytest.mark.x11
def test_output_alone_draws_its_part_and_shows_the_same(open_projection: Open, stage_x: TwoMonitorX) -> None:
    half = Output("left", "2", crop=(0.0, 0.0, 0.5, 1.0), corners=((0.05, 0.0), (1.0, 0.05), (0.95, 1.0), (0.0, 0.95)))
    seen = []
    for whole_for in ("somebody looks at it", ""):
        projection = open_projection(half, fullscreen=True, whole_for=whole_for)
        run_frames(projection, empty_view())
        assert projection.size == (1600, 600)
        assert projection.pictures.part.is_whole == bool(whole_for)
        at = projection.to_picture(projection.screens[0], PointerPressed(400.0, 300.0))
        assert isinstance(at, PointerPressed)
        seen.append((capture_monitors(stage_x)[1].astype(int), (at.x, at.y), projection.describe_part()))
        projection.close()
    (whole, place, words), (own, same_place, own_words) = seen
    assert np.abs(whole - own).max() <= 1
    assert whole.max() > 60
    assert place == same_place
    assert words == "1600x600 pixels, all of them: somebody looks at it"
    assert own_words.endswith("x600 of 1600x600 pixels")


@pytest.mark.long
@pytest.mark.x11
def test_trails_that_grow_make_it_draw_the_whole_picture_from_then_on(
    open_projection: Open, stage_x: TwoMonitorX
) -> None:
    projection = open_projection(Output("left", "2", crop=(0.0, 0.0, 0.5, 1.0)), fullscreen=True)
    view = empty_view()
    view.picture = picture_row(SCENE)
    view.picture[[BY_ADDRESS["/dance/pass/trails"].first, BY_ADDRESS["/dance/pass/trails/zoom"].first]] = 0.5
    run_frames(projection, empty_view())
    assert projection.whole_for == ""
    for now in (view, empty_view()):
        run_frames(projection, now)
        assert projection.pictures.part.is_whole
        assert "trails" in projection.whole_for
