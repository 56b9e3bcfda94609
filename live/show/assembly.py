"""Assembly of a show: its parts are built from patch and graph, and given to each other and to the show."""

from collections.abc import Mapping

import numpy as np

from live.graph.motion_graph import MotionGraph
from live.graph.select.selector import StepSelector
from live.motion.cloth.spring_rig import SpringRig
from live.motion.step_clip import StepClip
from live.motion.texture.live_bank import TextureBank
from live.show.audience.audience import Audience
from live.show.audience.voting import VoteNames
from live.show.audience.words import Words
from live.show.capture.capture_manager import CaptureManager
from live.show.capture.gestures import Gestures
from live.show.capture.seen_steps import SeenSteps
from live.show.circuit_breakers import CircuitBreakers
from live.show.dancers.character_casting import bodies_of
from live.show.dancers.character_springs import CharacterSprings, SpringCast
from live.show.dancers.dancers import Dancers
from live.show.dancers.expression import Expression
from live.show.dancers.garments import Garments
from live.show.dancers.live_texture import LiveTexture
from live.show.dancers.step_requests import StepRequests
from live.show.dancers.variation import Variation
from live.show.desk.launcher import Launcher
from live.show.desk.light_desk import LightDesk
from live.show.desk.pad import Pads
from live.show.desk.refusals import Refusals
from live.show.desk.undo_history import EditablePart
from live.show.frame import Frame
from live.show.group.casting import Casting
from live.show.group.group_commands import GroupCommands
from live.show.group.group_motion import GroupMotion
from live.show.partner.example_bank import ExampleBank
from live.show.partner.partner_pairs import check_partners
from live.show.partner.partner_response import PartnerResponse
from live.show.patch.patch import Patch
from live.show.score.group_programs import build_programs
from live.show.score.music_reactions import Reactions
from live.show.score.score_requests import ScoreRequests
from live.show.score.score_runner import ScoreRunner
from live.show.selection.initial_nodes import initial_nodes
from live.show.selection.interrupts import Interrupts
from live.show.selection.scheduler import Scheduler
from live.show.show import Show
from live.show.sound.clock_commands import make_follower
from live.show.stages.calls import Calls
from live.show.stages.crowd_stage import CrowdStage, GroupStage
from live.show.stages.dancers_stage import DancersStage
from live.show.stages.event_router import EventRouter
from live.show.stages.garments_stage import GarmentsStage
from live.show.stages.hot_swap import HotSwap
from live.show.stages.light_stage import LightStage
from live.show.stages.measure_lines import MeasureBegin, MeasureLines
from live.show.stages.plan_stage import PlanStage
from live.show.stages.show_clock import ShowClock
from live.show.stages.springs_stage import SpringsStage
from live.show.stages.step_selection import StepSelection
from live.show.stages.tripped_stages import TrippedStages
from live.show.view.appearance import Appearances
from live.show.view.view_builder import ViewBuilder


def assemble(
    patch: Patch,
    graph: MotionGraph,
    *,
    seed: int | None = None,
    tempo: float | None = None,
    reserve: Mapping[str, StepClip] | None = None,
    selector: StepSelector | None = None,
    bank: TextureBank | None = None,
    answers: ExampleBank | None = None,
    later_answers: Mapping[str, ExampleBank] | None = None,
    springs: Mapping[str, SpringRig] | None = None,
    begin: bool = True,
) -> Show:
    """Return a show at the start of its first measure.

    `seed` and `tempo` [bpm] override the patch's; `reserve`: clips that events may add, by name; `selector`: the
    selector prepared for the graph, if there is one; `bank`: motion for texturing upper bodies; `answers`: examples for
    partner responses, and `later_answers` those that events may have taken over, by digest; `springs`: those of
    characters, by name. Without `begin` no measure begins, because a state will be restored.

    Raises UnknownStep for a step the library lacks, PersonError for what else is impossible.
    """
    seed = patch.seed if seed is None else seed
    breakers, refusals = CircuitBreakers(), Refusals()
    clock = ShowClock(
        make_follower(patch, tempo),
        breakers,
        measure_beats=patch.clock.beats_per_measure,
        follow_metre=patch.clock.follow_metre,
        known_tempo=patch.music.known_tempo if tempo is None else None,
    )
    casting = Casting(patch)
    casting.check()
    reactions = Reactions(patch)
    score_runner = ScoreRunner(patch, reactions, seed=seed)
    motion = GroupMotion(patch, casting, seed=seed, score=score_runner.score)
    variation = Variation.of(patch, casting.group, seed=seed, window=graph.window)
    dancers = _dancers(patch, graph, casting, variation, bank=bank, answers=answers, seed=seed)
    programmes, subgroups = build_programs(patch, graph, seed, casting.group, score_runner.score, score_runner.mood)
    scheduler = Scheduler(patch, dancers, motion, programmes, subgroups, casting.group, selector)
    interrupts = Interrupts(patch, dancers, motion, scheduler)
    commands = GroupCommands(patch, motion, dancers, variation, score_runner.score)
    measure_s = clock.timeline.beats_per_measure * 60.0 / clock.timeline.tempo
    node = initial_nodes(graph, scheduler, variation.sides, motion.partners.mirrored, clock.span.number, measure_s)
    dancers.start(node, motion.state.position.astype(np.float64), motion.starting_heading)
    scheduler.targets.headings.reset(motion.starting_heading)
    expression = Expression(dancers, motion, seed=seed)
    mocap = CaptureManager(patch, motion, dancers, scheduler)
    seen_steps = SeenSteps(patch, motion, dancers, refusals, seed=seed)
    gestures = Gestures(patch, mocap, reactions, score_runner, motion, dancers)
    launcher = Launcher(
        patch, Pads(patch, dancers, motion.evolutions), refusals, seed=seed, casting=casting,
        playhead=score_runner.playhead, dancers=dancers, scheduler=scheduler,
    )  # fmt: skip
    editable: dict[str, EditablePart] = {
        "formations": motion.evolutions, "sequences": scheduler, "facings": scheduler.targets.headings,
        "ripples": variation, "set": commands, "mocap": mocap, "launches": launcher,
    }  # fmt: skip
    desk = LightDesk(patch, score_runner, motion, variation, editable, dancers, seed=seed)
    audience = Audience(patch.audience, motion.elements, VoteNames(patch, dancers, desk.scenes),
        Words(patch, seed=seed), seed=seed)  # fmt: skip
    directions = StepRequests(motion, dancers, variation, scheduler, interrupts)
    light = LightStage(breakers)
    spring_cast = SpringCast.of(springs or {}, bodies_of(patch) if springs else (), len(casting.group))
    character_springs = CharacterSprings(spring_cast, dancers, motion, desk)
    appearances = Appearances(seed, variation.division, desk.parameters)
    garments = Garments(patch, variation.division, desk.parameters, appearances, seed=seed)
    view_builder = ViewBuilder(
        dancers, motion, variation.division, desk, audience, light, clock.follower, appearances, expression, garments,
        character_springs,
    )  # fmt: skip
    hot_swap = HotSwap(
        patch, graph, dancers, scheduler, motion, seen_steps, refusals, assemble=assemble, seed=seed,
        answers=answers or ExampleBank(()), reserve=reserve, later_answers=later_answers,
    )  # fmt: skip
    hot_swap.parts = (
        casting, reactions, score_runner, motion, variation, dancers, scheduler, interrupts, commands, mocap, desk,
        audience, directions, view_builder, launcher, garments, seen_steps, gestures,
    )  # fmt: skip
    tripped = TrippedStages(breakers, refusals, scheduler, motion.evolutions, hot_swap)
    score = ScoreRequests(score_runner, reactions, motion, scheduler)
    router = EventRouter(
        (
            clock, motion.elements, commands, desk, view_builder, mocap, seen_steps, directions, score, audience, light,
            hot_swap, tripped, launcher, expression, garments, gestures,
        ),
        clock, motion, desk.undo_history, refusals,
    )  # fmt: skip
    calls = Calls(breakers, router, score_runner.beat_scheduler, desk, launcher)
    selection = StepSelection(breakers, scheduler, dancers, motion.stage_area)
    measure_begin = MeasureBegin(
        breakers, clock, refusals, score_runner=score_runner, dancers=dancers, commands=commands, variation=variation,
        scheduler=scheduler, motion=motion,
    )  # fmt: skip
    frame = Frame(
        breakers=breakers,
        router=router,
        clock=clock,
        measure_lines=MeasureLines(
            breakers, clock, calls, measure_begin, tripped, selection=selection, scheduler=scheduler, dancers=dancers,
            motion=motion, hot_swap=hot_swap, reactions=reactions, desk=desk, audience=audience,
        ),
        plan=PlanStage(
            breakers, calls, desk=desk, audience=audience, hot_swap=hot_swap, selection=selection,
            interrupts=interrupts, seen_steps=seen_steps, gestures=gestures,
        ),
        group=GroupStage(breakers, motion, scheduler),
        crowd=CrowdStage(breakers, motion, scheduler, dancers),
        dancers=DancersStage(
            breakers, dancers=dancers, scheduler=scheduler, mocap=mocap, motion=motion, reactions=reactions,
            score_runner=score_runner, expression=expression,
        ),
        springs=SpringsStage(breakers, character_springs),
        garments=GarmentsStage(breakers, garments, dancers, motion),
        light=light,
        view_builder=view_builder,
        motion=motion,
        tripped=tripped,
    )  # fmt: skip
    if begin:
        measure_begin.begin(clock.span.end - clock.timeline.beats_per_measure)
    return Show(
        seed=seed, breakers=breakers, refusals=refusals, clock=clock, casting=casting, reactions=reactions,
        score_runner=score_runner, motion=motion, variation=variation, dancers=dancers, garments=garments,
        scheduler=scheduler, interrupts=interrupts, directions=directions, mocap=mocap, desk=desk, audience=audience,
        light=light, hot_swap=hot_swap, view_builder=view_builder, expression=expression, launcher=launcher,
        springs=character_springs, seen_steps=seen_steps, gestures=gestures, frame=frame,
    )  # fmt: skip


def _dancers(
    patch: Patch,
    graph: MotionGraph,
    casting: Casting,
    variation: Variation,
    *,
    bank: TextureBank | None,
    answers: ExampleBank | None,
    seed: int,
) -> Dancers:
    """Return the dancers, with texture and partners if there are examples for them."""
    count = len(casting.group)
    dancers = Dancers(graph, variation, count)
    if bank is not None:
        beats = patch.clock.beats_per_measure
        dancers.texture = LiveTexture(bank, variation, count, seed=seed, beats=beats)
    check_partners(patch, casting)
    if answers is not None:
        dancers.partner_response = PartnerResponse(patch, casting, variation, answers)
    return dancers
