"""Tests of the thesis' four experiments as patches: loading, endurance, stage limits and motion quality."""

import numpy as np
import pytest

from live.motion.skeleton import SKELETON
from live.motion.step_clip import DIRECTIONS
from live.show.journal.motion_report import MotionReport
from live.show.loader import load_from_patch, load_show
from live.show.patch.patch_reader import read_patch
from live.show.patch.patch_search_path import find_patch
from tests.fixtures.hips import hips as hips_at

EXPERIMENTS = ("samba", "tap", "contemporary", "ballet")
MEASURES = {"samba": 20, "tap": 52, "contemporary": 22, "ballet": 20}
"""Until the score has acted; `make soak` goes on to 64."""
LEFT_ARM, RIGHT_ARM = (SKELETON.index(f"{side}UpperArm") for side in ("left", "right"))
TICKS_PER_FRAME = 2


RUNS = [
    *(
        pytest.param((name, MEASURES[name]), marks=pytest.mark.long, id=name)
        for name in ("tap", "contemporary", "samba", "ballet")
    ),
    *(pytest.param((name, 64), marks=pytest.mark.soak, id=f"{name}-64") for name in EXPERIMENTS),
]


@pytest.fixture(scope="module", params=RUNS)
def experiment_run(request):
    """The show after its measures, hips per frame (F, A, 2), the largest acceleration, the report; and for each measure
    line hips (A, 2), segment targets, headings (A,), agents (A, 2) and the state hash.
    """
    name, measures = request.param
    show = load_show(find_patch(name)).start()
    view, report, tick = show.view(), MotionReport(show), 0
    hips, last, strongest, lines = [], [], 0.0, {}
    while show.span.number < measures:
        tick += 1
        if show.tick(tick / 64):
            lines[show.span.number] = _at_line(show)
        if tick % (TICKS_PER_FRAME if show.span.number < 12 else 16):  # later only positions
            continue
        show.fill(view, tick / 64)
        seen = view.joint_position[view.present]
        assert np.isfinite(view.joint_position).all()
        assert seen[..., 1].min() > -0.02
        if show.span.number < 12:  # the score has acted by then, and feet, knees and hands have been everywhere
            report.frame(view)
            last = [*last[-2:], seen.astype(np.float64)]
            if len(last) == 3:
                bend = np.linalg.norm(last[2] - 2.0 * last[1] + last[0], axis=-1)
                strongest = max(strongest, float(bend.max()) * (64 / TICKS_PER_FRAME) ** 2)
        hips.append(seen[:, 0][:, (0, 2)].copy())
    return name, show, np.array(hips), strongest, report.result(), lines


def _at_line(show):
    on = show.motion.present
    _, wanted, _ = show.motion.evolutions.target(show.span.number * show.timeline.beats_per_measure)
    heading = show.dancers.present.begin_heading()[on]
    return hips_at(show.dancers, 0.0)[on], wanted[on], heading, show.state.position[on], show.state_hash()


def _degrees(angle):
    return np.degrees(np.abs(np.arctan2(np.sin(angle), np.cos(angle))))


@pytest.mark.long
def test_scheduler_has_no_dead_ends_or_detours(experiment_run):
    _, show, _, _, _, _ = experiment_run
    assert show.scheduler.dead_ends == 0
    assert show.scheduler.detours == 0
    assert show.graph.missing == ()


@pytest.mark.long
def test_dancers_stay_on_stage(experiment_run):
    _, show, hips, _, _, _ = experiment_run
    assert np.abs(hips[..., 0]).max() < show.patch.stage.width / 2
    assert np.abs(hips[..., 1]).max() < show.patch.stage.depth / 2


def test_joints_do_not_pop_and_support_feet_do_not_slide(experiment_run):
    """At 32 frames/s the fastest knee of a jump shows 160 m/s²; a joint that pops shows thousands."""
    _, _, _, strongest, figures, _ = experiment_run
    assert strongest < 190.0
    assert figures["foot_slide_mean"] < 0.03
    assert figures["beat_offset_ms"]["annotated"]["p95"] < 15.0


def test_dancers_keep_apart(experiment_run):
    _, show, _, _, figures, _ = experiment_run
    assert show.motion.present.sum() == 1 or figures["min_distance_m"] > 0.35


def test_tap_reaches_three_formations_and_faces_audience(experiment_run):
    """T126: formations are reached at their measure lines; headings follow the path and turn back smoothly (T127)."""
    name, _, _, _, _, lines = experiment_run
    if name != "tap":
        pytest.skip("the experiment with formations")
    standing = {}
    for line in (16, 32, 48):
        hips, wanted, _, _, _ = lines[line]
        assert np.hypot(*(hips - wanted).T).max() < 0.1
        standing[line] = hips
    assert np.abs(np.hypot(standing[16][:, 0] / 4.3, (standing[16][:, 1] - 0.2) / 2.6) - 1.0).max() < 0.05  # the ring
    assert len(np.unique(np.round(standing[48][:, 1], 0))) == 3  # the lines
    for line in (20, 23, 36, 39):  # at 24 and 40 they set off, in a step that begins up to 7 degrees aside
        assert _degrees(lines[line][2]).max() < 1.0
    way = lines[30][0] - lines[28][0]
    going = np.hypot(*way.T) > 0.4
    assert going.sum() >= 5
    assert _degrees(lines[29][2] - np.arctan2(way[:, 0], way[:, 1]))[going].max() < 30.0


def test_contemporary_crosses_the_bar(experiment_run):
    """T110, T132: after the bar in the middle, in measures 12 to 20, each dancer is on the other side."""
    name, _, _, _, _, lines = experiment_run
    if name != "contemporary":
        pytest.skip("the experiment with elements")
    before, after = lines[11][3][:, 0], lines[20][0][:, 0]
    assert (np.sign(before) != np.sign(after)).all()
    assert np.abs(after).min() > 0.5


@pytest.mark.long
def test_repeated_show_is_bit_identical(experiment_run):
    """Rendering, as in the first run, does not change the state."""
    name, _, _, _, _, lines = experiment_run
    show, tick = load_show(find_patch(name)).start(), 0
    while show.span.number < 8:
        tick += 1
        show.tick(tick / 64)
    assert show.state_hash() == lines[8][4]


@pytest.mark.long
def test_samba_alternates_feet_in_random_walks_and_faces_audience():
    show = load_show(find_patch("samba")).start()
    view, library, chosen, across = show.view(), show.graph.library, [], []
    for tick in range(1, 64 * 30):
        if show.tick(tick / 64):
            chosen.append(show.dancers.node.copy())
        if tick % 8 == 0:
            show.fill(view, tick / 64)
            across.append(view.joint_position[:, LEFT_ARM] - view.joint_position[:, RIGHT_ARM])
    nodes = np.array(chosen)
    steps = library.node_step[nodes]
    assert (steps == steps[:, :1]).all()  # a chorus line: one walk for all (T121)
    assert len(np.unique(steps)) == 5
    sides = library.node_side[nodes[:, 0]]
    assert (sides[1:] == -sides[:-1]).all()
    left = np.mean(across, axis=0)  # a dancer that faces the audience has the left side at +x (T122)
    assert np.abs(np.degrees(np.arctan2(left[:, 2], left[:, 0]))).max() < 5.0


def test_tap_has_one_step_in_nine_directions_with_either_foot():
    """T126, T131: the step reaches all directions (Fig. 5.7)."""
    library = load_show(find_patch("tap")).graph.library
    assert {(clip.leading_foot, clip.direction) for clip in library.clips if clip.step == "time step"} == {
        (foot, direction) for foot in ("left", "right") for direction in DIRECTIONS
    }


def _pairs(library):
    """All pairs of variations that a human can dance in sequence (T134-T136), as nodes."""
    begins = {int(clip): node for node, clip in enumerate(library.node_clip) if library.node_measure[node] == 0}
    for first, clip in enumerate(library.clips):
        for second, after in enumerate(library.clips):
            same_foot = clip.weight_transfer and clip.step == after.step and clip.leading_foot == after.leading_foot
            if clip.end_pose == after.begin_pose and not same_foot:
                yield begins[first] + clip.measures - 1, begins[second]


@pytest.mark.long
def test_ballet_graph_connects_all_danceable_pairs():
    """T137: each pair of variations with matching poses is an edge; each step can follow each other step."""
    graph = load_show(find_patch("ballet")).graph
    library = graph.library
    pairs = list(_pairs(library))
    missing = [
        f"{library.describe(u)} -> {library.describe(v)}"
        for u, v in pairs
        if v not in graph.edge_target[graph.edge_start[u] : graph.edge_start[u + 1]]
    ]
    assert not missing, missing[:10]
    followed = {(library.node_step[u], library.node_step[v]) for u, v in pairs}
    assert len(followed) == 16
    assert {name: int(library.node_measures[library.node_step == i].max()) for i, name in enumerate(library.steps)} == {
        "couru": 1, "spring point": 1, "echappe": 2, "sissonne": 4,
    }  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize(
    ("seed", "measures"), [(1, 40), *(pytest.param(seed, 100, marks=pytest.mark.soak) for seed in (1, 2, 3))]
)
def test_random_ballet_steps_are_danced_without_detours(seed, measures):
    """Random steps: the step that was drawn is always danced."""
    path = find_patch("ballet")
    patch = read_patch(path)
    steps = ("couru", "echappe", "spring point", "sissonne")
    group = patch.group[0].model_copy(update={"steps": steps, "choose": "random"})
    show = load_from_patch(patch.model_copy(update={"group": (group,)}), path).start(seed=seed)
    tick = 0
    while show.span.number < measures:
        tick += 1
        show.tick(tick / 64)
    assert show.scheduler.detours == show.scheduler.dead_ends == 0


@pytest.mark.long
def test_ballet_has_structure_of_thesis():
    clips = load_show(find_patch("ballet")).graph.library.clips
    ways = {(clip.leading_foot, clip.direction.split()[-1]) for clip in clips if clip.step == "couru"}
    assert ("right", "left") in ways
    assert ("left", "right") in ways
    assert ("right", "right") not in ways
    assert ("left", "left") not in ways
    assert {clip.step for clip in clips if clip.weight_transfer} == {"echappe", "spring point"}  # T135
    poses = {clip.step: {(c.begin_pose[:4], c.end_pose[:4]) for c in clips if c.step == clip.step} for clip in clips}
    assert poses["echappe"] == {("sous", "plié"), ("plié", "plié")}  # T136: it must end in plié
    assert all(len(poses[step]) == 4 for step in ("couru", "spring point", "sissonne"))
    assert {clip.step for clip in clips if clip.direction != "in place"} == {"couru", "spring point"}  # T133


@pytest.mark.long
def test_couru_moves_in_its_named_direction():
    for clip in load_show(find_patch("ballet")).graph.library.clips:
        if clip.step == "couru" and clip.direction.startswith("long"):
            begin, end = round(clip.first), round(clip.first + clip.samples_per_measure)
            way = clip.clip.root_position[end, [0, 2]] - clip.clip.root_position[begin, [0, 2]]
            sign = {"left": (1, 0), "right": (-1, 0), "forward": (0, 1), "back": (0, -1)}[clip.direction.split()[1]]
            assert np.dot(way, sign) > 0.5
