"""Kinds of a show's dancers: plans, steps, paths, partner responses."""

from typing import Final

from live.clock.energy.energy_frames import AdaptiveRange
from live.motion.pose.mood_pose import MoodPose
from live.motion.recognition.body_stream import BodyStream
from live.motion.recognition.built_in_gestures import BuiltInGestures
from live.motion.recognition.example_follower import ExampleFollower
from live.motion.recognition.gesture_examples import ExampleBank, ExampleMatcher
from live.motion.recognition.movement import Movement
from live.show.background_work import TaskQueue
from live.show.capture.capture_manager import CaptureManager
from live.show.capture.danced_poses import DancedPoses, Take
from live.show.capture.gesture_learning import LearnedGesture, Lesson
from live.show.capture.gestures import Gestures, PerformerMovement
from live.show.capture.performer import CapturedPerformer
from live.show.capture.performer_forces import PerformerForces
from live.show.capture.pose_buffer import DriftCorrection, PoseBuffer
from live.show.capture.seen_steps import SeenSteps, _Answer, _Reading
from live.show.capture.stage_presence import CanonBounds, Performers
from live.show.dancers.character_springs import CharacterSprings
from live.show.dancers.collision_avoidance import CollisionAvoidance, ContactResolver
from live.show.dancers.correction_update import CorrectionUpdate, NextCorrection
from live.show.dancers.dancers import Dancers
from live.show.dancers.expression import Expression
from live.show.dancers.live_texture import LiveTexture
from live.show.dancers.measure_state import MeasureState, _CachedEnds
from live.show.dancers.partners import PairSteering, Partners
from live.show.dancers.root_correction import RootCorrection
from live.show.dancers.root_correction_control import RootCorrectionControl
from live.show.dancers.timing_offsets import Drift, Ripple
from live.show.dancers.variation import Variation
from live.show.group.casting import Casting
from live.show.group.division import Division
from live.show.group.elements import Elements, GroupMasks
from live.show.group.evolutions import Evolutions
from live.show.group.group_motion import GroupMotion
from live.show.group.group_values import GroupValues
from live.show.partner.leader_input import LeaderReaders
from live.show.partner.partner_agents import PartnerAgents
from live.show.partner.partner_response import PartnerResponse
from live.show.partner.response_path import ResponsePath
from live.show.partner.response_pose import ResponsePoses
from live.show.selection.choices import StepChoices
from live.show.selection.clip_cut import ClipCutter, Moment
from live.show.selection.interrupts import Interrupts, _Cue
from live.show.selection.lookahead import AgentLookAhead
from live.show.selection.measure_draft import MeasureDraft
from live.show.selection.planning import MeasurePlan
from live.show.selection.scheduler import Scheduler
from live.show.selection.step_search import StepSearch
from live.show.selection.step_targets import Headings, StepTargets
from live.show.state import consistency as whole
from live.show.state.kind import Kind, no_value

KINDS: Final = [
    Kind("addressees", GroupMasks, "_casting:casting _words:list[str|none] _follows_groups:list[bool] bits:u8"),
    Kind("agents-ahead", AgentLookAhead, """
        _look_ahead:look-ahead _evolutions:evolutions _elements:elements _entrances:entrances _stage_area:floor
        _count:int _beats:int _late:f8
    """),
    Kind("aims", StepTargets, """
        _patch:constant-patch _dancers:dancers _motion:group-motion _programmes:list[echo|group-programme]
        _subgroups:subgroups _group:i4(group) order:list[int] headings:headings speed:f4 _row_count:int
        _wanted_steps:list[tuple[int|none,int]]
        step:i4(step) row:i4(aim) heading:f8 _choosing:constant-choosing step_costs:constant-foresight ahead:f8
        _reach:f8 _pace:f8 turn_shortfall:f8
    """),
    Kind("anchor", DriftCorrection, "offset:tuple[float,float] difference:tuple[float,float] _mean:tuple[float,float]"),
    Kind("answer-leaders", LeaderReaders, """
        _bank:constant-answer-bank readers:dict[tuple[int,int],read-leader] recent_units:list[tuple[int,str,str]]
        unit_count:int _new_labels:list[str] _styles:list[str]
    """),
    Kind("answer-poses", ResponsePoses, """
        _leaders:answer-leaders _path:taken-along foot_lock:standing _offsets:f4 _parents:i4(joint)
    """),
    Kind("answering", PartnerResponse, """
        bank:constant-answer-bank _casting:casting _variation:variation _beats:int settings:list[answer-pairs.asked]
        pairs:list[answer-pairs.pair] leaders:answer-leaders path:taken-along streamed:b1 _poses:answer-poses
        hand_holds:holding _drawn_paths:dict[int,drawn-way] _agents:f4 _danced_beats:f8
        _patch_settings:list[answer-pairs.asked] _roster:roster _leaving:list[answer-pairs.pair]
    """),
    Kind("answering-agents", PartnerAgents, "_radius:f4 _default_radius:float _partner_response:answering|none"),
    Kind("avoiding", CollisionAvoidance, """
        _half_stage:f8 _dancers:dancers _motion:group-motion _targets:method _cutting:cutting _cut:method _ways:f8
        _things:f8 _tick:int _met:f8 _waiting:list[int] count:int
    """),
    Kind("captured", CapturedPerformer, """
        bounds:edges rows:i8(dancer)* delay:f8* fade:f8* offset:f8* turn_angle:f8* poses:heard-poses
        attraction_sign:float follower:int _tracker_position:tuple[float,float] _tracker_target:tuple[float,float]
        _tracker_time:float drift_correction:anchor _suit_position:tuple[float,float] _anchored:bool
        section:constant-mocap-section shown:bool mirrored:bool obstacle:bool attract:float attracts:str dancer:str|none
        canon:str canon_beats:float turn:float scale:float origin:tuple[float,float,float]
    """, is_consistent=whole.captured),
    Kind("carried", RootCorrection, """
        dancers:dancers motion:group-motion paths:paths node:i4(node) rows:f8 begin:f8 end:f8 goal:f8 predicted:f8
        target_at_decision:f8 agent_at_decision:f8 room:f8 max_separation:f8 speed_limit:f8
    """),
    Kind("carrying", RootCorrectionControl, """
        _patch:constant-patch _dancers:dancers _motion:group-motion path_separation:path-parting _correction:carried
        _next_correction:coming _correction_update:re-aiming _contact_resolver:pushing|none reference:f4
        reference_velocity:f4 lag:f8 _skip_separation:bool _slid:f8 _stood:f8 _ended:bool _begun:bool _open:bool
    """),
    Kind("casting", Casting, """
        group:i4(group) names:row[str] half:tuple[float,float] _attributes:row[frozenset[str]] _named:dict[str,str]
        roster:roster
    """),
    Kind("character-springs", CharacterSprings, """
        cast:constant-spring-cast _dancers:dancers _motion:group-motion _desk:desk _time:float _ticks:int _chosen:b1
        _dancer:i4* _running:b1* _level:f4* _hips:f4* _now:f4* _before:f4* _turn:f4* _turn_before:f4*
    """, after_read=CharacterSprings.check_sizes),
    Kind("choices", StepChoices, """
        edge:i4(edge) candidate:i4(candidate) terms:f8 end:f8 node:i4(node) start_position:f8 heading:f8 step:i4(step)
        wish:f8 target:f8 error:f8 lag:f8 measures_behind:i4 _decided:bool
    """),
    Kind("coming", NextCorrection, """
        _correction:carried _path_separation:path-parting max_correction:float paths:paths end:f8 target:f8 wish:f8
        room:f8 _traced:int just_decided:bool _goal:f8 _plan:f8 _ease:float
    """),
    Kind("cutting", ClipCutter, "_dancers:dancers _joints:f8 _parents:i4(joint) cuts:int"),
    Kind("cutting.moment", Moment, """
        rows:i4 time:float dt:float fraction:float other_fraction:float body:tuple[f4,f4] which:i4 phase:f8 held:b1
        feature:f8 hips:f8 facing:f8
    """),
    Kind("danced", MeasureState, """
        graph:constant-motion-graph _ends:danced.ends|none decided:bool node:i4(node) placement:f8 correction:f8
        aim_origin:f8 foot_aim:f8 on_support:f8 take:i4(node) take_share:f4 amplitude:f8 warp:f8
    """),
    Kind("danced.ends", _CachedEnds, """
        _node:i4(node) _take:i4(node) _share:f4 _graph:constant-motion-graph hips:f8 heading:f8
    """),
    Kind("dancers", Dancers, """
        graph:constant-motion-graph variation:variation past:danced present:danced coming:danced
        _pipeline:pose-pipeline _everybody:i8(dancer) _phase:f8 _foot_offset:f4 lock:foot-lock hands:hands
        _locked_at:float _aside:pose-pipeline _legs:pose-pipeline inertia:inertia landing:landing texture:texturing
        captured:dict[str,captured] beats:int partner_response:answering|none _settled:f4 _bare_legs:tuple[f4,f4]
        drawn_hips:f4 push_velocity:f8 _mood:mood-pose
    """),
    Kind("danced-poses", DancedPoses, "count:int _hips:f4 _rotation:f4 _stamp:f8",
         is_consistent=lambda value: value.is_whole),
    Kind("division", Division, """
        _group:i4(group) group_count:int part:i4(part) group_of:i4(group)
    """, is_consistent=whole.division),
    Kind("drafting", MeasureDraft, """
        _dancers:dancers _choices:choices _aims:aims draft:danced _choosing:constant-choosing
    """),
    Kind("drift", Drift, """
        _count:int _seed:int phase:f8 _knots:f8 _amplitude_knots:f8 _frequency_knots:f8 _drawn:tuple[int|none,f8]
        _knots_of:int|none _passes:f8|none
    """),
    Kind("edges", CanonBounds, "_half:f8 last_position:f8* _time:float _floor:row[float] _mirrored:bool"),
    Kind("elements", Elements, """
        _score:score _group_masks:addressees _field:element-field _ahead:f4 _last_of:dict[str,element]
        _placed_measure:int _measure_elements:list[element] gain:float
    """),
    Kind("expression", Expression, """
        _dancers:dancers _motion:group-motion _seed:int _everybody:i4(dancer) _soloists:i4(dancer)* _measure:int
        _ticks:int number:f4 choice:i4 _slow:f4 hands:f4 asked:i4 _until:f8 _measured:f4 _shown_at:f8 _shown:f4
    """, is_consistent=Expression.is_consistent),
    Kind("evolutions", Evolutions, """
        _patch:constant-patch _casting:casting _score:score _formations:formations _beats:int _plan:plan
        _planned_measure:int _measure:int _measure_segments:list[segment] _next:int _fresh:bool _heading:f8|none
        _live_path_count:int
    """),
    Kind("group-motion", GroupMotion, """
        _patch:constant-patch casting:casting _seed:int _beats:int model:agent-model stage_area:floor
        gates:row[gate] entrances:entrances surroundings:surroundings performers:performers separation:parting
        evolutions:evolutions elements:elements partners:partners starting_heading:f8 state:agent-state
        _spare:agent-state _advance:pair-steering commands:wants _partner_agents:answering-agents _ahead:agents-ahead
        _now:tuple[timeline,measure-span]|none _speed:f4 _leash:f4~
    """),
    Kind("headings", Headings, "_patch:constant-patch _motion:group-motion _facing:group-values _raw:f8 _before:f8"),
    Kind("group-values", GroupValues, "groups:list[facing|ripple] own:list[tuple[b1,facing|ripple]]",
         is_consistent=whole.group_values),
    Kind("heard-poses", PoseBuffer, "count:int _blend_start:float _blend_s:float _root:f4* _rotation:f4* stamp:f8*~",
         is_consistent=whole.heard_poses),
    Kind("gesture-bank", ExampleBank, "moment:f4* weight:f4* first:i8* threshold:f8*",
         is_consistent=whole.gesture_bank),
    Kind("gesture-built-in", BuiltInGestures, """
        _inside:list[float] _moment:int _told:list[int] _floor:float _hips:float _flight:int _lift:float _rise:float
        _turned:float _pause:float _apart:float _closing:float _open:bool
    """),
    Kind("gesture-examples", ExampleFollower, """
        _bank:gesture-bank _gesture:i8* _matcher:gesture-matcher _best:f8* _times:i8* _ended:i8* _usual:f8* limit:f8*
        _scale:f8* _before:f8* _told:i8* _least:f8*
    """, is_consistent=whole.gesture_examples),
    Kind("gesture-learned", LearnedGesture, "name:str poses:row[str] background:row[str]"),
    Kind("gesture-lesson", Lesson, "name:str hips:f4* rotation:f4* background:int",
         is_consistent=whole.gesture_lesson),
    Kind("gesture-matcher", ExampleMatcher, """
        _bank:gesture-bank mean:f8* begun:i8* _memory:f8* _begun:i8* now:int
    """, is_consistent=whole.gesture_matcher),
    Kind("gesture-movement", Movement, """
        level:f8 tempo:float _signal:f8 _repeat:f8 _smooth:f8 _drift:f8 _rating:f8 _rated:float _steady:int _count:int
    """,
         is_consistent=whole.movement),
    Kind("gesture-performer", PerformerMovement, """
        stream:gesture-stream built_in:gesture-built-in movement:gesture-movement examples:gesture-examples
        ranges:list[gesture-range] _hips:f4* _rotation:f4* _kept:int
    """, is_consistent=whole.performer_movement),
    Kind("gesture-range", AdaptiveRange,
         "_narrowest:float _widest:float _first:float low:float high:float _known:bool"),
    Kind("gesture-stream", BodyStream, """
        count:int measure:f8* feature:f8* _joint:f8* _smooth:f8* _heading:float _time:float
    """, is_consistent=whole.body_stream),
    Kind("gestures", Gestures, """
        _mocap:mocap _reactions:reactions _score_runner:prompter _motion:group-motion _patch:constant-patch
        learned:list[gesture-learned] learned_count:int _followers:dict[str,gesture-performer] _ticks:int
        last:deque[tuple[str,str,float]] _names:list[str] _performers:list[str]
        _known:dict[str,list[tuple[str,str]]] _gesture:list[int] _bank:gesture-bank
        _dancers:dancers _clips_read:int _lessons:list[gesture-lesson] _pieces:int
    """, factories={"_library": list, "_work": no_value}, after_read=Gestures.repeat_work,
         is_consistent=whole.gestures),
    Kind("interrupts", Interrupts, """
        _dancers:dancers _motion:group-motion _scheduler:scheduler clip_cutter:cutting _cues:list[interrupts.cue]
        _half:tuple[int,int]|none _decided:bool _step:i4(step) _unplanned:b1 _collision_avoidance:avoiding cue_count:int
    """),
    Kind("interrupts.cue", _Cue, "step:int who:b1 measures:int groups:row[int] words:str"),
    Kind("mood-pose", MoodPose, "bend:f4 size:f4 drop:f4 gaze:f4 late:f8 _own:f8 _still:f4",
         factories={"_set_for": no_value}),
    Kind("mocap", CaptureManager, """
        _patch:constant-patch _motion:group-motion _dancers:dancers _scheduler:scheduler performers:dict[str,captured]
        _driven:b1 _place:f8 _speed:f8 _forces:presence _time:float
    """),
    Kind("pair-steering", PairSteering, "_advance:advance _partners:partners"),
    Kind("partners", Partners, """
        _group:i4(group) _arrangement:i4 _arm:f8 _holds:list[row[tuple[int,int]]] partner:i4(dancer) leader:i4(dancer)*
        follower:i4(dancer)* other:i4(dancer) hand:i4(side) _meeting:b1 _own:i4(dancer) _dance:bool offset:f8
    """),
    Kind("performers", Performers, "_surroundings:surroundings _radius:float _last:dict[str,event-Performer]"),
    Kind("pieces", TaskQueue, "_waiting:deque[tuple[float,method]] remaining:float"),
    Kind("planning", MeasurePlan, """
        _dancers:dancers _motion:group-motion _group:i4(group) _targets:aims _choices:choices _drafter:drafting
        _search:searching pieces:pieces _looked:bool
    """),
    Kind("presence", PerformerForces, "_motion:group-motion _tick:int"),
    Kind("pushing", ContactResolver, """
        _correction:carried _next_correction:coming _path_separation:path-parting _soon:f4 _fractions:f8 _speed:f8
        count:int
    """),
    Kind("re-aiming", CorrectionUpdate, """
        _correction:carried _path_separation:path-parting max_correction:float _phase:f8
    """),
    Kind("ripple", Ripple, "beats:float side:str point:tuple[float,float]"),
    Kind("seen-steps", SeenSteps, """
        _patch:constant-patch _motion:group-motion _dancers:dancers _refusals:refusals _seed:int
        answers:list[seen-steps.answer] takes:list[seen-steps.take] _poses:dict[str,danced-poses]
        _readings:dict[str,seen-steps.reading]
    """, factories={"templates": no_value, "_clips_read": int}, after_read=SeenSteps.read_library),
    Kind("seen-steps.answer", _Answer, "section:constant-answer-section on:bool how:str group:str"),
    Kind("seen-steps.reading", _Reading, """
        early:int whole:int measure:int step:str mirrored:bool confidence:float
    """),
    Kind("seen-steps.take", Take, """
        performer:str name:str group:str repeats:int measures:int beats_per_measure:int first:float hips:f4*
        rotation:f4* stamp:f8*
    """, is_consistent=lambda value: value.is_whole),
    Kind("scheduler", Scheduler, """
        _patch:constant-patch _dancers:dancers _motion:group-motion _group:i4(group)
        programmes:list[echo|group-programme] subgroups:subgroups root_correction:carrying targets:aims order:list[int]
        speed:f4 choices:choices _planning:planning choosing:constant-choosing step_costs:constant-foresight
        last_target:f8|none last_wish:f8|none last_heading:f8 detours:int dead_ends:int _look_beats:float
    """),
    Kind("searching", StepSearch, """
        _patch:constant-patch _dancers:dancers _motion:group-motion _targets:aims _choices:choices
        _search_nodes:i4(node) _arguments:row[any] _following:tuple[i4(dancer)*,i4(dancer)*,i4(node)*] seconds:float
        _choosing:constant-choosing _give:f8 _usual_give:float
    """, {"_behind": list}),
    Kind("taken-along", ResponsePath, """
        level:f8 weight:f8 following:b1 answering:b1 leading:b1 seeking:b1 goal:f8 displacement:f8 answer_position:f8
        last_position:f8 turn:f8 _last_target:f8 _amount:f8 _waited:f8 _has_last:b1
    """),
    Kind("texturing", LiveTexture, """
        bank:constant-texture-bank _variation:variation _seed:int _beats:int level:f4 fragment:i4(fragment)
        chosen_beat:i8 switch_beat:f8 _origin:f8 _limits:i4 _signs:i8 _kept:f4 _before:f4 _now:f4 _own:f4 _far:f4
        _told:f4 _told_moment:i8 _near:f4 _since:f8~ _danced_before:f8 _offsets:f4 _parents:i4(joint)
    """),
    Kind("variation", Variation, """
        values:f8 division:division _group:i4(group) _group_delays:f8 _seed:int _beats:int _window:float drift:drift
        measure:int has_recordings:bool ripples:group-values _patch_values:f8 _patch_ripples:row[ripple] delays:f8
        _late_before:f8 _timing_source:i4(dancer) _previous_timing_source:i4(dancer) _paired:i8(dancer)* _even:f8
        _everybody:i8(dancer) _of_dancers:f8 _drifts:bool _farthest:f8 mood:f8
    """),
]  # fmt: skip
