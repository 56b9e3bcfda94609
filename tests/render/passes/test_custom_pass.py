"""Custom passes of a patch: their inputs, error messages, and the time limit of their trial."""

import time
from dataclasses import replace

import numpy as np
import pytest

from live.base.custom_pass import PASSES, custom_pass_numbers, parse_custom_pass
from live.base.errors import PersonError
from live.base.picture_parameters import CUSTOM_PASS_SLICE, picture_row
from live.render.adaptive_quality import HARDWARE, SOFTWARE
from live.render.custom_pass import first_error, try_passes
from live.render.renderer import Renderer
from tests.fixtures.mostly_long import mostly_long
from tests.render.passes.test_passes import SCENE, SIZE, has_detail, three_dancers
from tests.render.test_renderer import read

NEGATIVE = "vec4 pass(vec2 at) { return vec4(vec3(0.5) - min(light(at), vec3(0.5)), 1.0); }\n"
WAVES = """// Waves that run over the picture with the beat.
uniform float speed;   // 0 4 1   waves in a beat
uniform float height;  // 0 0.2 0.02
vec4 pass(vec2 at) {
    at.y += height * sin(6.2831853 * (4.0 * at.x + beat * speed));
    return vec4(light(at), 1.0);
}
"""


def parse_pass(name, source):
    return parse_custom_pass(name, source)


@pytest.fixture
def draw(gl_context):
    """Draws moments (view, beat) with custom passes; returns the last picture, the renderer, its row and the target."""
    kept = []

    def drawn(passes, *moments, quality=SOFTWARE, values=None):
        order = (*PASSES[:-1], *(one.name for one in passes), "vignette")
        scene = replace(SCENE, custom_passes=tuple(passes), passes=order)
        renderer, target = Renderer(gl_context, scene, size=SIZE, quality=quality), gl_context.simple_framebuffer(SIZE)
        kept.extend((renderer, target))
        row = picture_row(scene)
        for address, value in (values or {}).items():
            row[CUSTOM_PASS_SLICE.start + custom_pass_numbers(scene.custom_passes)[address].index] = value
        for view, beat in moments or ((three_dancers(), 0.0),):
            view.picture, view.beat = row, beat
            renderer.draw(view, target)
        return read(target), renderer, row, target

    yield drawn
    for thing in kept:
        thing.release()


# -- texts -----------------------------------------------------------------------------------------------------


def test_uniform_with_range_is_parameter():
    found = parse_pass("waves", WAVES)
    assert [(one.name, one.low, one.high, one.start) for one in found.parameters] == [
        ("speed", 0.0, 4.0, 1.0),
        ("height", 0.0, 0.2, 0.02),
    ]
    assert found.parameters[0].description == "waves in a beat"
    numbers = custom_pass_numbers((parse_pass("first", NEGATIVE), found))
    assert list(numbers) == [
        "/dance/pass/first", "/dance/pass/waves", "/dance/pass/waves/speed", "/dance/pass/waves/height",
    ]  # fmt: skip
    assert len({one.index for one in numbers.values()}) == 4


@pytest.mark.parametrize(
    ("name", "source", "words"),
    [
        ("Waves", NEGATIVE, "cannot be called 'Waves'"),
        ("a/b", NEGATIVE, "cannot be called"),
        ("waves", "void main() {}", "no `vec4 pass"),
        ("waves", "uniform float a;\n" + NEGATIVE, "passes/waves.glsl, line 1: uniform 'a' has no range"),
        ("waves", "\nuniform float a; // 1 0 0.5\n" + NEGATIVE, "line 2: uniform 'a' has no range"),
        ("waves", "uniform float a; // 0 1 nan\n" + NEGATIVE, "line 1: uniform 'a' has no range"),
        ("waves", "uniform vec3 a; // 0 1 1\n" + NEGATIVE, "line 1: uniform 'a' is a vec3"),
        ("waves", "uniform float beat; // 0 1 1\n" + NEGATIVE, "'beat' is predefined"),
        ("waves", "uniform float a; // 0 1 1\n" * 2 + NEGATIVE, "line 2: a second uniform 'a'"),
        ("waves", "".join(f"uniform float a{i}; // 0 1 1\n" for i in range(16)) + NEGATIVE, "16 uniforms"),
        ("waves", "//" + "x" * 40_000 + "\n" + NEGATIVE, "at most 32000"),
    ],
)
def test_invalid_source_is_refused_with_line(name, source, words):
    with pytest.raises(PersonError, match=words.replace("(", r"\(")):
        parse_pass(name, source)


@pytest.mark.parametrize(
    ("log", "line"),
    [
        ("GLSL Compiler failed\n\nfragment_shader\n===\n0:3(12): error: `x' undeclared", 3),  # Mesa
        ('0(7) : error C1503: undefined variable "x"', 7),  # NVIDIA
        ("ERROR: 0:12: Use of undeclared identifier 'x'", 12),  # Apple, AMD
    ],
)
def test_line_is_read_from_log_of_every_driver(log, line):
    told = first_error("waves", log)
    assert told.startswith(f"passes/waves.glsl, line {line}: ")
    assert "x" in told.split(": ", 1)[1]


# -- pictures --------------------------------------------------------------------------------------------------


@pytest.mark.gl
@mostly_long("quality", [SOFTWARE, HARDWARE], quick=[], ids=["software", "card"])
def test_custom_pass_draws_and_amount_of_0_disables_it(draw, quality):
    plain = draw((), quality=quality)[0].astype(int)
    negative = draw((parse_pass("negative", NEGATIVE),), quality=quality)[0].astype(int)
    none = draw((parse_pass("negative", NEGATIVE),), quality=quality, values={"/dance/pass/negative": 0.0})[0]
    assert np.array_equal(none, plain)
    assert negative.mean() > plain.mean() + 60
    bright = plain.max(axis=2) > 150
    assert negative[bright].mean() < negative[~bright].mean() - 30


@pytest.mark.long
@pytest.mark.gl
def test_custom_pass_receives_parameters_and_beat(draw):
    waves = parse_pass("waves", WAVES)
    usual, higher, later = (
        draw((waves,), (three_dancers(), beat), values={"/dance/pass/waves/height": height})[0].astype(int)
        for height, beat in ((0.02, 0.0), (0.1, 0.0), (0.02, 0.25))
    )
    assert np.abs(usual - higher).mean() > 0.5
    assert np.abs(usual - later).mean() > 0.1


@pytest.mark.long
@pytest.mark.gl
def test_custom_pass_receives_surfaces_and_last_picture(draw):
    source = """vec4 pass(vec2 at) {
        if (dancer(at) == 0) return vec4(0.0, 0.0, 0.0, 1.0);
        float away = depth(at);
        return vec4(away > 3.0 && away < 8.0, float(dancer(at)) / 3.0, normal(at).z > 0.0, 1.0);
    }"""
    picture = draw((parse_pass("seen", source),))[0]
    somebody = picture.max(axis=2) > 60
    assert 0.02 < somebody.mean() < 0.3
    assert (picture[somebody][:, 0] > 100).mean() > 0.95  # all of them are that far away
    assert (picture[somebody][:, 2] > 100).mean() > 0.8  # nearly all that is seen faces the eye
    greens = [round(float(np.median(picture[:, part][somebody[:, part]][:, 1]))) for part in
              (slice(0, 100), slice(118, 138), slice(156, 256))]  # fmt: skip
    assert greens == sorted(set(greens))  # dancers one, two, three from left to right
    brighter = parse_pass("brighter", "vec4 pass(vec2 at) { return vec4(last(at) + 0.02, 1.0); }")
    means = [
        draw((brighter,), *((three_dancers(), beat / 8) for beat in range(count)))[0].mean() for count in (1, 4, 8)
    ]
    assert means == sorted(means)
    assert means[2] > means[0] + 20


@pytest.mark.long
@pytest.mark.gl
def test_nan_output_is_black(draw):
    picture = draw((parse_pass("nan", "vec4 pass(vec2 at) { return vec4(vec3(sqrt(at.x - 2.0)) / 0.0, 1.0); }"),))[0]
    assert picture.max() <= 1


@pytest.mark.gl
def test_valid_source_replaces_pass_and_invalid_source_does_not(draw):
    picture, renderer, row, target = draw((parse_pass("mine", NEGATIVE),))
    renderer.set_custom_passes((parse_pass("mine", WAVES),))
    view = three_dancers()
    view.picture = row
    renderer.draw(view, target)
    waves = read(target)
    assert np.abs(waves.astype(int) - picture).mean() > 20
    with pytest.raises(PersonError, match=r"passes/mine.glsl, line 2: "):
        renderer.set_custom_passes((parse_pass("mine", "\nvec4 pass(vec2 at) { return nothing; }"),))
    renderer.draw(view, target)
    assert np.array_equal(read(target), waves)


@pytest.mark.gl
def test_golden_custom_pass(draw, golden):
    kaleidoscope = """vec4 pass(vec2 at) {
        vec2 p = (at - 0.5) * vec2(size.x / size.y, 1.0);
        float a = abs(mod(atan(p.y, p.x) + beat, 1.0471976) - 0.5235988), r = length(p);
        return vec4(light(vec2(cos(a), sin(a)) * r * vec2(size.y / size.x, 1.0) + 0.5), 1.0);
    }"""
    golden(draw((parse_pass("kaleidoscope", kaleidoscope),), (three_dancers(), 0.4))[0], "own_pass", law=has_detail)


# -- trial -----------------------------------------------------------------------------------------------------


@pytest.mark.long
@pytest.mark.gl
def test_trial_accepts_valid_passes_and_reports_invalid_pass(gl_context):
    try_passes(())
    try_passes((parse_pass("waves", WAVES), parse_pass("negative", NEGATIVE)))
    with pytest.raises(PersonError, match=r"passes/bad.glsl, line 3: .*undefd"):
        try_passes((parse_pass("waves", WAVES), parse_pass("bad", "\n\nvec4 pass(vec2 at) { return undefd; }")))


@pytest.mark.long
@pytest.mark.gl
def test_endless_shader_is_stopped_in_trial(gl_context):
    # llvmpipe ends every loop after 65,535 rounds: rounds so long that nobody sees the last one
    rounds = "x = sin(x * 1.7 + 0.1); " * 400
    text = f"vec4 pass(vec2 at) {{ float x = at.x; while (x < 2.0) {{ {rounds} }} return vec4(x); }}"
    endless = parse_pass("endless", text)
    begin = time.monotonic()
    with pytest.raises(PersonError, match=r"passes/endless.glsl: not done after 4 s; check for a loop that never ends"):
        try_passes((endless,), limit=4.0)
    assert time.monotonic() - begin < 60.0
