"""Score sheet: every measure of every section once, with its entries, as text, picture and JSON."""

import json
import xml.etree.ElementTree as ElementTree

from typer.testing import CliRunner

from live.app.pictures.score_picture import score_picture
from live.cli.inspect.score import describe_sheet
from live.cli.main import app
from live.show.score.score_sheet import build_sheet
from tests.show.made_show import made_show

SCORE = (
    '[[section]]\nname = "verse"\nmeasures = 4\nrepeat = 2\n[[section]]\nname = "solo"\nmeasures = 2\nwait = true\n'
    '[[sequence]]\nsection = "verse"\ngroup = "front"\nmeasure = 2\nsteps = ["spin", "phrase"]\n'
    '[[improvise]]\nsection = "solo"\ngroup = "front"\n[[signal]]\nname = "hit"\nsection = "verse"\nmeasure = 3\n'
    'beat = 2.5\n[[segment]]\nsection = "verse"\nmeasure = 2\nmeasures = 3\nformation = "circle"\ngroup = "back"\n'
    '[[element]]\nkind = "spread"\nmeasure = 6\nmeasures = 4\n'
    '[[at]]\nsection = "solo"\nmeasure = 2\ncall = "/dance/step"\nvalues = ["sway", 2]\n'
)


def test_entries_appear_in_their_written_measures():
    sheet = build_sheet(made_show(SCORE))
    tracks = {track.name: [(box.first, box.last, box.label, box.kind) for box in track.boxes] for track in sheet.tracks}
    assert sheet.measures == 6
    assert tracks["section"] == [(0, 3, "verse, x2", "section"), (4, 5, "solo, until advance", "section")]
    assert tracks["signals"] == [(2, 2, "hit @2.5", "signal")]
    assert tracks["front"][:3] == [(0, 0, "sway", "own"), (1, 1, "spin", "sequence"), (2, 3, "phrase", "sequence")]
    assert {kind for first, _, _, kind in tracks["front"] if first >= 4} == {"improvised"}
    assert tracks["motion"] == [(1, 3, "circle (back)", "segment"), (5, 5, "spread", "element")]
    assert tracks["calls"] == [(5, 5, "step sway 2", "call")]
    for boxes in (tracks["front"], tracks["back"]):
        assert [measure for first, last, _, _ in boxes for measure in range(first, last + 1)] == list(range(6))


def test_picture_contains_every_box_in_its_measure():
    sheet = build_sheet(made_show(SCORE))
    picture = ElementTree.fromstring(score_picture(sheet, ["#ff8800", "#0088ff"], per_row=4))
    name = "{http://www.w3.org/2000/svg}"
    told = [title.text for title in picture.iter(f"{name}title")]
    for track in sheet.tracks:
        for box in track.boxes:
            rows = box.last // 4 - box.first // 4 + 1  # a box that goes over the end of a system is drawn in both
            assert told.count(f"{box.label}: {box.first + 1} to {box.last + 1}") >= rows


def test_score_without_measures_lists_group_steps():
    lines = describe_sheet(build_sheet(made_show()))
    assert lines[0] == "test: measures 1 to 16"
    assert any("(sway)" in line for line in lines)


def test_score_command_writes_json_and_svg_and_refuses_png(tmp_path):
    out = tmp_path / "score.svg"
    result = CliRunner().invoke(app, ["score", "score", "--svg", str(out), "--json"])
    assert result.exit_code == 0, result.output
    sheet = json.loads(result.stdout)
    assert sheet["measures"] == 32
    assert ElementTree.parse(out).getroot().tag.endswith("svg")
    wrong = CliRunner().invoke(app, ["score", "score", "--svg", str(tmp_path / "score.png")])
    assert wrong.exit_code != 0
