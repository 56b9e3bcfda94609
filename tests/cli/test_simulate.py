"""`live simulate`: scenarios, results and errors."""

import json
import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest

from live.base.errors import PersonError
from live.cli.simulate import simulate
from tests.cli.command import run_live

HEADON = {
    "duration": 9,
    "radius": 0.25,
    "preferred_speed": 1.3,
    "max_speed": 1.8,
    "goal_radius": 0.3,
    "stage": None,
    "agents": [{"position": [-4, 0], "goal": [4, 0]}, {"position": [4, 0], "goal": [[3, 0], [-4, 0]]}],
    "walls": [[-4, 2, 4, 2]],
}


def test_scenario_is_simulated_measured_and_drawn(tmp_path):
    (tmp_path / "a.json").write_text(json.dumps(HEADON), encoding="utf-8")
    arguments = ("simulate", "a.json", "--out", "traj.npz", "--svg", "a.svg", "--json")
    result = run_live(*arguments, cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    with np.load(tmp_path / "traj.npz") as out:
        assert sorted(out.files) == ["arrived", "position", "time"]
        time, position, arrived = out["time"], out["position"], out["arrived"]
    np.testing.assert_array_equal(time, np.arange(9 * 64 + 1) / 64)
    assert (position.shape, position.dtype) == ((577, 2, 2), np.float64)
    np.testing.assert_array_equal(position[0], [[-4, 0], [4, 0]])
    away = np.linalg.norm(position - [[4, 0], [-4, 0]], axis=2)
    np.testing.assert_array_equal(arrived, time[np.argmax(away <= 0.3, axis=0)])
    assert np.linalg.norm(position[:, 0] - position[:, 1], axis=1).min() >= 0.495
    figures = json.loads(result.stdout)
    assert (figures["done"], figures["overlaps"]) == (1.0, 0)
    drawing = ElementTree.parse(tmp_path / "a.svg").getroot()
    assert len(drawing.findall("{*}polyline")) == 2


def test_project_scenario_is_found_by_name(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    simulate(Path("sym-4"), as_json=True)
    assert json.loads(capsys.readouterr().out)["done"] == 1.0
    simulate(Path("headon-2"))
    assert "last arrival" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (json.dumps({**HEADON, "radius": -1}), "radius"),
        (json.dumps({**HEADON, "agents": [{"position": [float("nan"), 0], "goal": [0, 0]}]}), "agents[0].position[0]"),
        ("{", "not JSON"),
        (json.dumps({**HEADON, "duration": 3600, "agents": HEADON["agents"] * 1000}), "duration"),
        (None, "cannot be read"),
    ],
)
def test_invalid_scenario_is_refused_with_remedy(tmp_path, text, words):
    if text is not None:
        (tmp_path / "a.json").write_text(text, encoding="utf-8")
    with pytest.raises(PersonError, match=re.escape(words)) as caught:
        simulate(tmp_path / "a.json", out=tmp_path / "traj.npz")
    assert caught.value.remedy
    assert not (tmp_path / "traj.npz").exists()


def test_command_prints_error_and_exits_with_two(tmp_path):
    (tmp_path / "a.json").write_text(json.dumps({**HEADON, "radius": "wide"}), encoding="utf-8")
    result = run_live("simulate", "a.json", "--out", "traj.npz", cwd=tmp_path)
    assert result.returncode == 2
    assert [line.split()[0] for line in result.stderr.splitlines()] == ["error:", "try:"]
    assert "radius" in result.stderr


def test_missing_output_folder_is_refused(tmp_path):
    (tmp_path / "a.json").write_text(json.dumps({**HEADON, "duration": 1}), encoding="utf-8")
    with pytest.raises(PersonError, match="--out"):
        simulate(tmp_path / "a.json", out=tmp_path / "nowhere" / "traj.npz")


def test_unknown_key_is_reported_and_ignored(tmp_path, capsys):
    (tmp_path / "a.json").write_text(json.dumps({**HEADON, "duration": 1, "wall": []}), encoding="utf-8")
    simulate(tmp_path / "a.json")
    assert "unknown key 'wall'" in capsys.readouterr().err
