"""Kinds of a show other than its dancers: score, groups, cues, desk, audience, edits."""

from typing import Final

from live.base.stage_snapshot import Title
from live.motion.pose.arm_clearance import ArmEasing
from live.show.audience.audience import Audience
from live.show.audience.audience import TouchCluster as AudiencePlace
from live.show.audience.voting import Turn, Vote, VoteNames
from live.show.audience.words import ShownWord, Words
from live.show.circuit_breakers import CircuitBreakers, Stage
from live.show.dancers.garments import Garments
from live.show.dancers.step_requests import StepRequests
from live.show.desk.camera_directions import Stand, ViewComparison
from live.show.desk.camera_director import CameraDirector
from live.show.desk.camera_framing import Frame as CameraFrame
from live.show.desk.camera_framing import Framing
from live.show.desk.camera_rig import CameraRig, DampedFollower, Spots
from live.show.desk.camera_subjects import Subjects
from live.show.desk.cue_list import CueList, _TriggeredCue
from live.show.desk.launcher import Launched, Launcher
from live.show.desk.light_desk import LightDesk, Master
from live.show.desk.pad import Pad, Pads
from live.show.desk.parameters import Parameters
from live.show.desk.refusals import Refusals
from live.show.desk.scenes import Scene, Scenes
from live.show.desk.score_light import ScoreLight
from live.show.desk.titles import ShownTitle, Titles
from live.show.desk.undo_history import UndoHistory, _Edit
from live.show.frame import Frame
from live.show.group.formations import Formations, NamedFormation
from live.show.group.group_commands import GroupCommands
from live.show.group.stage_area import StageArea
from live.show.partner.example_updates import ExampleUpdates
from live.show.partner.partner_pairs import Pair
from live.show.partner.partner_pairs import PartnerSettings as AnswerPairsAsked
from live.show.patch.patch_update import PatchUpdates
from live.show.patch.section_motion import Facing
from live.show.score.beat_scheduler import BeatScheduler
from live.show.score.canon import Canon
from live.show.score.improviser import ImprovisedMotion, Improviser
from live.show.score.music_reactions import Mood, MusicSignals, Reactions
from live.show.score.part import ScorePart
from live.show.score.playhead import Place as PlacesPlace
from live.show.score.playhead import Playhead, PlayheadState, SectionTiming
from live.show.score.playhead import PlayheadRequest as PlacesAsked
from live.show.score.score import Score
from live.show.score.score_requests import ScoreRequests
from live.show.score.score_runner import ScoreRunner
from live.show.score.step_history import StepHistory
from live.show.score.step_program import StepProgram, _Call, _Position, _UndoState
from live.show.score.subgroups import Subgroup, Subgroups
from live.show.selection.drawn_paths import DrawnPath
from live.show.selection.graph_update import GraphUpdates
from live.show.show import Show
from live.show.stages.calls import Calls
from live.show.stages.crowd_stage import CrowdStage, GroupStage
from live.show.stages.dancers_stage import DancersStage
from live.show.stages.event_router import EventRouter
from live.show.stages.garments_stage import GarmentsStage
from live.show.stages.hot_swap import HotSwap
from live.show.stages.light_stage import LightStage
from live.show.stages.measure_lines import MeasureBegin, MeasureLines
from live.show.stages.measure_span import MeasureSpan
from live.show.stages.plan_stage import PlanStage
from live.show.stages.show_clock import ShowClock
from live.show.stages.springs_stage import SpringsStage
from live.show.stages.step_selection import StepSelection
from live.show.stages.tripped_stages import TrippedStages
from live.show.state import consistency as whole
from live.show.state.kind import Kind, no_value
from live.show.view.appearance import Appearances
from live.show.view.view_builder import ViewBuilder


def _no_stage() -> int:
    """Return the number of no stage, because none runs between ticks."""
    return int(Stage.OUTSIDE)


KINDS: Final = [
    Kind("agenda", BeatScheduler, """
        _heap:list[tuple[float,int,float,event]] _order:int _last_beat:float _tick_beats:float fired:int
        late_ticks_max:int late:int dropped:int
    """),
    Kind("answer-pairs.asked", AnswerPairsAsked, """
        name:str leader:str follower:str on:bool amount:float window:float place:str|none hands:float
        style:str
    """),
    Kind("answer-pairs.pair", Pair, "partner:int leader:int follower:int own_place:bool"),
    Kind("audience", Audience, """
        words:words _elements:elements _names:vote-names
        _seed:int regions:row[str] _vote_measures:int open:bool gain:float muted:bool shaking:bool weights:list[float]
        turn:turn|none vote:vote|none result:tuple[int,str] _result_measure:int _winner_measures:int tally:bool
        invitation:int banned:dict[int,none] command_count:int phones:int
        _votes:int _share:float _places:row[audience.place] _shaken:bool _number:i8 _light_on:b1 _goal:f4 _light:f4
    """),
    Kind("audience.place", AudiencePlace, "x:float z:float weight:float repels:bool"),
    Kind("camera-rig", CameraRig, "_parameters:parameters _beats:int start_selection:str follower:chase"),
    Kind("camera-director", CameraDirector, """
        _parameters:parameters _subjects:camera-subjects _score_runner:prompter _framing:camera-framing _seed:int
        _beats:int locked:bool running:bool _age:int _kind:int _chosen:b1 _frame:camera-frame
        _comparison:view-comparison|none _pose:f8 _speed:f8 _aim:f8 _from:f8 _moved:float _length:float _lens:f8 _eye:f8
        _eye_goal:f8 _target:f8 _way:f8 _has_cut:bool _drift:float _push:float _shot_s:float _due:int cuts:int
    """),
    Kind("camera-frame", CameraFrame, """
        target:f8 distance:float bearing:float elevation:float field_of_view:float
    """),
    Kind("camera-framing", Framing, "_aspect:float _half:f8"),
    Kind("camera-subjects", Subjects, "_motion:group-motion _dancers:dancers _spots:spots"),
    Kind("score-light", ScoreLight, """
        _parameters:parameters _subjects:camera-subjects _score_runner:prompter _division:division suspended:bool
        _house:float _energy:float _build:float _drop:float _drop_goal:float _drops:int _group:f8 _group_goal:f8
        _activity:f8 _sides:f8 _side_group:i8 _dancer:i8 _wanted:i8 _wanted_level:f8 _spot:f8 _place:f8 _speed:f8
        _planned:bool
    """),
    Kind("view-comparison", ViewComparison, "_framing:camera-framing stand:camera-stand score:f8* done:int"),
    Kind("camera-stand", Stand, "place:f8* heading:f8* there:b1* chosen:b1*"),
    Kind("chase", DampedFollower, """
        _motion:group-motion selection:str _selected:b1|none _centre:f8 _speed:f8 running:bool
    """),
    Kind("show", Show, """
        seed:int breakers:breakers refusals:refusals clock:show-clock casting:casting reactions:reactions
        score_runner:prompter motion:group-motion variation:variation dancers:dancers garments:garments
        scheduler:scheduler interrupts:interrupts directions:directions mocap:mocap desk:desk audience:audience
        light:light hot_swap:hot-swap view_builder:seen expression:expression launcher:launcher
        springs:character-springs seen_steps:seen-steps gestures:gestures frame:frame
    """),
    Kind("frame", Frame, """
        breakers:breakers router:event-router clock:show-clock measure_lines:measure-lines plan:plan-stage
        group:group-stage crowd:crowd-stage dancers:dancers-stage springs:springs-stage garments:garments-stage
        light:light view_builder:seen motion:group-motion tripped:tripped-stages
    """),
    Kind("springs-stage", SpringsStage, "_breakers:breakers _springs:character-springs"),
    Kind("event-router", EventRouter, """
        _parts:row[audience|desk|directions|elements|garments|gestures|group-controls|hot-swap|launcher|light|mocap|score-requests|seen|seen-steps|expression|show-clock|tripped-stages]
        _clock:show-clock _motion:group-motion _undo_history:edits _refusals:refusals
    """, factories={"_handlers": dict, "observers": list}, after_read=EventRouter.build_table),
    Kind("show-clock", ShowClock, """
        follower:timeline-follower timeline:timeline span:measure-span time:float measure_beats:int beat:float
        _beats_per_tick:float _breakers:breakers _follow_metre:bool _known_tempo:float|none
    """),
    Kind("hot-swap", HotSwap, """
        patch:constant-patch graph:constant-motion-graph answers:constant-answer-bank
        parts:row[audience|casting|dancers|desk|directions|garments|gestures|group-controls|group-motion|interrupts|launcher|mocap|prompter|reactions|scheduler|seen|seen-steps|variation]
        graph_updates:new-steps patch_updates:reloading _dancers:dancers _scheduler:scheduler _motion:group-motion
        _seen_steps:seen-steps example_updates:new-examples _refusals:refusals _seed:int
    """, factories={"_assemble": no_value}),
    Kind("garments", Garments, """
        _division:division _parameters:parameters _appearances:appearances _seed:int _bodies:row[str]
        simulated:dict[str,garment-batch] substeps:int _measure:int _joint_position:f4 _joint_rotation:f4 _hips:f4
        _seen:b1 _chosen:b1
    """, factories={"_skinned": dict, "_known": no_value}, after_read=Garments.rebuild,
         is_consistent=Garments.is_consistent),
    Kind("garments-stage", GarmentsStage, """
        _breakers:breakers _garments:garments _dancers:dancers _motion:group-motion
    """),
    Kind("light", LightStage, "blackout:bool brightness:float _breakers:breakers"),
    Kind("calls", Calls, """
        _breakers:breakers _router:event-router _beat_scheduler:agenda _desk:desk _launcher:launcher
    """),
    Kind("tripped-stages", TrippedStages, """
        _breakers:breakers _refusals:refusals _scheduler:scheduler _evolutions:evolutions _hot_swap:hot-swap
    """),
    Kind("measure-begin", MeasureBegin, """
        _breakers:breakers _clock:show-clock _refusals:refusals _score_runner:prompter _dancers:dancers
        _commands:group-controls _variation:variation _scheduler:scheduler _motion:group-motion
    """),
    Kind("measure-lines", MeasureLines, """
        _breakers:breakers _clock:show-clock _calls:calls _tripped:tripped-stages _measure_begin:measure-begin
        _selection:step-selection _scheduler:scheduler _dancers:dancers _motion:group-motion _hot_swap:hot-swap
        _reactions:reactions _desk:desk _audience:audience
    """),
    Kind("plan-stage", PlanStage, """
        _breakers:breakers _calls:calls _desk:desk _audience:audience _hot_swap:hot-swap _selection:step-selection
        _interrupts:interrupts _seen_steps:seen-steps _gestures:gestures
    """),
    Kind("step-selection", StepSelection, """
        _breakers:breakers _scheduler:scheduler _dancers:dancers _stage_area:floor
    """),
    Kind("group-stage", GroupStage, "_breakers:breakers _motion:group-motion _scheduler:scheduler"),
    Kind("crowd-stage", CrowdStage, """
        _breakers:breakers _motion:group-motion _dancers:dancers _correction:carrying
    """),
    Kind("dancers-stage", DancersStage, """
        _breakers:breakers _dancers:dancers _mocap:mocap _motion:group-motion _correction:carrying
        _reactions:reactions _score_runner:prompter _expression:expression
    """),
    Kind("score-requests", ScoreRequests, """
        _score_runner:prompter _reactions:reactions _motion:group-motion _scheduler:scheduler
    """),
    Kind("vote-names", VoteNames, "_patch:constant-patch _dancers:dancers _scenes:scenes"),
    Kind("breakers", CircuitBreakers, """
        reasons:dict[str,str] _level:dict[int,int]
    """, factories={"running": _no_stage, "_page": no_value}),
    Kind("cues", CueList, """
        _cues:row[constant-cue-section] _playhead:playhead _beats:int standby:int last:int fired:int bounced:int
        _triggered:list[cues.given] late_ticks_max:int _last_beat:float _tick_beats:float _last_go:dict[str,float]
        _score_state:row[any]
    """),
    Kind("cues.given", _TriggeredCue, "index:int due:float earliest:float revert_event:event|none"),
    Kind("desk", LightDesk, """
        parameters:parameters camera_rig:camera-rig spots:spots director:camera-director score_light:score-light
        energy:float background_age:f8 _gobo_turns:float scenes:scenes _score_runner:prompter cues:cues
        undo_history:edits beats:int master:master held:bool titles:titles
    """),
    Kind("directions", StepRequests, """
        _motion:group-motion _casting:casting _dancers:dancers _variation:variation _scheduler:scheduler
        _interrupts:interrupts explained_dancer:int|none
    """),
    Kind("drawn-way", DrawnPath, """
        rows:list[int] _points:list[tuple[float,float]] _gone:int _next:dict[int,int] _offsets:dict[int,f8*]
        _waited:float
    """),
    Kind("echo", Canon, """
        _leader:group-programme _own:group-programme _delay:int _detached:bool
        _leader_steps:ordered[int,tuple[int,row[wanted],int]] travel_step:int|none steps:list[int] upcoming:row[wanted]
        measures_done:int
    """),
    Kind("edits", UndoHistory, """
        _parts:dict[str,cues|evolutions|group-controls|headings|launcher|mocap|parameters|scenes|scheduler|variation]
        _done:deque[edits.edit] _undone:list[edits.edit] _values_before:dict[any,any]|f8|none
    """),
    Kind("launcher", Launcher, """
        pads:pads waiting:dict[str,launched] running:dict[str,launched] refused:dict[str,tuple[str,str,str]]
        _patch:constant-patch _refusals:refusals _seed:int _casting:casting _playhead:playhead _dancers:dancers
        _scheduler:scheduler _count:int _course:row[any]
    """),
    Kind("launched", Launched, """
        pad:pad group:str when:str due:float measures:float follow:str number:int called:bool ends:float ended:bool
    """),
    Kind("pad", Pad, "kind:str name:str words:str own:str measures:float follow:str"),
    Kind("pads", Pads, "_patch:constant-patch _dancers:dancers _evolutions:evolutions"),
    Kind("edits.edit", _Edit, "label:str part:str before:dict[any,any] after:dict[any,any] key:row[str] time:float"),
    Kind("floor", StageArea, "_patch:f8 half:f8 border:f8 _from:f8 _began:float _ends:float _beat:float"),
    Kind("formations", Formations, """
        _seed:int _named:dict[str,named-formation] _from_patch:dict[str,named-formation]
        _unnamed:ordered[str,named-formation] _half:f8|none
    """),
    Kind("named-formation", NamedFormation, """
        name:str spec:formation-spec seed:int _cache:ordered[int,places] half:f8|none
    """),
    Kind("group-controls", GroupCommands, """
        _patch:constant-patch _motion:group-motion _dancers:dancers _variation:variation _score:score
        _joining:dict[int,int]
    """),
    Kind("improvised-motion", ImprovisedMotion, """
        _score:score _seed:int _tables:list[tuple[int,int,int,int|none,constant-improvise-section]]
    """),
    Kind("improviser", Improviser, """
        _tables:list[constant-table] _default_table:constant-table _score:score _history:ledger _mood:mood _group:int
        _seed:int _graph:constant-motion-graph draw_state:tuple[int,int,int] forced:bool
    """),
    Kind("ledger", StepHistory, "capacity:int _steps:dict[int,ordered[int,tuple[int,int]]]"),
    Kind("master", Master, """
        level:float frozen:bool flashes:bool goal:float cards:dict[str,str] _from:float _length:float _elapsed:float
    """),
    Kind("measure-span", MeasureSpan, "number:int end:float _beats:float _anchor_beat:float _anchor_fraction:float"),
    Kind("mood", Mood, "_values:dict[str,float] _has_music:bool notes:event-NotesHeard|none"),
    Kind("new-examples", ExampleUpdates, """
        _refusals:refusals
    """, factories={"_offered": dict, "_reserve": dict, "_next": no_value}),
    Kind("new-steps", GraphUpdates, """
        _refusals:refusals
    """, factories={"_offered": dict, "_reserve": dict, "_next": no_value, "_at_once": bool}),
    Kind("occasions", MusicSignals, "_signals:list[constant-signal-section] _active:list[bool]"),
    Kind("parameters", Parameters, """
        table:constant-parameter-table _variation:variation _motion:group-motion _division:division value:f8 start:f8
        _from:f8 _goal:f8 _start_beat:f8 _length:f8 _fading:b1 _running:int _ticks:int _measure_beats:int
        beat:float held:bool touched:bool claimed:b1
    """),
    Kind("part", ScorePart, "_score:score _sequences:constant-sequences _improviser:improviser"),
    Kind("places.asked", PlacesAsked, "section:int|none measure:int at_section:bool leave:bool"),
    Kind("places.place", PlacesPlace, "section:int measure:int turn:int"),
    Kind("stand", PlayheadState, "place:places.place passes:int begin_counts:row[int] entered:bool jumped:bool"),
    Kind("stretch", SectionTiming, "name:str measures:int|none repeat:int next_section:int"),
    Kind("playhead", Playhead, """
        sections:row[stretch] measure:int held:bool practice:tuple[int,int]|none _request:places.asked
        _states:dict[int,stand] _section_starts:list[int]
    """),
    Kind("group-programme", StepProgram, """
        _graph:constant-motion-graph _seed:tuple[int,int] _random:bool steps:list[int] travel_step:int|none
        _own:list[wanted] _live:list[wanted] _answer:tuple[int,int]|none _position:programme.place
        _undo_state:programme.before|none upcoming:row[wanted] measures_done:int part:part|none standing:bool
        measure_s:float
    """),
    Kind("programme.before", _UndoState, """
        answer:tuple[int,int]|none position:programme.place draw_state:tuple[int,int,int]|none
    """),
    Kind("programme.call", _Call, "step:int remaining:int done:int"),
    Kind("programme.place", _Position, """
        drawn_step:int drawn_left:int slot:int measures_done:int call:programme.call|none
    """),
    Kind("prompter", ScoreRunner, """
        playhead:playhead score:score beat_scheduler:agenda mood:mood signals:counter[str] last_signal:str
        _sent_ahead:list[constant-at-section] _reactions:reactions _music_signals:occasions _motion:improvised-motion
        _known_signals:set[str] late_jumps:int late_message:str late_message_measure:int _beats:int _names:dict[str,int]
    """),
    Kind("reactions", Reactions, """
        _value_sections:list[constant-react-section] _call_sections:list[constant-react-section]
        _values:list[float|none] _line_calls:list[constant-react-section] pending_calls:list[constant-react-section]
        suppressed:bool _building:bool _last:event-MusicHeard|none strength:float drops:int
    """),
    Kind("refusals", Refusals, "count:int last_reason:str"),
    Kind("reloading", PatchUpdates, """
        _refusals:refusals _tried_measure:int|none version:str applied_count:int last_changed:row[str]
    """, factories={"_prepared": dict, "replaced": list, "waiting": no_value}),
    Kind("scene", Scene, """
        name:str goals:dict[int,float] measures:float follow:str|none selected:row[tuple[str,str,row[float]]]
    """),
    Kind("scenes", Scenes, """
        _parameters:parameters _rig:camera-rig _custom_passes:dict[str,constant-own-number] stored:dict[str,scene]
        _views:dict[str,scene] _looks:dict[str,scene] _worlds:dict[str,scene] _backgrounds:list[str]
        _background_places:list[str] _scenes:dict[str,scene]
    """),
    Kind("score", Score, "playhead:playhead _sections:dict[str,int] written:constant-written"),
    Kind("facing", Facing, "kind:str degrees:float dancer:int name:str"),
    Kind("appearances", Appearances, "_seed:int _division:division _parameters:parameters",
         factories={"_drawn": no_value}),
    Kind("seen", ViewBuilder, """
        _dancers:dancers _motion:group-motion _division:division _desk:desk _audience:audience _light:light
        _follower:timeline-follower _frozen_view:stage-view|none _appearances:appearances _expression:expression
        _garments:garments _springs:character-springs
    """, factories={"_easing": ArmEasing}),
    Kind("spots", Spots, "_parameters:parameters _followers:row[chase] _levels:list[int]"),
    Kind("subgroup", Subgroup, """
        words:str group:int program:group-programme chosen:b1 entry:tuple[int,int,int,int]|none
    """),
    Kind("subgroups", Subgroups, """
        _group:i4(group) _programs:list[echo|group-programme] _idle:list[group-programme] written:list[list[subgroup]]
        requested:list[subgroup] active:list[subgroup] of_dancer:i4(subgroup) _count:int _assigned:int|none
        _before:list[tuple[b1,tuple[int,int,int,int]|none]]
    """, is_consistent=whole.subgroups),
    Kind("title", Title, """
        text:str place:str at:tuple[float,float,float] size:float tracking:float colour:tuple[float,float,float]
        entrance:str font:str progress:float level:float
    """),
    Kind("titles", Titles, "_patch:constant-patch shown:list[titles.shown]"),
    Kind("titles.shown", ShownTitle, "key:str title:title begin:float entrance:float end:float"),
    Kind("turn", Turn, "region:int begins:int ends:int"),
    Kind("vote", Vote, "number:int kind:str choices:row[str] closes:int counts:row[int]"),
    Kind("words", Words, """
        _patch:constant-patch _seed:int waiting:list[str] shown:list[words.shown] _count:int refused:int
    """),
    Kind("words.shown", ShownWord, "title:title began:float start:tuple[float,float,float] end:float"),
]  # fmt: skip
