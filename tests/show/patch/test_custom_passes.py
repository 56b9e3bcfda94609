"""Custom passes of a patch: from the GLSL file into patch, parameter row and journal; set while the show runs."""

import pytest

from live.base.picture_parameters import CUSTOM_PASS_SLICE, picture_row
from live.control.registry.registry import REGISTRY
from live.control.registry.rejections import Rejection
from live.show.patch.hot_reload import file_stamp
from live.show.patch.patch_reader import custom_pass_files, read_patch
from live.show.patch.patch_search_path import PatchError
from live.show.view.render_scene import make_scene
from tests.show.desk.desk_show import DeskSession
from tests.show.made_show import PATCH

WAVES = "uniform float speed; // 0 4 1\nvec4 pass(vec2 at) { return vec4(light(at + speed), 1.0); }\n"
PICTURE = '[picture]\npasses = ["shadow", "waves", "vignette"]\n'


@pytest.fixture
def pass_folder(tmp_path):
    (tmp_path / "passes").mkdir()
    (tmp_path / "passes" / "waves.glsl").write_text(WAVES)
    (tmp_path / "a.toml").write_text(PATCH + PICTURE + 'set = { "/dance/pass/waves/speed" = 2.5 }\n')
    return tmp_path


def test_glsl_file_is_read_into_the_patch(pass_folder):
    patch = read_patch(pass_folder / "a.toml")
    (own,) = patch.picture.own_passes
    assert (own.name, own.source) == ("waves", WAVES)
    row = picture_row(make_scene(patch))
    assert row[CUSTOM_PASS_SLICE][:3].tolist() == [1.0, 2.5, 0.0]
    again = type(patch).model_validate(patch.to_json_values())  # as a journal has it, wherever the file is then
    assert again.picture.own_passes == patch.picture.own_passes


def test_edited_glsl_file_changes_the_patch_stamp(pass_folder):
    path = pass_folder / "a.toml"
    before = file_stamp(path)
    (pass_folder / "passes" / "waves.glsl").write_text(WAVES + "// longer\n")
    assert custom_pass_files(path) == [pass_folder / "passes" / "waves.glsl"]
    assert file_stamp(path) != before


@pytest.mark.parametrize(
    ("glsl", "extra", "words"),
    [
        (None, "", "no pass 'waves'.*passes/NAME.glsl"),
        ("vec3 pass() {}", "", "passes/waves.glsl: no `vec4 pass"),
        ("uniform float a;\n" + WAVES, "", "passes/waves.glsl, line 1: uniform 'a' has no range"),
        (WAVES, 'set = { "/dance/pass/waves/speed" = 5.0 }\n', "0 to 4 expected"),
        (WAVES, 'set = { "/dance/pass/waves/sped" = 1.0 }\n', "no parameter of the picture"),
    ],
)
def test_pass_errors_are_reported_with_line_before_show(pass_folder, glsl, extra, words):
    path, file = pass_folder / "a.toml", pass_folder / "passes" / "waves.glsl"
    path.write_text(PATCH + PICTURE + extra)
    file.unlink()
    if glsl is not None:
        file.write_text(glsl)
    with pytest.raises(PatchError, match=words) as refused:
        read_patch(path)
    line = len(PATCH.splitlines()) + (3 if extra else 2)
    assert f"a.toml, line {line}" in str(refused.value)


def test_pass_amount_and_parameters_are_set_faded_and_undone():
    text = WAVES.replace("\n", "\\n")
    hands = DeskSession(PICTURE + f'[[picture.own]]\nname = "waves"\nsource = "{text}"\n').run(4)

    def values():
        return hands.desk.parameters.picture[CUSTOM_PASS_SLICE][:2].tolist()

    assert values() == [1.0, 1.0]
    assert hands.say("/dance/pass", "waves", 0.5)
    assert hands.say("/dance/pass/waves/speed", 3.0, 1)
    hands.run(2)
    assert values() == [0.5, pytest.approx(2.0)]
    assert hands.say("/dance/pass/set", "waves", "speed", 9.0)  # no more than there can be
    hands.run(3)
    assert values() == [0.5, 4.0]
    assert hands.say("/dance/pass/waves", 0)
    assert hands.say("/dance/undo")
    hands.run(1)
    assert values()[0] == 0.5
    assert not hands.say("/dance/pass/waves/hight", 1.0)
    assert "'waves' has no parameter 'hight'" in hands.words
    assert not hands.say("/dance/pass/set", "ink", "colour", 1.0)


@pytest.mark.parametrize("address", ["/dance/pass/", "/dance/pass//", "/dance/pass/a/b/c", "/dance/pass/a//b"])
def test_malformed_pass_addresses_are_refused(address):
    for values in ((), (1.0,), (1.0, 2.0, 3.0, 4.0)):
        result = REGISTRY.call(address, values, 0.0, "osc")
        assert isinstance(result, Rejection) or result.name
