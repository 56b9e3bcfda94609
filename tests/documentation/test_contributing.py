"""The worked examples of CONTRIBUTING.md: each change has at most so many files, works, and appears everywhere."""

import pytest

from tests.documentation.example_change import read_example, run_example
from tests.fixtures.mostly_long import mostly_long
from tests.places import ROOT

TEXT = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")

PARAMETER = """
from live.control.events.parameters import SetParameter
from live.control.registry.registry import READABLE, REGISTRY
from live.show.desk.parameter_table import ParameterTable, check_setting
from live.show.patch.patch_reader import parse_patch
from live.show.patch.patch_schema import patch_schema
from tests.control.osc.osc_table import every_control
from tools.reference.reference_pages import reference_pages

address = "/dance/motion/accent"
event = REGISTRY.call(address, (0.5, "ember", 2), 0.0, "osc")
assert event == SetParameter(time=0.0, source="osc", address=address, value=(0.5,), group="ember", measures=2.0)
assert address in READABLE and address in every_control()
assert len(ParameterTable(["ember", "mist"]).find(address)) == 2
check_setting(address + " ember", 0.5)
patch = parse_patch('''
name = "x"
[[group]]
name = "ember"
dancers = 2
steps = ["groove"]
motion = { accent = 0.25 }
''', "x.toml")
assert patch.motion_of(patch.group[0]).accent == 0.25
pages = reference_pages()
assert "accent" in str(patch_schema())
assert address in pages["osc/steps.md"] and "`accent`" in pages["patch/motion.md"]
"""
COMMAND = """
from live.control.events.event_json import event_from_json, event_to_json
from live.control.registry.registry import REGISTRY
from tests.control.osc.osc_table import every_control
from tools.reference.osc_pages import osc_pages

event = REGISTRY.call("/dance/obstacle/clear", ("tree",), 0.0, "osc")
assert event_from_json(event_to_json(event)) == event
assert "/dance/obstacle/clear" in every_control() and "/dance/obstacle/clear [begins]" in osc_pages()["groups.md"]
"""
ELEMENT = """
from live.control.registry.registry import REGISTRY
from live.show.group.elements import make_element
from live.show.patch.section_elements import ElementSection

event = REGISTRY.call("/dance/tide", (2.0, 8.0), 0.0, "osc")
element = make_element(event, groups=1, target_group=-1, start=4.0, beats_per_measure=4)
assert (element.strength, element.end_beat) == (2.0, 36.0)
assert ElementSection(kind="tide", measure=3).kind == "tide"
"""
LOOK = """
from live.control.registry.registry import REGISTRY
from live.show.desk.parameter_table import check_setting

assert REGISTRY.find("/dance/draw/halo").start == (0.0,)
check_setting("/dance/draw/halo ember", 0.5)
"""
INPUT = """
from live.app.bridges import installed_bridges

assert "pedal" in [bridge.name for bridge in installed_bridges().bridges]
"""


@mostly_long(
    ("title", "limit", "options"),
    [
        ("A parameter", 3, {"checks": PARAMETER}),
        pytest.param("A command", 3, {"checks": COMMAND}, marks=pytest.mark.long),
        pytest.param("An element", 4, {"checks": ELEMENT, "jit": False}, marks=pytest.mark.long),
        pytest.param(
            "A look",
            3,
            {"checks": LOOK, "plugins": ("tests.render.conftest",)},
            marks=[pytest.mark.gl, pytest.mark.long],
        ),
        ("An input", 5, {"checks": INPUT}),
    ],
    quick=[4],
)
def test_worked_example_works_and_has_few_files(title, limit, options, tmp_path):
    files = read_example(TEXT, title)
    assert 0 < len(files) <= limit
    assert any(place.rpartition("/")[2].startswith("test_") for place in files)
    run_example(files, tmp_path, **options)
