"""Bridges are found by entry points and by packages; what is missing, fails or clashes is left out."""

import importlib.metadata
import sys
from dataclasses import dataclass
from types import ModuleType, SimpleNamespace

import pytest

import live.app.bridges as bridges
from live.app.bridges import GROUP, Bridge, InstalledBridges, installed_bridges
from live.app.launch_options import LaunchOptions
from live.app.option_values import OPTION, option
from live.base.errors import PersonError
from live.control.message_codec import decode_packet, encode_packet
from live.show.loader import LoadedShow
from live.show.patch.patch import Patch
from live.show.patch.patch_reader import parse_patch, read_sources
from live.show.patch.section_base import Section
from live.show.venue.venue import read_venue
from tests.places import ROOT
from tests.show.made_show import GRAPH, PATCH


@dataclass(frozen=True, slots=True, kw_only=True)
class FoilOptions:
    foil: str | None = option(None, "Where the foil is.")


class FoilTable(Section):
    colour: int = 0


class FoilTables(Section):
    foil: tuple[FoilTable, ...] = ()


FOIL = Bridge(name="foil", options=FoilOptions, patch_tables=lambda: FoilTables, venue_tables=lambda: FoilTables)


@pytest.fixture
def find(monkeypatch):
    """Finds bridges where the metadata has these entries: name and package; values of packages by their names."""

    def find(entries, **packages):
        for name, value in packages.items():
            module = ModuleType(name)
            module.BRIDGE = value
            monkeypatch.setitem(sys.modules, name, module)
        made = [importlib.metadata.EntryPoint(name, module, GROUP) for name, module in entries]
        monkeypatch.setattr(bridges.importlib.metadata, "entry_points", lambda group: made if group == GROUP else [])
        return installed_bridges.__wrapped__()

    return find


def test_own_bridges_are_found_without_metadata_and_in_order_of_names(find):
    found = find([])
    folders = sorted(path.parent.name for path in (ROOT / "live" / "bridges").glob("*/__init__.py"))
    assert [bridge.name for bridge in found.bridges] == folders
    assert found.left_out == {}


def test_metadata_of_the_project_names_each_bridge():
    import tomllib

    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert project["entry-points"][GROUP] == {
        bridge.name: f"{GROUP}.{bridge.name}" for bridge in installed_bridges().bridges
    }


def test_bridge_of_another_package_is_found_by_its_entry_point(find):
    found = find([("foil", "their_foil")], their_foil=FOIL)
    assert FOIL in found.bridges
    assert FoilTables in found.patch_tables()
    assert FoilTables in found.venue_tables()
    assert "foil" in found.status()["installed"]


def test_bridge_that_is_gone_is_left_out_silently_and_one_that_fails_with_a_note(find):
    clashing = Bridge(name="tinsel", options=FoilOptions)
    entries = [("old", "live.bridges.old"), ("dull", "dull"), ("foil", "foil"), ("tinsel", "tinsel")]
    found = find(entries, dull="no bridge", foil=FOIL, tinsel=clashing)
    assert found.status()["left_out"] == {
        "old": "its package is gone",
        "dull": "TypeError: dull.BRIDGE is no bridge",
        "tinsel": "ValueError: bridge foil has an option foil, too",
    }
    notes = found.notes(LoadedShow(ROOT / "test.toml", parse_patch(PATCH, "test.toml"), GRAPH), None)
    assert [note.partition(":")[0] for note in notes] == ["bridge dull is left out", "bridge tinsel is left out"]


def test_every_option_of_a_bridge_is_written_and_passed_on_as_data():
    core = set(LaunchOptions.__dataclass_fields__)
    for bridge in installed_bridges().bridges:
        for name, field in bridge.options.__dataclass_fields__.items():
            assert field.metadata[OPTION].help
            assert name not in core
            value = getattr(bridge.options(), name)
            assert decode_packet(encode_packet(value)) in (value, list(value or ()))


# -- tables ------------------------------------------------------------------------------------------------------


def write_patch(tmp_path, text):
    path = tmp_path / "test.toml"
    path.write_text(PATCH + text, encoding="utf-8")
    return path


def test_table_without_its_bridge_is_kept_and_noted_with_file_and_line(tmp_path):
    path = write_patch(tmp_path, "[[foil]]\ncolour = 3\n")
    patch, sources = read_sources(path)
    assert Patch.model_validate(patch.to_json_values()).bridge_tables == {"foil": [{"colour": 3}]}
    (note,) = InstalledBridges((), {}).notes(LoadedShow(path, patch, GRAPH, sources=sources), None)
    line = PATCH.count("\n") + 1
    assert note == f"{path}, line {line}: foil: no installed bridge reads this table; the show plays without it"


def test_table_of_an_installed_bridge_is_checked_and_read(tmp_path):
    path = write_patch(tmp_path, '[[foil]]\ncolour = "3"\n')
    patch, sources = read_sources(path, [FoilTables])
    assert patch.read_tables(FoilTables).foil == (FoilTable(colour=3),)
    assert patch.bridge_tables == {"foil": [{"colour": 3}]}  # as the section gives it
    assert InstalledBridges((FOIL,), {}).notes(LoadedShow(path, patch, GRAPH, sources=sources), None) == []
    assert parse_patch(PATCH, "test.toml").read_tables(FoilTables).foil == ()


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("[[foil]]\n[[foil]]\ncolour = 'red'", 2, r"foil\.2\.colour: .*integer, found the text 'red'"),
        ("[[foil]]\ncolor = 3", 1, r"foil\.1\.color: unknown key; did you mean 'colour'\? allowed are colour"),
        ("[[foyl]]\ncolour = 3", 0, r"foyl: unknown key; did you mean 'foil'\?"),
        ("[[elemnt]]", 0, r"elemnt: unknown key; did you mean 'element'\?"),
    ],
)
def test_wrong_table_is_refused_with_line_and_field(text, line, words):
    line += PATCH.count("\n") + 1
    with pytest.raises(PersonError, match=rf"test\.toml, line {line}: {words}"):
        parse_patch(PATCH + text, "test.toml", [FoilTables])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("foil = 3", r"line 1: foil: a list expected, found 3"),
        ("tinsel = 3", r"line 1: tinsel: unknown key; allowed are name, seed, .*signal, curve, foil"),
        ("tinsel = []", r"line 1: tinsel: unknown key; allowed are name"),
    ],
)
def test_value_that_is_no_table_is_refused(text, words):
    with pytest.raises(PersonError, match=words):
        parse_patch(f"{text}\n{PATCH}", "test.toml", [FoilTables])


def test_venue_with_a_table_of_a_bridge_is_read_with_and_without_it(tmp_path, monkeypatch):
    monkeypatch.setattr("live.show.venue.venue.user_venue_folder", lambda: tmp_path)
    (tmp_path / "hall.toml").write_text('name = "hall"\n[[foil]]\ncolour = 3\n', encoding="utf-8")
    assert read_venue("hall", [FoilTables]).read_tables(FoilTables).foil == (FoilTable(colour=3),)
    loaded = SimpleNamespace(patch=parse_patch(PATCH, "test.toml"))
    assert InstalledBridges((), {}).notes(loaded, read_venue("hall")) == [
        "venue hall: foil: no installed bridge reads this table; the show plays without it"
    ]
    (tmp_path / "hall.toml").write_text("[[foil]]\ncolour = -\n[midy]\n", encoding="utf-8")
    with pytest.raises(PersonError, match=r"hall\.toml, line 2"):
        read_venue("hall", [FoilTables])
    (tmp_path / "hall.toml").write_text("[midy]\n", encoding="utf-8")
    with pytest.raises(PersonError, match=r"midy: unknown key; did you mean 'midi'\?"):
        read_venue("hall")
