"""`live partner`: its files, its report, and one-line errors."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from live.app.offline.partner_request import read_path
from live.base.errors import PersonError
from live.cli.steps.partner import partner
from live.library.partner_pairs import read_pairs
from live.motion.clip import Clip, resample
from live.motion.formats.bvh_reader import parse_bvh
from live.motion.formats.bvh_writer import write_bvh
from tests.cli.command import run_live
from tests.motion.partner.test_answer import random_dance_clip


@dataclass(frozen=True)
class PairFiles:
    """Files of two pairs and of a leader."""

    folder: Path
    pairs: Path
    leader: Path
    truth: Path


@pytest.fixture(name="pair_files", scope="module")
def _pair_files(tmp_path_factory: pytest.TempPathFactory) -> PairFiles:
    folder = tmp_path_factory.mktemp("pair_files")
    lines = []
    for name, seed in (("a", 61), ("b", 63)):
        for side, more in (("leader", 0), ("follower", 1)):
            (folder / f"{name}_{side}.bvh").write_text(write_bvh(random_dance_clip(seed + more, 420), rate=30.0))
        lines.append(
            f'[[pair]]\nleader = {{ file = "{name}_leader.bvh", bpm = 164, first_beat_s = 0.3 }}\n'
            f'follower = {{ file = "{name}_follower.bvh" }}\nholds = [["left", "right", 1.0, 3.0]]\n'
        )
    (folder / "pairs.toml").write_text("\n".join(lines))
    part = random_dance_clip(61, 300)
    (folder / "leader.bvh").write_text(write_bvh(part, rate=30.0))
    (folder / "truth.bvh").write_text(write_bvh(random_dance_clip(62, 300), rate=30.0))
    return PairFiles(folder, folder / "pairs.toml", folder / "leader.bvh", folder / "truth.bvh")


def test_follower_is_written_frame_by_frame_with_report(pair_files: PairFiles, tmp_path: Path) -> None:
    out, report, score = tmp_path / "out.bvh", tmp_path / "report.json", tmp_path / "score.txt"
    options = [
        "--examples",
        str(pair_files.pairs),
        "--out",
        str(out),
        "--report",
        str(report),
        "--truth",
        str(pair_files.truth),
    ]
    done = run_live("partner", str(pair_files.leader), *options, "--transcript", str(score))
    assert (done.returncode, done.stderr) == (0, "")
    written, leader = parse_bvh(out.read_bytes(), "out"), parse_bvh(pair_files.leader.read_bytes(), "leader")
    assert len(written.values) == len(leader.values)
    assert written.frame_time == pytest.approx(leader.frame_time, rel=1e-6)
    told = json.loads(report.read_text())
    assert told["frames"] == len(leader.values)
    assert told["fps"] == pytest.approx(30.0)
    # the leader is one of the database: her follower is the real one
    assert told["truth"]["joint_error_m"] < 0.12
    assert told["truth"]["hip_distance_error_m"] < 0.05
    assert told["score"] >= 0.0
    assert told["hand_hold_error_m"] is not None
    assert told["join_velocity_ratio"] > 0.0
    assert {one["unit"].split("/")[0] for one in told["units"][1:-1]} == {"a_follower"}
    for one in told["units"][1:-1]:
        assert abs(one["seconds"] - one["recorded_seconds"]) <= 0.15 + 1e-3
    lines = score.read_text().splitlines()
    assert lines[1].endswith(told["units"][0]["unit"])


@pytest.mark.long
def test_online_mode_reports_frame_time_and_changes(pair_files: PairFiles, tmp_path: Path) -> None:
    out, report = tmp_path / "out.bvh", tmp_path / "report.json"
    partner(
        leader=pair_files.leader,
        examples=pair_files.pairs,
        out=out,
        online=True,
        bpm=164.0,
        first_beat=0.3,
        report=report,
    )
    told = json.loads(report.read_text())
    assert told["live"]["frame_ms"]["p50"] > 0.0
    assert 0.0 < told["live"]["changes_per_s"] < 5.0
    assert out.stat().st_size > 1000


def test_path_leads_walking_follower(pair_files: PairFiles, tmp_path: Path) -> None:
    pairs, path, out = tmp_path / "walks.toml", tmp_path / "path.csv", tmp_path / "out.bvh"
    times = np.arange(0.0, 6.0, 0.05)
    np.savetxt(
        path, np.stack((times, 0.5 * times, 0.0 * times), axis=1), delimiter=",", header="time_s,x,z", comments=""
    )
    cuts = ", ".join(f"{at:.2f}" for at in np.arange(0.2, 6.5, 0.7))
    pairs.write_text(f'[[pair]]\nfollower = {{ file = "{pair_files.folder}/b_follower.bvh" }}\ncuts_s = [{cuts}]\n')
    partner(path=path, examples=pairs, out=out)
    hips = np.asarray(parse_bvh(out.read_bytes(), "out").values)[:, (0, 2)]
    apart = np.abs(hips[30:330, 0] / 100.0 - 0.5 * np.arange(30, 330) / 60.0)
    assert np.median(apart) < 0.5


BOTH = 'leader = {file="a_leader.bvh"}\nfollower = {file="a_follower.bvh"}\n'
BAD: list[tuple[str, str]] = [
    ('[[pair]]\nleader = {file="a_leader.bvh"}\nfollower = {file="none.bvh"}', "line 3.*follower.*no such file"),
    ('[[pair]]\nleader = {file="a_leader.bvh", fps=60}\nfollower = {file="a_follower.bvh"}', "one rate"),
    ('[[pair]]\nleader = {file="a_leader.bvh", drop_frames=9}\nfollower = {file="a_follower.bvh"}', "frames"),
    (f"[[pair]]\n{BOTH}cuts_s = [0.1, 0.9]", "1 unit"),
    (f"[[pair]]\n{BOTH}cuts_s = [0.1, 0.12, 0.9]", "unit of"),
    ('[[pair]]\nleeder = {file="a_leader.bvh"}\nfollower = {file="a_follower.bvh"}', "unknown key"),
    ('[[pair]]\nleader = {file="a_leader.bvh", bpm = 164, first_beat_s = 0}\nfollower = {file="a_follower.bvh"}\n'
     'holds = [["left", "right", 5, 99]]', "hold from 5 to 99"),
    ("pair = 3", "pair"),
    ("[[pair", "not valid TOML"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "words"), BAD)
def test_invalid_pairs_are_named_in_one_line(pair_files: PairFiles, text: str, words: str) -> None:
    file = pair_files.folder / "bad.toml"
    file.write_text(text)
    with pytest.raises(PersonError, match=words) as told:
        read_pairs(file)
    assert "\n" not in told.value.message


@pytest.mark.long
def test_invalid_leaders_are_named_in_error(pair_files: PairFiles, tmp_path: Path) -> None:
    out = tmp_path / "out.bvh"

    def refused(words: str, **options: Any) -> None:
        with pytest.raises(PersonError, match=words):
            partner(**({"leader": pair_files.leader, "examples": pair_files.pairs, "out": out} | options))

    refused("one leader", leader=None)
    refused("--examples", examples=None)
    refused("both or neither", bpm=120.0)
    refused("no such file", leader=tmp_path / "nobody.bvh")
    refused("that is an input file", out=pair_files.leader)
    refused("pairs, which a leader", leader=None, path=pair_files.pairs)
    short = tmp_path / "short.bvh"
    clip = random_dance_clip(61, 300)
    short.write_text(write_bvh(Clip("s", clip.root_position[:5].copy(), clip.rotation[:5].copy(), 60.0,
                                    clip.contact[:5].copy())))  # fmt: skip
    refused("5 frames; 8 at least", leader=short)
    brief = tmp_path / "brief.bvh"
    brief.write_text(write_bvh(resample(clip, 60.0, first=0.0, last=20.0)))
    refused("shorter than any unit", leader=brief)
    holed = tmp_path / "holed.bvh"
    lines = pair_files.leader.read_text().splitlines()
    lines[-3] = lines[-3].replace(lines[-3].split()[7], "nan", 1)
    holed.write_text("\n".join(lines))
    refused("nan", leader=holed)
    assert not out.exists()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("time_s,x,z\n0,0,0\n", "1 points"),
        ("0,0,0\n1,0,nan\n", "line 2"),
        ("0,0,0\n0,1,0\n", "line 2.*ascend"),
        ("0,0,0\n1,2\n", "line 2.*three numbers"),
    ],
)
def test_invalid_paths_are_named_in_error(tmp_path: Path, text: str, words: str) -> None:
    file = tmp_path / "path.csv"
    file.write_text(text)
    with pytest.raises(PersonError, match=words):
        read_path(file)
