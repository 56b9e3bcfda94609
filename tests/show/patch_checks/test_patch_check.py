"""Checks of a patch run for whoever reads one from outside; the model itself knows no control and no other table."""

import ast

import pytest
from pydantic import ValidationError

from live.show.patch.patch import Patch
from live.show.patch_checks.entry_checks import ENTRY_CHECKS
from live.show.patch_checks.patch_check import PATCH_CHECKS, check_patch
from tests.places import ROOT

GROUP = {"name": "ember", "dancers": 3, "steps": ["groove"]}
UNKNOWN = {
    "at": {"measure": 1, "call": "/dance/nonsense"},
    "cue": {"name": "one", "calls": [["/dance/nonsense"]]},
    "formation": {"name": "wedge", "shape": "moon"},
    "group": {"name": "tide", "dancers": 3, "steps": ["groove"], "draw": {"inky": 1}},
    "improvise": {"motion": [{"call": "/dance/nonsense"}]},
    "looks": {"name": "lines", "draw": {"inky": 1}},
    "react": {"to": "low", "sets": "/dance/nonsense"},
    "scene": {"name": "dusk", "set": {"/dance/nonsense": 1}},
}
"""A table of each kind that names what does not exist."""
MODEL_IMPORTS = (
    "live.base", "live.motion.skeleton", "live.clock.bar_pointer.metre", "live.clock.follower.clock_source",
    "live.clock.measure_map", "live.motion.recognition.recognition_names", "live.show.patch.section_",
)  # fmt: skip


def values(**tables):
    return {"name": "p", "group": [GROUP, *tables.pop("group", ())], **tables}


@pytest.mark.parametrize("table", sorted(UNKNOWN))
def test_table_is_plain_data_until_a_reader_brings_the_checks(table):
    tables = values(**{table: [UNKNOWN[table]]})
    Patch.model_validate(tables)
    with pytest.raises(ValidationError, match=r"nonsense|inky|moon"):
        Patch.model_validate(tables, context=PATCH_CHECKS)


def test_picture_and_midi_map_are_checked_too():
    for tables in ({"picture": {"set": {"/dance/nonsense": 1}}}, {"midi": {"map": [{"note": 1, "control": "/no"}]}}):
        Patch.model_validate(values(**tables))
        with pytest.raises(ValidationError, match=r"/dance/nonsense|/no"):
            Patch.model_validate(values(**tables), context=PATCH_CHECKS)


def test_tables_are_checked_against_each_other_last():
    tables = values(cue=[{"name": "one", "scene": "dusk"}])
    patch = Patch.model_validate(tables, context=ENTRY_CHECKS)
    with pytest.raises(ValueError, match="no scene is called 'dusk'"):
        check_patch(patch)
    with pytest.raises(ValidationError, match="no scene is called 'dusk'"):
        Patch.model_validate(tables, context=PATCH_CHECKS)


def test_every_check_belongs_to_a_table():
    called = set()
    for path in (ROOT / "live/show/patch").glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "run_check":
                called.add(node.args[1].value)
    assert called == set(PATCH_CHECKS)


def _reads_unchecked(call):
    """Whether a call validates a patch without the checks. A document gives only those that its parts did not pass."""
    words = [ast.unparse(each) for each in (*call.args, *(word.value for word in call.keywords))]
    name = ast.unparse(call.func) if isinstance(call.func, ast.Name | ast.Attribute) else ""
    reads = name in ("validate_model", "parse_model", "validate_sources") and "Patch" in words
    return (reads or name.startswith("Patch.model_validate")) and not {"PATCH_CHECKS", "checks"} & set(words)


@pytest.mark.long
def test_every_patch_from_outside_is_checked():
    modules = [(path, ast.walk(ast.parse(path.read_text()))) for path in sorted((ROOT / "live").rglob("*.py"))]
    calls = [(path.name, node.lineno, node) for path, nodes in modules for node in nodes if isinstance(node, ast.Call)]
    assert [(name, line) for name, line, call in calls if _reads_unchecked(call)] == []


def test_model_imports_neither_controls_nor_checks():
    folder = ROOT / "live/show/patch"
    found = set()
    for path in (folder / "patch.py", *folder.glob("section_*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("live."):
                found |= {node.module} if not node.module.startswith(MODEL_IMPORTS) else set()
    assert found == set()


def test_more_dancers_than_any_machine_keeps_up_with_are_refused():
    many = [{**GROUP, "name": f"g{number}", "dancers": 10_000} for number in range(10)]
    with pytest.raises(ValidationError, match=r"100000 dancers in all groups; 20000 at most.*live bench frame"):
        Patch.model_validate({"name": "p", "group": many}, context=PATCH_CHECKS)
    Patch.model_validate({"name": "p", "group": many[:2]}, context=PATCH_CHECKS)
    with pytest.raises(ValidationError, match="less than or equal to 10000"):
        Patch.model_validate({"name": "p", "group": [{**GROUP, "dancers": 100_000}]}, context=PATCH_CHECKS)
