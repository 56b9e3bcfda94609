"""Tests of streams: a whole recording cut at its measure lines, joined by pose similarity alone."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from live.graph.motion_graph import build_graph
from live.graph.step_library import build_library
from live.library.library_check import check_folder
from live.library.recording_file import RecordingError
from live.library.step_folder import load_folder
from live.show.loader import load_show
from live.show.patch.patch_search_path import DEFAULT_PATCH
from tests.fixtures.mostly_long import mostly_long
from tests.motion.formats.made_bvh import body_bvh, dance_values, still

STREAM = """
file = "dance.bvh"
name = "samba"
bpm = 120
first_beat_s = 0.5
unstructured = true
"""


@pytest.fixture(autouse=True)
def isolated_cache(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LIVE_CACHE_DIR", str(tmp_path_factory.mktemp("cache")))


def folder(tmp_path: Path, toml: str) -> Path:
    """Ten seconds at 60 frames/s: four whole measures of two seconds after 0.5 s."""
    (tmp_path / "dance.bvh").write_text(body_bvh(dance_values(601)))
    (tmp_path / "steps.toml").write_text(toml)
    return tmp_path


@pytest.mark.long
def test_every_measure_is_clip_that_follows_previous(tmp_path: Path) -> None:
    clips = load_folder(folder(tmp_path, STREAM))
    assert [clip.measures for clip in clips] == [1, 1, 1, 1]
    assert all(clip.in_stream and clip.step == "samba" for clip in clips)
    whole = load_folder(folder(tmp_path, STREAM.replace("unstructured = true", "measures = 4")))[0]
    for n, clip in enumerate(clips):
        begin = round(whole.first + n * 120)
        own = clip.clip.rotation[round(clip.first) : round(clip.first) + 121, 1:]
        assert np.abs(own) == pytest.approx(np.abs(whole.clip.rotation[begin : begin + 121, 1:]), abs=1e-6)
    graph = build_graph(build_library(clips), threshold=0.05, prune=False)
    costs = dict(zip(zip(graph.joins.source, graph.joins.target, strict=True), graph.joins.cost, strict=True))
    for n in range(3):
        assert costs[n, n + 1] < 1e-4  # the lead-in of a measure is the end of the one before it
    assert build_graph(build_library(clips), threshold=2.0).alive.all()
    assert len(graph.takes.node) == 0


def test_selected_measures_are_mirrored(tmp_path: Path) -> None:
    clips = load_folder(folder(tmp_path, STREAM + "start_measure = 2\nmeasures = 2\nmirror = true\n"))
    assert [clip.mirrored for clip in clips] == [False, True, False, True]
    assert [clip.clip.name for clip in clips[::2]] == [
        "samba, dance from measure 2",
        "samba, dance from measure 3",
    ]


@mostly_long(
    ("posed", "danced"),
    [(slice(0, 150), ["3", "4"]), (slice(510, 601), ["1", "2", "3"]), (slice(240, 330), ["1", "2", "3", "4"])],
    quick=[0],
)
def test_measures_with_a_calibration_pose_at_an_end_are_left_out(
    tmp_path: Path, posed: slice, danced: list[str]
) -> None:
    """Arms are held out for 2.5 s at the beginning, 1.5 s at the end, or in the middle, where that is dance."""
    values = dance_values(601)
    values[posed] = still()
    place = folder(tmp_path, STREAM)
    (place / "dance.bvh").write_text(body_bvh(values))
    assert [clip.clip.name.split()[-1] for clip in load_folder(place)] == danced


@pytest.mark.long
def test_show_loads_stream(tmp_path: Path) -> None:
    """As `live play --steps` loads it: the dancers go from measure to measure of the recording."""
    show = load_show(DEFAULT_PATCH, recordings=folder(tmp_path, STREAM)).start()
    assert show.dancers.graph.library.steps == ("samba",)
    assert show.dancers.graph.alive[show.dancers.node].all()


@pytest.mark.parametrize("said", ['leading_foot = "left"', 'end_pose = "plié"', 'direction = "long left"'])
def test_step_fields_are_refused_in_stream(tmp_path: Path, said: str) -> None:
    with pytest.raises(RecordingError) as caught:
        load_folder(folder(tmp_path, STREAM + said))
    assert f"steps.toml, line 7: {said.split()[0]}: it belongs to a step" in str(caught.value)


def test_stream_beyond_recording_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"line 7: measures: .*ends with measure 9, but dance.bvh has 4 whole"):
        load_folder(folder(tmp_path, STREAM + "measures = 9"))
    with pytest.raises(RecordingError, match="start_measure: the step ends with measure 8"):
        load_folder(folder(tmp_path, STREAM + "start_measure = 8"))


def test_library_check_reads_all_measures(tmp_path: Path) -> None:
    checked = check_folder(folder(tmp_path, STREAM))
    assert len(checked.steps) == 4
    assert not [finding for finding in checked.findings if finding.kind == "wrong"]
    assert replace(checked.steps[0], in_stream=False).step == "samba"
