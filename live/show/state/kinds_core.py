"""Kinds of the packages below `show`: clock, motion, agents, graph."""

from typing import Final

from live.agents.agent_command import AgentCommand
from live.agents.crowd.agent_state import AgentModel, AgentState, Steering
from live.agents.crowd.crowd_step import CrowdStepper
from live.agents.crowd.obstacles import Surroundings, _Rows
from live.agents.elements.element import Element
from live.agents.elements.element_field import ElementField
from live.agents.elements.element_table import ElementTable
from live.agents.entrances.entrances import Entrances
from live.agents.entrances.gate import Gate
from live.agents.evolutions.collision_check import Approach
from live.agents.evolutions.facing import Facing, Orientation
from live.agents.evolutions.intention import (
    AssignmentMethod,
    Evolve,
    FollowMode,
    FollowWays,
    Hold,
    Matching,
    PathMode,
    Pause,
    Places,
    Procedural,
    Repertoire,
    Segment,
    Trajectory,
)
from live.agents.evolutions.planned_segment import PlannedSegment
from live.agents.evolutions.running_plan import Plan, _Entry
from live.agents.evolutions.segment_start import MotionDraft, PlannedMotion, SegmentStart
from live.agents.evolutions.slot_assignment import Cost, Fill
from live.agents.evolutions.start_delays import Arrival, Ripple, StartOrder
from live.agents.evolutions.trajectory import GroupState, Locomotion
from live.agents.formations.formation_spec import FormationSpec
from live.agents.groups.roster import Line, Roster
from live.agents.prediction import CrowdPrediction
from live.agents.separation.path_separation import Paths, PathSeparation, PlaceSeparation
from live.base.stage_snapshot import StageView
from live.clock.beat_estimate import Consensus, TempoPrior, WeightedBeat
from live.clock.follower.audio_source import AudioSource, Trust
from live.clock.follower.bar_alignment import BarAlignment
from live.clock.follower.beat_kalman_filter import BeatFilter
from live.clock.follower.clock_source import BeatMapping, BeatObservation
from live.clock.follower.count_in import CountIn
from live.clock.follower.external_source import ExternalSource, ManualSource
from live.clock.follower.phase_correction import Jump, SlewedTimeline
from live.clock.follower.source_arbiter import SourceArbiter
from live.clock.follower.timeline_follower import TimelineFollower
from live.clock.follower.tracker_inputs import BarPointerInput, ConsensusInput
from live.clock.tap_tempo import TapTempo
from live.clock.timeline import Grid, Timeline
from live.graph.search.sequence_spec import SequenceEntry
from live.motion.cloth.garment_batch import GarmentBatch
from live.motion.partner_live.floor_transform import FloorTransform
from live.motion.partner_live.follower_filter import FollowerFilter
from live.motion.partner_live.hand_holds import LiveHandHolds
from live.motion.partner_live.online_player import LivePartner
from live.motion.partner_live.stage_partner import FollowerFootLock, LeaderReader
from live.motion.pose.foot_lock import CutFootLift, FootLock
from live.motion.pose.hand_hold import HandHolds
from live.motion.pose.inertialization import Inertialization
from live.motion.pose.pose_pipeline import PosePipeline
from live.show.state import consistency as whole
from live.show.state.kind import Kind, no_value

KINDS: Final = [
    Kind("advance", CrowdStepper, "_agent_count:int _fixed:f4~ _rows:f4 _numbers:i4", is_consistent=whole.advance),
    Kind("agent-model", AgentModel, "radius:f4 responsibility:f4 steering:steering seed:int"),
    Kind("agent-state", AgentState, "acceleration:f4 flat:f4 rest_separation:f4 position:f4 rest:f4 velocity:f4"),
    Kind("steering", Steering, """
        half_width:float|none half_depth:float|none avoidance:str acceleration:float turn_rate:float relaxation:float
        horizon:float strength:float side:float d_s:float d_f:float edge:float lag:float
    """),
    Kind("surroundings", Surroundings, """
        flat:f4 _walls:surroundings.rows _obstacles:surroundings.rows refused_count:int
    """, is_consistent=whole.surroundings),
    Kind("surroundings.rows", _Rows, "rows:f4 _count:f4 names:list[str] _place:dict[str,int]"),
    Kind("approach", Approach, "first:int second:int beat:float distance:float"),
    Kind("arrive", Arrival, ""),
    Kind("order", StartOrder, ""),
    Kind("delays.ripple", Ripple, "beats:float order:order arrive:arrive"),
    Kind("departure", SegmentStart, """
        dancer_indices:i4(dancer)* position:f8* heading:f8* attributes:row[frozenset[str]] begin:float end:float
        measure_beats:float radius:f8* half_stage:tuple[float,float] seed:int
    """, is_consistent=whole.departure),
    Kind("departure.draft", MotionDraft, "motion:journey|none", {"urgent": bool}),
    Kind("journey", PlannedMotion, """
        locomotion:locomotion slot:i4(dancer)* retimed:int bent:bool remaining:row[approach] checked:bool
    """, is_consistent=whole.journey),
    Kind("by", AssignmentMethod, ""),
    Kind("evolve", Evolve, "formation:str matching:matching path_mode:way orientation:orientation soft:float"),
    Kind("follow", FollowMode, ""),
    Kind("follow-ways", FollowWays, "ways:str matching:matching orientation:orientation backwards:bool"),
    Kind("hold", Hold, "formation:str matching:matching"),
    Kind("matching", Matching, "by:by cost:cost equal_weight:float fill:fill"),
    Kind("pause", Pause, ""),
    Kind("places", Places, "name:str slots:f8* heading:f8* marks:list[str]|row[str]", is_consistent=whole.places),
    Kind("procedural", Procedural, "marks:row[str]"),
    Kind("repertoire", Repertoire, """
        formations:dict[str,places|named-formation] paths:dict[str,array*] ways:dict[str,f4*]
        intentions:dict[str,hold|evolve|pause|trajectory|follow-ways|procedural]
    """),
    Kind("trajectory", Trajectory, "path:str follow:follow gap:float orientation:orientation soft:float"),
    Kind("way", PathMode, ""),
    Kind("locomotion", Locomotion, "path_knots:f4* times:f8* turns:f8* ramp:float", is_consistent=whole.locomotion),
    Kind("setting", GroupState, "position:f4 velocity:f4 heading:f4 controlled:u1"),
    Kind("cost", Cost, ""),
    Kind("fill", Fill, ""),
    Kind("motion", PlannedSegment, """
        segment:segment intention:hold|evolve|pause|trajectory|follow-ways|procedural departure:departure
        dancers:i4(dancer)* controlled:u1* motion:journey|none _draft:departure.draft _actual_start:array*|none
        _late_calls_left:int _pieces:none
    """, is_consistent=whole.motion),
    Kind("orientation.facing", Facing, ""),
    Kind("orientation", Orientation, "facing:orientation.facing headings:row[float] smooth:bool turn_beats:float"),
    Kind("plan", Plan, """
        roster:roster available:b1 measure_beats:float _repertoire:repertoire _half:tuple[float,float] _radius:f8
        _seed:int _entries:list[plan.entry] _motions:list[motion] _prepared:dict[int,list[motion]]
        _in_progress:list[motion] _late_joint_calls_left:int _now:setting _target:setting _boundary:setting
    """, {"_joints": list}),
    Kind("plan.entry", _Entry, "segment:segment excluded:b1"),
    Kind("segment", Segment, """
        intention:str|hold|evolve|pause|trajectory|follow-ways|procedural group:str start:int measures:int
        ripple:delays.ripple mirror:relations.line|none delay:float
    """),
    Kind("formation-spec", FormationSpec, """
        shape:str name:str centre:tuple[float,float] size:tuple[float,float]|none proportions:str|none
        rotation_deg:float corners:int inner:float turns:float arc_deg:float text:str path:row[str]
        points:row[row[tuple[float,float]]] closed:bool|none dancers:str|none pattern:str|none mark_corners:bool|none
        weights:row[float] focus:tuple[float,float]|none focus_reach:float focus_strength:float count:int|none
        density:float|none spacing:float|none mirror:str|float|tuple[tuple[float,float],tuple[float,float]]|none
        mirror_at:tuple[float,float]|none mirror_keep:str|none soloists:int soloist_place:str soloist_gap:float
        sections:row[int] section_names:row[str] heading:str heading_deg:float
        headings_deg:row[float] like:formation-spec|none scale:float|tuple[float,float] bend_deg:float
        along:row[tuple[float,float]] into:row[row[tuple[float,float]]] neighbours:str|none counts_ahead:row[int]
    """),
    Kind("relations.line", Line, "x:float z:float heading:float"),
    Kind("roster", Roster, "attributes:row[frozenset[str]] groups:dict[str,str] known:frozenset[str]"),
    Kind("look-ahead", CrowdPrediction, """
        _advance:advance|pair-steering _surroundings:surroundings _fill_commands:method _commands:wants
        _state:agent-state _spare:agent-state _stops:list[float] _time:float positions:list[f4]
    """),
    Kind("parting", PlaceSeparation, """
        _gap:float _seed:int _half_width:float _half_depth:float _cell_start:i4 _order:i4(dancer)
    """),
    Kind("path-parting", PathSeparation, """
        _radius:f4 _responsibility:f4 _margin_at_end:float _stage:tuple[float,float,int]
        _surroundings:surroundings|none _cells:tuple[i4,i4] _middle:f4 _extent:f4 _yields:f4 _speed:f8 _moved:f8
        shortfall:f4
    """),
    Kind("paths", Paths, "path:f4 share:f4"),
    Kind("element", Element, """
        kind:int points:row[tuple[float,float]] strength:float start_beat:float end_beat:float groups:int source:str
        closed:bool radius:float fair:bool flow_kind:int decay:float|none target:int target_group:int wedge:bool
        separation:float|none alignment:float cohesion:float
    """, is_consistent=whole.element),
    Kind("element-table", ElementTable, """
        elements:list[element] _all_rows:f8~ _all_masks:u8 _all_vertices:f4 _all_outlines:f4 _first:int _voice_count:int
        grids:f4 active:i4 _half_size:tuple[float,float] _separation:float _capacity:int _serial:int _slot_use:list[int]
        rows:f8~ masks:u8 vertices:f4 outlines:f4
    """, factories={"_serials": dict}, after_read=ElementTable.rebuild_index, is_consistent=whole.element_table),
    Kind("element-field", ElementField, """
        _table:element-table influence:f4 _memory:f8 _sums:f8 _nearest:f8~ _spreading:f8 _places:f8 _audience:u8
        _density:f8 _numbers:f8~ _area:f8 _mesh:f4 _start:i4 _order:i4
    """),
    Kind("wants", AgentCommand, "rows:f4 _bits:u4 _kept:u4"),
    Kind("entrances", Entrances, """
        gates:row[gate] state:i1(presence) goal:f4 _gate:i4(gate) _size:tuple[float,float] _exit_bounds:f4
    """),
    Kind("gate", Gate, "name:str x:float z:float width:float out_x:float out_z:float"),
    Kind("garment-batch", GarmentBatch, """
        rows:i4(dancer)* count:int position:f4* velocity:f4* joints:f4* carrier:f4* fresh:u1*
    """, {"compiled": no_value, "_limbs": no_value, "_rest": no_value, "_sections": list}),
    Kind("stage-view", StageView, """
        joint_position:f4 joint_rotation:f4 group:i4 present:b1 face:f4 hand:f4 spring:f4* spring_slot:i4 appearance:i4
        cloth_position:f4* cloth_garment:i4* element_kind:i4
        element_position:f4 element_level:f4
        element_radius:f4 element_strength:f4 element_flow:i4 element_first:i4 element_corners:i4 element_corner:f4
        element_count:int light:f4 light_count:int obstacle:f4 obstacle_count:int wall:f4 wall_count:int time:float
        beat:float measure:int phase:float beats_per_measure:int tempo:float stage_size:tuple[float,float]
        brightness:float flash_limit_lifted:bool filled:bool picture:f8|none energy:float spot:f8
        gobo_turns:float count_in:float caption:row[tuple[str,float]] caption_level:float background_age:f8
        titles:row[title] overlay:row[str] guide:f4 guide_count:int
    """, {"detailed": bool}),
    Kind("consensus", Consensus, "_estimates:deque[consensus.heard] half_beats:bool"),
    Kind("consensus.heard", WeightedBeat, "time:float period:float weight:float"),
    Kind("preference", TempoPrior, "tempo:float octaves:float"),
    Kind("timeline-follower", TimelineFollower, """
        _audio:audio-source _internal:hand-source _tap:hand-source
        _sources:dict[str,audio-source|direct-source|hand-source] _slewed:run _alignment:measures _arbiter:ruling
        _taps:tap-tempo _counting:counting-in _downbeat_at:float|none _now:float _scale:float _locked:bool
        _confidence:float rejected:int manual_tempo:tuple[int,float] refused:int refusal:str
    """, factories={"on_hint": no_value}),
    Kind("audio-source", AudioSource, """
        name:str state:str confidence:float observed_at:float silent_since:float|none jumped:bool offset:float
        level:level detail:str consensus:consensus-ear pointer:pointer-ear _has_pointer:bool _restarts:int
        _song_since:float _kept_since:float _trust:trust _before_pause:str|none _paused_at:float
        manual_until:float
    """),
    Kind("beat-filter", BeatFilter, """
        _time:float _period:float number:int _var_time:float _cov:float _var_period:float _bias:float
        _before:tuple[float,float,float,float,float,float,int] updates:int _before_steps:int
    """),
    Kind("consensus-ear", ConsensusInput, """
        grid:grid _prefer:preference _consensus:consensus _first:bool share:float is_confirmed:bool
    """),
    Kind("counting-in", CountIn, "_measures:int _armed_until:float _now:float _downbeat:float|none"),
    Kind("direct-source", ExternalSource, """
        name:str state:str confidence:float observed_at:float silent_since:float|none jumped:bool offset:float
        level:level detail:str _grid:grid|none _line:float|none _beats:int _measure:int anchored:bool _fresh:bool
    """),
    Kind("hand-source", ManualSource, """
        name:str state:str confidence:float jumped:bool _grid:grid|none priority_until:float
    """),
    Kind("jump", Jump, "time:float before:float after:float cause:str"),
    Kind("level", BeatMapping, "factor:float _pivot_in:float _pivot_out:float"),
    Kind("measures", BarAlignment, """
        follow_metre:bool pending_metre:int|none runner_up:tuple[float,float] _pinned:bool _ended:bool _fresh:bool
        _likely_since:float
    """),
    Kind("pointer-ear", BarPointerInput, """
        _filter:beat-filter|none _suspects:list[said] _line:float|none _beats:int _votes:int _voted:int share:float
        _runner_up:tuple[float,float] restarts:int
    """),
    Kind("ruling", SourceArbiter, """
        _sources:dict[str,audio-source|direct-source|hand-source] _run:run _measures:measures _priority:row[str]
        _range:tuple[float,float] choice:str name:str free_running:bool held:bool _free_since:float _tempo_lost:float
        beat_offset:int
    """),
    Kind("run", SlewedTimeline, "timeline:timeline goal:grid jumps:int last_jump:jump|none _leap:str|none"),
    Kind("said", BeatObservation, """
        time:float period:float confidence:float beat:int beats_per_measure:int measure:int jump:bool anchored:bool
        runner_up:int runner_up_share:float
    """),
    Kind("trust", Trust, "_mean:float _beats:int"),
    Kind("grid", Grid, "time:float period:float number:int"),
    Kind("tap-tempo", TapTempo, "_taps:list[float]"),
    Kind("timeline", Timeline, """
        tempo:float beat_origin:float time_origin:float beats_per_measure:int measure_origin:float
    """),
    Kind("wanted", SequenceEntry, "step:int|none measures:int direction:str"),
    Kind("hands", HandHolds, "partner:i4(dancer) hand:i4(side) state:f4 _tempo:float active:bool"),
    Kind("placing", FloorTransform, """
        turn:complex shift:complex _last_turn:complex _last_shift:complex _speed:complex _turning:float
    """),
    Kind("live-partner", LivePartner, """
        filter:live-reader window:float _stretch:float unit:int begin:int decisions:list[tuple[int,int,float]]
        hands:tuple[int,int] _example:int _step:float _source:float _floor_transform:placing _offset:f8 _speed:f8
        _age:float
    """),
    Kind("live-reader", FollowerFilter, """
        units:constant-units rate:float model:constant-follower-model _ring:int _at:int _x:c16~ _x_height:f8~
        posterior:f8* _now:f8 _soon:f8 _feature:f8~ _near_square:f8* _square:f8* _scratch:f8* _cost:f8*~ expected:f8
        _beat_evidence:float unsure:float nearest:float place:complex facing:complex min_distance:float
    """),
    Kind("holding", LiveHandHolds, """
        leader:i4 hand:i4 closed:f8 reachable:b1 palm_distance:f8 missed_count:int _release_time:f8 _leader_palm:f4
        _wanted_time:f8 _miss_counted:b1 _amount:f8 _ticks:int _rows:list[tuple[int,int]]
        _last_check:dict[tuple[int,int],tuple[float,float,float]] _row_keys:list[tuple[int,int,int,int]]
        _dancers:i4(dancer)* _hands:i4(side)* _seen_dancers:i4(dancer)* _pose_rows:i4* _palm_table:f4*
    """, is_consistent=whole.holding),
    Kind("read-leader", LeaderReader, """
        examples:constant-lore _shift:float partner:live-partner frame_index:int|none still_frames:float root:f4
        contact:b1 answer_rotation:f4 has_answer:bool held:bool decided_label:str _reported:tuple[int,int]
        _facing:complex _points:c16~ _heights:f8~ style:str
    """, is_consistent=whole.read_leader),
    Kind("standing", FollowerFootLock, """
        lock:foot-lock _leg_position:f4 _contact:b1 stepping:b1 _pipeline:pose-pipeline
    """),
    Kind("inertia", Inertialization, "difference:f4 cut_time:f8~ age:f4 any_fading:bool"),
    Kind("landing", CutFootLift, "lift:f4"),
    Kind("foot-lock", FootLock, "state:f4"),
    Kind("pose-pipeline", PosePipeline, """
        skeleton:constant-pose-skeleton sample:f8* placement:f8* share:f4* mean:i4(node)* amplitude:f4* bend:f4*
        late:f4* head:f4* feet:f4* lock:bool difference:f4* age:f4* difference_rows:i4(joint) position:f4* rotation:f4*
        _soles:f4 _count:int
    """, is_consistent=PosePipeline.has_valid_shapes),
]  # fmt: skip
