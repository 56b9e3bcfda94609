"""The click track of a running show, and its configuration by venue and command line."""

import numpy as np
import pytest

from live.app.services.click_service import make_click
from live.base.errors import PersonError
from live.clock.ticks import TICK
from live.clock.time_source import ManualClock
from live.control.audio import click_output
from live.control.audio.devices import SoundDevice
from live.control.events.events import CountIn, SetClick, Tap
from live.show.sound.click_link import ClickConnection
from live.show.sound.soundtrack import click_voices
from live.show.venue.venue import Venue
from tests.show.made_show import made_show


@pytest.fixture
def click_device(monkeypatch: pytest.MonkeyPatch) -> None:
    """One output device with four channels."""
    monkeypatch.setattr(click_output, "find_device", lambda *_: SoundDevice(0, "drummer", "ALSA", 4, 48_000.0, True))


def test_count_in_is_clicked_while_click_is_off(click_device: None) -> None:
    show = made_show()
    click = ClickConnection(show, click_output.ClickOutput("drummer", ManualClock(), click_voices))
    click.handle(SetClick(time=0.0, source="test", on=False))
    sound, counted = np.zeros(round(TICK * 48_000), np.float32), []
    for index in range(1, 64 * 9):
        if index == 100:
            show.apply(CountIn(time=index * TICK, source="test", measures=1.0))
        if index in (132, 164, 196, 228):  # a measure of taps, at 120 bpm
            show.apply(Tap(time=index * TICK, source="test"))
        show.tick(index * TICK)
        before = click.output.track.clicks
        click.frame()
        click.output.track.fill(sound, show.time, TICK)
        if click.output.track.clicks > before:
            counted.append(show.timeline.beat_at(show.time + TICK / 2))
    beats = np.round(counted)
    assert len(beats) == 5  # a measure, and the one
    assert np.array_equal(np.diff(beats), np.ones(4))
    assert show.timeline.phase_at(show.timeline.time_at(beats[-1])) == pytest.approx(0.0, abs=1e-6)


def test_venue_and_command_line_configure_the_click(click_device: None) -> None:
    show, clock = made_show(), ManualClock()
    assert make_click(None, None, None, show, clock) is None
    venue = Venue.model_validate(
        {"audio": {"click": "drummer", "click_channels": [3, 4]}, "latency": {"click_ms": 4.0}}
    )
    made = make_click(None, None, venue, show, clock)
    assert made is not None
    assert made.output.delay == pytest.approx(0.004)
    with pytest.raises(PersonError, match="no channel 5"):
        make_click("drummer", "5", venue, show, clock)
    with pytest.raises(PersonError, match="--click-channels"):
        make_click(None, "3", None, show, clock)
    with pytest.raises(PersonError, match="--click-channels: channels 'three'"):
        make_click("drummer", "three", None, show, clock)
