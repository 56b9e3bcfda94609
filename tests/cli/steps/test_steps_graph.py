"""`live steps graph`: text, JSON, DOT and SVG of the project's own steps, and of names that need escaping."""

import json
import re
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from live.app.offline.graph_report import analyse_graph, dot_of, json_of, svg_of
from live.app.pictures.graph_svg import Arrow, State, state_machine
from live.cli.main import app
from live.graph.motion_graph import build_graph
from live.graph.step_library import build_library
from live.show.patch.patch_search_path import PATCHES
from tests.fixtures.made_steps import made_clip, made_steps
from tests.motion.formats.made_bvh import body_bvh, dance_values

SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def report():
    clips = [*made_steps(), made_clip('arms "up" & <down>\\', arm=-1.2), replace(made_clip("b"), begin_pose="plié")]
    return analyse_graph(build_graph(build_library(clips), threshold=0.08, prune=False))


def test_json_contains_whole_graph(report):
    data = json.loads(json.dumps(json_of(report)))
    graph, library = report.graph, report.graph.library
    assert len(data["nodes"]) == library.node_count
    assert [(edge["from"], edge["to"]) for edge in data["edges"]] == list(
        zip(graph.joins.source.tolist(), graph.joins.target.tolist(), strict=True)
    )
    assert sorted(node for group in data["strong_components"] for node in group) == list(range(library.node_count))
    assert sum(len(cluster["nodes"]) for cluster in data["clusters"]) == library.node_count
    assert all(node in data["components"][row["component"]]["nodes"] for node, row in enumerate(data["nodes"]))
    joined = {(lead["from"], lead["to"]) for lead in data["leads"]}
    missing = {(row["from"], row["to"]) for row in data["missing"]}
    assert joined.isdisjoint(missing)
    assert len(joined) + len(missing) == len(library.steps) ** 2
    dead = {row["node"] for row in data["dead_ends"]}
    assert dead == {row["node"] for row in data["nodes"] if not row["alive"]}
    assert dead
    near = [row["nearest_m"] for row in data["missing"] if row["nearest_m"] is not None]
    assert near == sorted(near)
    assert min(near) > 0.08


def test_dot_is_well_formed(report):
    """Every quote is closed, every edge connects declared nodes, every brace is matched."""
    text = dot_of(report)
    bare = re.sub(r'"(?:[^"\\\n]|\\.)*"', "S", text)
    assert '"' not in bare
    assert bare.count("{") == bare.count("}") == 1 + len(report.graph.library.steps)
    declared = set(re.findall(r"^    (c\d+) \[", bare, re.M))
    edges = re.findall(r"^  (c\d+) -> (c\d+) \[", bare, re.M)
    assert len(declared) == len(report.components)
    assert len(edges) == len(report.parts)
    assert {name for edge in edges for name in edge} <= declared


def test_svg_contains_every_step_and_arrow(report):
    root = ElementTree.fromstring(svg_of(report))
    library = report.graph.library
    assert len(root.findall(f"{SVG}circle")) == len(library.steps)
    assert len(root.findall(f"{SVG}polygon")) == len(report.steps)
    words = [text.text for text in root.findall(f"{SVG}text")]
    assert all(name in words for name in library.steps)
    size = float(root.attrib["width"])
    for circle in root.findall(f"{SVG}circle"):
        x, y, radius = (float(circle.attrib[key]) for key in ("cx", "cy", "r"))
        assert radius < x < size - radius
        assert radius < y < size + 30 - radius


@pytest.mark.parametrize("count", [1, 2, 3, 40])
def test_arrows_end_at_circle_edges(count):
    states = [State(f"step {n}", "1 measure", 1 + n % 5) for n in range(count)]
    arrows = [Arrow(a, b, 1) for a in range(count) for b in range(count)]
    root = ElementTree.fromstring(state_machine(states, arrows, "many"))
    circles = [tuple(float(c.attrib[key]) for key in ("cx", "cy", "r")) for c in root.findall(f"{SVG}circle")]
    for a, first in enumerate(circles):
        for second in circles[:a]:
            assert np.hypot(first[0] - second[0], first[1] - second[1]) > first[2] + second[2]
    for arrow, head in zip(arrows, root.findall(f"{SVG}polygon"), strict=True):
        x, y = (float(part) for part in head.attrib["points"].split()[0].split(","))
        cx, cy, radius = circles[arrow.target]
        assert np.hypot(x - cx, y - cy) == pytest.approx(radius + 3.0, abs=0.2)


def test_names_with_control_characters_are_valid_xml():
    ElementTree.fromstring(state_machine([State("a\x01\x1bb<", "1 measure", 1)], [], "x\x00"))


def test_command_prints_report_and_draws_graph(tmp_path: Path):
    run = CliRunner()
    picture = tmp_path / "graph.svg"
    library = str(PATCHES / "steps")
    told = run.invoke(app, ["steps", "graph", library, "--threshold", "0.06", "--svg", str(picture)])
    assert told.exit_code == 0, told.output
    assert "dead end: arm wave" in told.output
    assert "pairs of steps are not joined" in told.output
    assert ElementTree.parse(picture).getroot().tag == f"{SVG}svg"
    printed = run.invoke(app, ["steps", "graph", library, "--json"])
    assert json.loads(printed.stdout)["beats_per_measure"] == 4
    assert run.invoke(app, ["steps", "graph", library, "--dot"]).stdout.startswith("digraph steps {")


def test_invalid_options_are_refused_and_files_kept(tmp_path: Path):
    run = CliRunner()
    recording = tmp_path / "take_3.bvh"
    recording.write_text("not to be written over")
    for arguments, words in (
        (["--threshold", "0"], "--threshold"),
        (["--window", "2"], "--window"),
        (["--svg", str(tmp_path / "no" / "folder.svg")], "--svg"),
        (["--svg", str(recording)], "a name that ends in .svg"),
        (["--json", "--dot"], "--json and --dot"),
    ):
        failed = run.invoke(app, ["steps", "graph", str(PATCHES / "steps"), *arguments])
        assert failed.exit_code != 0
        assert words in failed.output + str(failed.exception)
    assert recording.read_text() == "not to be written over"
    empty = run.invoke(app, ["steps", "graph", str(tmp_path)])
    assert empty.exit_code != 0


@pytest.mark.long
def test_bridges_are_found_in_recordings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Two unconnected measures of one recording: the motion between them in it leads from one to the other."""
    monkeypatch.setenv("LIVE_CACHE_DIR", str(tmp_path / "cache"))
    (tmp_path / "dance.bvh").write_text(body_bvh(dance_values(601)))
    head = 'file = "dance.bvh"\nbpm = 120\nfirst_beat_s = 1.0\n'
    (tmp_path / "steps.toml").write_text(
        head + '[[step]]\nname = "one"\nstart_measure = 1\n[[step]]\nname = "three"\nstart_measure = 3\n'
    )
    printed = CliRunner().invoke(app, ["steps", "graph", str(tmp_path), "--bridges", "--json", "--threshold", "0.001"])
    assert printed.exit_code == 0, printed.output
    data = json.loads(printed.stdout)
    assert {(row["from"], row["to"]) for row in data["bridges"]} == {(r["from"], r["to"]) for r in data["missing"]}
    way = next(row for row in data["bridges"] if (row["from"], row["to"]) == ("one", "three"))
    # the measure between them joins both without a seam; the motion repeats itself, so it need not be that one
    assert max(way["begin_m"], way["end_m"]) < 0.02
    assert way["stop_s"] - way["start_s"] == pytest.approx(2.0, abs=0.31)
    told = CliRunner().invoke(app, ["steps", "graph", str(tmp_path), "--bridges", "--threshold", "0.001"])
    assert "bridge one → three: dance from" in told.output
    none = CliRunner().invoke(app, ["steps", "graph", str(PATCHES / "steps"), "--bridges"])
    assert none.exit_code != 0
    assert "no recordings to search" in none.output + str(none.exception)
