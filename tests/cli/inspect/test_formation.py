"""`live formation`: pictures, paths, JSON, files, and refusals."""

import json
import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment
from typer.testing import CliRunner

from live.base.errors import PersonError
from live.cli.main import app

SVG = "{http://www.w3.org/2000/svg}"


def run(*arguments):
    return CliRunner().invoke(app, ["formation", *map(str, arguments)])


def elements_of_class(file, tag, name):
    return [each for each in ElementTree.parse(file).getroot().iter(f"{SVG}{tag}") if each.get("class") == name]


def test_picture_shows_all_dancers_to_scale_with_public_below(tmp_path):
    file = tmp_path / "arc.svg"
    table = tmp_path / "arc.json"
    table.write_text(json.dumps({"shape": "arc", "soloists": 1, "size": [6, 3], "sections": [4, 6]}))
    done = run(table, "--svg", file, "--dancers", 11, "--json")
    assert done.exit_code == 0, done.output
    report = json.loads(done.stdout)
    dancers, soloists = elements_of_class(file, "circle", "dancer"), elements_of_class(file, "circle", "soloist")
    assert (len(dancers), len(soloists)) == (10, 1)
    assert report["section"] == [None, *[1] * 4, *[2] * 6]
    drawn = np.array([(float(each.get("cx")), float(each.get("cy"))) for each in [*soloists, *dancers]])
    metres = np.array(report["slots"])
    assert drawn - drawn[0] == pytest.approx(60 * (metres - metres[0]), abs=0.11)
    assert len({each.get("fill") for each in dancers}) == 2
    assert any("public below" in (text.text or "") for text in ElementTree.parse(file).getroot().iter(f"{SVG}text"))


def test_transition_paths_are_optimal_matching(tmp_path):
    file = tmp_path / "star.svg"
    done = run("star", "--from", "grid", "--dancers", 24, "--svg", file, "--json")
    assert done.exit_code == 0, done.output
    report = json.loads(done.stdout)
    start, goal = np.array(report["from"]["slots"]), np.array(report["slots"])
    to = np.array(report["from"]["to"]) - 1
    assert sorted(to) == list(range(24))
    squared = ((start[:, None] - goal[None]) ** 2).sum(axis=2)
    best = squared[linear_sum_assignment(squared)].sum()
    assert squared[np.arange(24), to].sum() == pytest.approx(best)
    assert report["from"]["total_m"] == pytest.approx(np.sqrt(squared[np.arange(24), to]).sum(), abs=1e-4)
    assert len(elements_of_class(file, "polyline", "way")) == 24


def test_formation_beyond_stage_is_reported_with_working_remedy(tmp_path):
    done = run("circle", "--stage", "4x4", "--dancers", 12, "--json")
    report = json.loads(done.stdout)
    assert not report["fits"]
    assert report["outside"]
    factor = float(re.search(r"make it ([0-9.]+)", report["remedy"]).group(1))
    table = tmp_path / "c.json"
    table.write_text(json.dumps({"shape": "circle", "size": [5 * factor, 5 * factor]}))
    assert json.loads(run(table, "--stage", "4.04x4.04", "--dancers", 12, "--json").stdout)["fits"]
    assert "places are not on the stage of 4 x 4 m" in run("circle", "--stage", "4x4", "--dancers", 12).stdout


@pytest.mark.long
def test_formations_in_one_file_are_selected_by_name(tmp_path):
    file = tmp_path / "show.toml"
    file.write_text(
        '[[formation]]\nname = "gate"\nshape = "arc"\ncount = 7\n[[formation]]\nname = "sky"\nshape = "star"\n'
    )
    assert len(json.loads(run(f"{file}:gate", "--json").stdout)["slots"]) == 7
    assert json.loads(run(f"{file}:sky", "--json").stdout)["name"] == "sky"
    with pytest.raises(PersonError, match="has 2 formations"):
        raise run(file).exception
    with pytest.raises(PersonError, match="gate, sky"):
        raise run(f"{file}:moon").exception


def test_svg_file_is_used_as_formation(tmp_path):
    file = tmp_path / "wave.svg"
    file.write_text('<svg xmlns="http://www.w3.org/2000/svg"><path d="M 0 0 C 10 20 20 -20 30 0"/></svg>')
    report = json.loads(run(f"svg:{file}", "--dancers", 9, "--json").stdout)
    assert len(report["slots"]) == 9
    assert report["slots"][0][0] == pytest.approx(-4.0)
    assert json.loads(run(file, "--dancers", 9, "--json").stdout)["slots"] == report["slots"]


def test_dancer_count_comes_from_file_and_excess_dancers_are_reported(tmp_path):
    file = tmp_path / "f.toml"
    file.write_text('shape = "circle"\nspacing = 1.0\nsize = [4, 4]\n')
    assert len(json.loads(run(file, "--json").stdout)["slots"]) == 13
    report = json.loads(run(file, "--dancers", 15, "--json").stdout)
    assert (report["waiting"], report["empty"]) == (2, 0)
    assert "2 dancers have no place" in report["warnings"][0]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["blob"], "unknown formation"),
        (["circle", "--dancers", -1], "--dancers"),
        (["circle", "--dancers", 10**6], "--dancers"),
        (["circle", "--stage", "big"], "--stage"),
        (["circle", "--stage", "nanx8"], "--stage"),
        (["circle", "--seed", -1], "--seed"),
        (["circle", "--from", "blob"], "unknown formation"),
        (["circle", "--svg", "picture.png"], "--svg"),
        (["circle", "--svg", "/nowhere/at/all.svg"], "--svg"),
        (["nothing.toml"], "cannot be read"),
        (["svg:nothing.svg"], "cannot be read"),
        (["text:?"], "not in the font"),
    ],
)
def test_invalid_options_are_refused(arguments, words):
    done = run(*arguments)
    assert isinstance(done.exception, PersonError)
    assert words in str(done.exception)


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.toml", "shape = ", "line 1"),
        ("a.json", "{", "not JSON"),
        ("a.json", "[1]", "a table expected"),
        ("a.toml", "formation = [1]", "no formation in it"),
        ("a.toml", 'shape = "star"\ncolour = 1', "unknown key 'colour'"),
        ("a.toml", 'shape = "star"\nsize = [nan, 1]', "size"),
        ("a.svg", "<svg", "not an SVG"),
    ],
)
def test_invalid_files_are_refused(tmp_path, name, text, words):
    (tmp_path / name).write_text(text)
    done = run(tmp_path / name)
    assert isinstance(done.exception, PersonError)
    assert words in str(done.exception)
