"""`live calibrate`: flashes on a screen, and updates of the venue file."""

import tomllib
from pathlib import Path

import numpy as np
import pytest

from live.app.offline.clap_calibration import FLASH_PERIOD, START_DELAY, flash
from live.base.errors import PersonError
from live.clock.time_source import ManualClock
from live.control.audio.latency_claps import clap_offset, find_claps
from live.show.venue.venue import Venue, read_venue, update_toml, updated_venue_text, venue_path
from tests.control.audio.test_latency_claps import synthesize_claps


class Projector:
    """A screen of 60 Hz; `lit` lists the times at which light was requested."""

    def __init__(self, clock: ManualClock, closes_after: float = 1e9) -> None:
        self.clock, self.closes_after = clock, closes_after
        self.lit: list[float] = []
        self._light = False

    def show(self, light: bool) -> bool:
        if light and not self._light:
            self.lit.append(self.clock.now())
        self._light = light
        self.clock.advance(1.0 / 60.0)
        return self.clock.now() < self.closes_after


def test_claps_with_flashes_give_picture_delay() -> None:
    clock = ManualClock()
    projector = Projector(clock)
    flashes = flash(projector, 20, clock, lambda seconds: None)
    assert flashes == pytest.approx(projector.lit)
    assert flashes == pytest.approx(START_DELAY + FLASH_PERIOD * np.arange(20), abs=1.1 / 60.0)
    seen = flashes + 0.080  # display and projector
    claps = seen + np.random.default_rng(8).normal(0.0, 0.015, 20)
    offset = clap_offset(find_claps(synthesize_claps(claps), 48_000.0), flashes)
    assert offset.seconds == pytest.approx(0.080, abs=0.010)


def test_closed_screen_ends_calibration() -> None:
    clock = ManualClock()
    with pytest.raises(PersonError, match="broken off"):
        flash(Projector(clock, closes_after=4.0), 20, clock, lambda seconds: None)


@pytest.fixture
def venue_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("LIVE_CONFIG_DIR", str(tmp_path))
    (tmp_path / "venues").mkdir()
    return tmp_path / "venues"


def test_measured_values_join_handwritten_file(venue_folder: Path) -> None:
    written = '# our hall\nname = "Kaufleuten"   # Zürich\n\n[latency]\n# by ear\nprojector_ms = 40 # old\n\n[audio]\n'
    path = venue_folder / "hall.toml"
    path.write_text(written, encoding="utf-8")
    text = updated_venue_text(
        path, "hall", {"latency": {"projector_ms": 61.5, "input_ms": 12.0}}, "measured 2026-11-22"
    )
    assert "# our hall" in text
    assert "# Zürich" in text
    assert "# by ear" in text
    assert "projector_ms = 61.5 # measured 2026-11-22" in text
    assert tomllib.loads(text)["latency"] == {"projector_ms": 61.5, "input_ms": 12.0}
    assert path.read_text(encoding="utf-8") == written  # nothing is written here


def test_new_file_is_valid_venue() -> None:
    text = update_toml("", 'a "hall"', {"audio": {"device": "USB", "channels": [5, 6]}}, "measured")
    venue = Venue.model_validate(tomllib.loads(text))
    assert (venue.name, venue.audio.device, venue.audio.channels) == ('a "hall"', "USB", [5, 6])
    assert update_toml(text, "x", {"audio": {"device": "USB"}}, "measured again") == text


def test_invalid_file_is_kept_unchanged(venue_folder: Path) -> None:
    path = venue_folder / "hall.toml"
    path.write_text("[latency]\nprojector_ms = -3\n")
    with pytest.raises(PersonError, match=r"hall.toml, line 2: latency.projector_ms: .*found -3"):
        updated_venue_text(path, "hall", {"latency": {"input_ms": 1.0}}, "")


def test_user_venues_have_priority_and_paths_are_refused(venue_folder: Path) -> None:
    assert read_venue("rehearsal").name == "Rehearsal room"
    (venue_folder / "rehearsal.toml").write_text('name = "ours"\n')
    assert read_venue("rehearsal").name == "ours"
    assert venue_path("new") == venue_folder / "new.toml"
    for name in ("../hall", "/etc/passwd", "hall.toml", "", "a/b"):
        with pytest.raises(PersonError, match="not a file"):
            venue_path(name)
    with pytest.raises(PersonError, match="there is no venue 'nowhere'") as caught:
        read_venue("nowhere")
    assert "rehearsal" in str(caught.value.remedy)
