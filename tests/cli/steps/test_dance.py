"""`live dance`: from step names to a motion file on the measures, its report, and missing recordings."""

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from live.app.offline.dance_plan import DanceOptions, assemble_plan, make_plan
from live.app.offline.dance_request import read_text
from live.base.errors import PersonError
from live.cli.main import app
from live.cli.steps.dance import dance
from live.library.motion_file import read_motion
from tests.cli.command import run_live
from tests.motion.formats.made_bvh import body_bvh, dance_values

WALK = "walk, grapevine, walk long left x2, *, bow"


def read_hips(out: Path) -> np.ndarray:
    """Hips (x, z) of a file [m], (T, 2)."""
    return np.asarray(read_motion(out).translation[:, 0, (0, 2)], np.float64) * 0.01


def run_json(*arguments: str) -> dict:
    result = CliRunner().invoke(app, ["dance", *arguments, "--json"])
    assert result.exit_code == 0, result.output
    return json.loads(result.stdout)


def test_sequence_becomes_file_at_requested_tempo(tmp_path: Path) -> None:
    out, report = tmp_path / "out.bvh", tmp_path / "report.json"
    done = run_live(
        "dance", "sketches", "--sequence", WALK, "--bpm", "100", "--out", str(out), "--report", str(report), "--json"
    )
    assert done.returncode == 0, done.stderr
    value = json.loads(done.stdout)
    assert (value["measures"], value["bpm"], value["cost"], value["missing"]) == (7, 100.0, 0, [])
    names = [row["step"] for row in value["steps"]]
    assert [*names[:5], names[6]] == ["walk", "grapevine", "grapevine", "walk", "walk", "bow"]
    assert [row["measure"] for row in value["steps"]] == list(range(1, 8))
    assert all("long left" in row["clip"] for row in value["steps"][3:5])
    motion = read_motion(out)
    assert round(motion.header_fps) == 60
    assert motion.frame_count == 7 * 144 + 1  # 7 measures of 2.4 s
    figures = json.loads(report.read_text())
    assert figures["steps"] == value["steps"]
    assert figures["missing"] == []
    assert set(figures) >= {
        "foot_slide_mean", "foot_slide_p99", "skating_ratio", "join_velocity_ratio", "join_acceleration_ratio",
        "beat_offset_ms", "beat_alignment", "path_error_m", "heading_error_deg", "overlaps", "min_distance_m",
    }  # fmt: skip
    assert figures["beat_offset_ms"]["annotated"]["p95"] < 1.0
    assert figures["foot_slide_mean"] < 0.03


def test_recording_far_from_its_tempo_is_told(tmp_path: Path) -> None:
    (tmp_path / "a.bvh").write_text(body_bvh(dance_values(600), fps=60.0))
    toml = 'file = "a.bvh"\nname = "a"\nbpm = 120\nfirst_beat_s = 2.0\nmeasures = 2\n'
    (tmp_path / "a.toml").write_text(toml)
    slow, near = (make_plan(DanceOptions(str(tmp_path), "a", bpm=bpm)).off_tempo for bpm in (60.0, 130.0))
    assert slow == ("'a' is danced at 0.50 times its 120 bpm; 0.7 to 1.4 looks natural: choose another --bpm",)
    assert near == ()


@pytest.mark.long
def test_dance_follows_path(tmp_path: Path) -> None:
    out = tmp_path / "out.bvh"
    arguments = ["sketches", "--sequence", "walk x8", "--path", "0,0, 2,0, 2,2", "--bpm", "100"]
    value = run_json(*arguments, "--out", str(out), "--report", str(tmp_path / "report.json"))
    assert value["cost"] == 0
    figures = json.loads((tmp_path / "report.json").read_text())
    assert len(figures["path_error_m"]["list"]) == len(figures["heading_error_deg"]["list"]) == 8
    assert figures["path_error_m"]["p95"] < 0.15
    hips = read_hips(out)
    assert np.abs(hips[0] - (0.0, 0.0)).max() < 0.05
    assert np.abs(hips[4 * 144] - (2.0, 0.0)).max() < 0.15
    assert np.abs(hips[-1] - (2.0, 2.0)).max() < 0.15
    assert value["missing"] == []
    left = run_json("sketches", "--sequence", "walk left x2", "--path", "0,0,3,0")
    assert all("left" in row["clip"] for row in left["steps"])


@pytest.mark.long
def test_unreachable_path_reports_missing_steps() -> None:
    value = run_json("sketches", "--sequence", "walk x3", "--path", "0,0,30,0")
    assert value["missing"]
    assert all(set(row) == {"from", "to", "needs"} for row in value["missing"])


@pytest.mark.long
def test_heading_option_rotates_first_placement() -> None:
    plan = make_plan(DanceOptions("sketches", "walk", heading="90", start="bow"))
    assert plan.heading == pytest.approx(np.pi / 2)
    first = plan.graph.library.describe(int(plan.node[0]))
    assert first.startswith("walk")
    turned = assemble_plan(plan).placement[0, 2]
    ahead = assemble_plan(make_plan(DanceOptions("sketches", "walk", start="bow"))).placement[0, 2]
    assert turned - ahead == pytest.approx(np.pi / 2)


@pytest.mark.long
def test_depth_first_search_matches_sequence_at_no_lower_cost() -> None:
    plan = make_plan(DanceOptions("sketches", WALK, depth_first=True))
    assert not plan.deviations.any()
    assert plan.edge_cost.sum() >= make_plan(DanceOptions("sketches", WALK)).edge_cost.sum()


def test_sequence_is_read_from_file(tmp_path: Path) -> None:
    file = tmp_path / "dance.txt"
    file.write_text("walk, # the entrance\nsamba x2\n\n*\n")
    assert read_text(f"@{file}") == "walk,samba x2,*"
    assert [row["step"] for row in run_json("sketches", "--sequence", f"@{file}")["steps"]][:3] == [
        "walk", "samba", "samba",
    ]  # fmt: skip


@pytest.mark.long
def test_sequence_of_ten_thousand_steps_is_planned(tmp_path: Path) -> None:
    file = tmp_path / "long.txt"
    file.write_text("\n".join(["samba", "mambo", "walk left", "bow"] * 2500))
    value = run_json("sketches", "--sequence", f"@{file}")
    assert (value["measures"], value["cost"]) == (12500, 0)
    with pytest.raises(PersonError, match=r"12500 measures of .* at most .* can be put together at once"):
        dance("sketches", f"@{file}", out=tmp_path / "long.bvh")
    assert not (tmp_path / "long.bvh").exists()


@pytest.fixture
def library(tmp_path: Path) -> Path:
    """A folder with one recording, for steps that contradict themselves or each other."""
    folder = tmp_path / "library"
    folder.mkdir()
    (folder / "take.bvh").write_text(body_bvh(dance_values(601)))
    return folder


STEP = 'bpm = 120\nfirst_beat_s = 2.5\nfile = "take.bvh"\n'


def write_steps(folder: Path, *steps: str) -> None:
    (folder / "take.toml").write_text("\n".join(f"[[step]]\n{STEP}{step}" for step in steps))


@pytest.mark.long
def test_nearest_dance_is_reported_with_missing_step(library: Path) -> None:
    write_steps(library, 'name = "a"\nbegin_pose = "x"\nend_pose = "x"', 'name = "b"\nbegin_pose = "x"\nend_pose = "y"')
    shown = run_live("dance", str(library), "--sequence", "a, b, a", "--threshold", "5")
    assert shown.returncode == 0
    assert shown.stdout.count("(differs)") == 1
    assert shown.stderr.splitlines() == [
        "1 of 3 measures is different: this is the nearest dance",
        "missing in measure 3 after b: no a that starts in y: record one (or b that ends in x)",
    ]
    free = run_live("dance", "sketches", "--sequence", "samba x2")
    assert (free.returncode, free.stderr, free.stdout.count("samba")) == (0, "", 2)


@pytest.mark.parametrize(
    ("steps", "arguments", "message"),
    [
        (
            ['name = "a"\nweight_transfer = true\nleading_foot = "left"', 'name = "a"\nleading_foot = "right"'],
            {"sequence": "a"},
            "the step 'a' contradicts itself: .* transfers the weight, .* does not",
        ),
        (
            ['name = "a"', 'name = "a"\nmeasures = 2'],
            {"sequence": "a"},
            r"variations of 'a' are 1 or 2 measures long: say which \(a:1\)",
        ),
        (
            ['name = "a"\nbegin_pose = "x"\nend_pose = "y"', 'name = "b"\nbegin_pose = "z"\nend_pose = "z"'],
            {"sequence": "b, a, b"},
            "nothing leads to 'a' or away from it .*no a that starts in z: record one",
        ),
        (['name = "a"'], {"sequence": "b"}, r"entry 1 of the sequence: there is no step 'b' \(the steps are a\)"),
        (
            ['name = "a"', 'name = "b"\nbeats_per_measure = 3'],
            {"sequence": "a,b"},
            "no metre has all of the sequence: .* there is no step .*steps of 3 and 4 beats a measure are there",
        ),
    ],
)
def test_libraries_without_possible_dance_are_refused(
    library: Path, steps: list[str], arguments: dict, message: str
) -> None:
    write_steps(library, *steps)
    with pytest.raises(PersonError, match=message):
        dance(str(library), **arguments)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"sequence": "walk, grapvine"}, r"entry 2 of the sequence: there is no step 'grapvine' \(grapevine\)"),
        ({"sequence": ""}, "entry 1 of the sequence is empty"),
        ({"sequence": "@nowhere.txt"}, "--sequence @nowhere.txt: there is no such file"),
        ({"sequence": "@."}, "--sequence @.: that is not a file"),
        ({"sequence": "walk", "bpm": 0.0}, "--bpm 0: 20 to 400 expected"),
        ({"sequence": "walk", "bpm": float("nan")}, "--bpm nan"),
        ({"sequence": "walk", "window": 5.0}, "--window 5: at most a measure, 4 beats"),
        ({"sequence": "walk", "threshold": -1.0}, "--threshold -1"),
        ({"sequence": "walk", "heading": "north"}, "--heading 'north': degrees"),
        ({"sequence": "walk", "heading": "path"}, "--heading path: only a --path"),
        ({"sequence": "walk", "heading": "nan"}, "--heading 'nan'"),
        ({"sequence": "walk", "start": "wlk"}, "--start: there is no step 'wlk'"),
        ({"sequence": "walk", "start": "walk", "path": "0,0,1,1"}, "--start: a path begins at its first point"),
        ({"sequence": "walk", "path": "0,0,1"}, "path '0,0,1': 3 numbers read"),
        ({"sequence": "walk x5000", "path": "0,0,1,1"}, "--path: 5000 measures, at most 3000"),
        ({"sequence": "walk", "out": "out.fbx"}, r"--out out.fbx: a name that ends in \.bvh"),
        ({"sequence": "walk", "report": "out.txt"}, "--report out.txt: a name that ends in .json"),
        ({"sequence": "walk", "out": "nowhere/out.bvh"}, "there is no folder nowhere"),
        ({"sequence": "walk", "library": "nowhere"}, "nowhere"),
        ({"sequence": "walk", "library": "."}, "."),
    ],
)
def test_invalid_options_are_refused_without_output(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: dict, message: str
) -> None:
    monkeypatch.chdir(tmp_path)
    arguments = {"library": "sketches"} | {
        key: Path(value) if key in ("out", "report") else value for key, value in arguments.items()
    }
    defaults = {"correction": 0.1, "force": False}
    with pytest.raises(PersonError, match=message):
        dance(**(defaults | arguments))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.long
def test_existing_files_are_kept_without_force(tmp_path: Path) -> None:
    out = tmp_path / "out.bvh"
    out.write_text("mine")
    refused = run_live("dance", "sketches", "--sequence", "walk", "--out", str(out))
    assert refused.returncode == 2
    assert len(refused.stderr.splitlines()) == 2
    assert out.read_text() == "mine"
    assert run_live("dance", "sketches", "--sequence", "walk", "--out", str(out), "--force").returncode == 0
    assert out.read_text().startswith("HIERARCHY")
