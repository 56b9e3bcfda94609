"""Kinds of the packages below `show`: clock, motion, agents, graph."""

from typing import Final

from live.agents.agent_command import Wants
from live.agents.crowd.agent_state import AgentModel, AgentState, Steering
from live.agents.crowd.crowd_step import Advance
from live.agents.crowd.obstacles import Surroundings, _Rows
from live.agents.elements.element import Element
from live.agents.elements.element_field import ElementField
from live.agents.elements.element_table import ElementTable
from live.agents.entrances.entrances import Entrances
from live.agents.entrances.gate import Gate
from live.agents.evolutions.collision_check import Approach
from live.agents.evolutions.facing import Facing, Orientation
from live.agents.evolutions.intention import (
    By,
    Evolve,
    Follow,
    Hold,
    Matching,
    Pause,
    Places,
    Procedural,
    Repertoire,
    Segment,
    Trajectory,
    Way,
)
from live.agents.evolutions.planned_segment import Motion
from live.agents.evolutions.running_plan import Plan, _Entry
from live.agents.evolutions.segment_start import Departure, Draft, Journey
from live.agents.evolutions.slot_assignment import Cost, Fill
from live.agents.evolutions.start_delays import Arrive, Order, Ripple
from live.agents.evolutions.trajectory import Locomotion, Setting
from live.agents.formations.formation_spec import FormationSpec
from live.agents.groups.roster import Line, Roster
from live.agents.prediction import LookAhead
from live.agents.separation.path_separation import Parting, PathParting, Paths
from live.base.stage_snapshot import StageView
from live.clock.beat_estimate import Consensus, Heard, Preference
from live.clock.follower.audio_source import AudioSource
from live.clock.follower.bar_alignment import Measures
from live.clock.follower.beat_kalman_filter import BeatFilter
from live.clock.follower.clock_source import Level, Said
from live.clock.follower.count_in import CountingIn
from live.clock.follower.external_source import DirectSource, HandSource
from live.clock.follower.phase_correction import Jump, Run
from live.clock.follower.source_arbiter import Ruling
from live.clock.follower.timeline_follower import TimelineFollower
from live.clock.follower.tracker_inputs import ConsensusEar, PointerEar
from live.clock.tap_tempo import TapTempo
from live.clock.timeline import Grid, Timeline
from live.graph.search.sequence_spec import Wanted
from live.motion.partner_live.hand_holds import Holding
from live.motion.partner_live.online_decoder import LiveReader
from live.motion.partner_live.online_player import LivePartner, Placing
from live.motion.partner_live.stage_partner import ReadLeader, Standing
from live.motion.pose.foot_lock import FootLock, Landing
from live.motion.pose.hand_hold import Hands
from live.motion.pose.inertialization import Inertia
from live.motion.pose.pose_pipeline import PosePipeline
from live.show.state import consistency as whole
from live.show.state.kind import Kind, nothing

KINDS: Final = [
    Kind("advance", Advance, "_agent_count:int _fixed:f4~ _rows:f4 _numbers:i4", whole=whole.advance),
    Kind("agent-model", AgentModel, "radius:f4 responsibility:f4 steering:steering seed:int"),
    Kind("agent-state", AgentState, "acceleration:f4 flat:f4 heed:f4 position:f4 rest:f4 velocity:f4"),
    Kind("steering", Steering, """
        half_width:float|none half_depth:float|none avoidance:str acceleration:float turn_rate:float relaxation:float
        horizon:float strength:float side:float d_s:float d_f:float edge:float lag:float
    """),
    Kind("surroundings", Surroundings, """
        flat:f4 _walls:surroundings.rows _obstacles:surroundings.rows refused:int
    """, whole=whole.surroundings),
    Kind("surroundings.rows", _Rows, "rows:f4 _count:f4 names:list[str] _place:dict[str,int]"),
    Kind("approach", Approach, "first:int second:int beat:float distance:float"),
    Kind("arrive", Arrive, ""),
    Kind("order", Order, ""),
    Kind("delays.ripple", Ripple, "beats:float order:order arrive:arrive"),
    Kind("departure", Departure, """
        numbers:i4(dancer)* position:f8* heading:f8* words:row[frozenset[str]] begin:float end:float measure_beats:float
        radius:f8* half:tuple[float,float] seed:int
    """, whole=whole.departure),
    Kind("departure.draft", Draft, "journey:journey|none"),
    Kind("journey", Journey, """
        locomotion:locomotion slot:i4(dancer)* retimed:int bent:bool remaining:row[approach] checked:bool
    """, whole=whole.journey),
    Kind("by", By, ""),
    Kind("evolve", Evolve, "formation:str matching:matching way:way orientation:orientation soft:float"),
    Kind("follow", Follow, ""),
    Kind("hold", Hold, "formation:str matching:matching"),
    Kind("matching", Matching, "by:by cost:cost equal_weight:float fill:fill"),
    Kind("pause", Pause, ""),
    Kind("places", Places, "name:str slots:f8* heading:f8* marks:list[str]|row[str]", whole=whole.places),
    Kind("procedural", Procedural, "marks:row[str]"),
    Kind("repertoire", Repertoire, """
        formations:dict[str,places|named-formation] paths:dict[str,array*]
        intentions:dict[str,hold|evolve|pause|trajectory|procedural]
    """),
    Kind("trajectory", Trajectory, "path:str follow:follow gap:float orientation:orientation soft:float"),
    Kind("way", Way, ""),
    Kind("locomotion", Locomotion, "ways:f4* times:f8* turns:f8* soft:float", whole=whole.locomotion),
    Kind("setting", Setting, "position:f4 velocity:f4 heading:f4 under:u1"),
    Kind("cost", Cost, ""),
    Kind("fill", Fill, ""),
    Kind("motion", Motion, """
        segment:segment intention:hold|evolve|pause|trajectory|procedural departure:departure who:i4(dancer)* keep:u1*
        journey:journey|none _draft:departure.draft _from:array*|none _left:int _pieces:none
    """, whole=whole.motion),
    Kind("orientation.facing", Facing, ""),
    Kind("orientation", Orientation, "facing:orientation.facing headings:row[float] smooth:bool turn_beats:float"),
    Kind("plan", Plan, """
        roster:roster available:b1 measure_beats:float _repertoire:repertoire _half:tuple[float,float] _radius:f8
        _seed:int _entries:list[plan.entry] _motions:list[motion] _coming:dict[int,list[motion]] _at_work:list[motion]
        _now:setting _target:setting _boundary:setting
    """),
    Kind("plan.entry", _Entry, "segment:segment without:b1"),
    Kind("segment", Segment, """
        intention:str|hold|evolve|pause|trajectory|procedural group:str start:int measures:int ripple:delays.ripple
        mirror:relations.line|none later:float
    """),
    Kind("formation-spec", FormationSpec, """
        shape:str name:str centre:tuple[float,float] size:tuple[float,float]|none proportions:str|none
        rotation_deg:float corners:int inner:float turns:float arc_deg:float text:str path:row[str]
        points:row[row[tuple[float,float]]] closed:bool|none dancers:str|none pattern:str|none mark_corners:bool|none
        weights:row[float] focus:tuple[float,float]|none focus_reach:float focus_strength:float count:int|none
        density:float|none spacing:float|none mirror:str|tuple[tuple[float,float],tuple[float,float]]|none
        mirror_keep:str|none soloists:int soloist_place:str soloist_gap:float sections:row[int] section_names:row[str]
        heading:str heading_deg:float
    """),
    Kind("relations.line", Line, "x:float z:float heading:float"),
    Kind("roster", Roster, "attributes:row[frozenset[str]] groups:dict[str,str] known:frozenset[str]"),
    Kind("look-ahead", LookAhead, """
        _advance:advance|pair-steering _surroundings:surroundings _ask:method _wants:wants _state:agent-state
        _spare:agent-state _stops:list[float] _time:float positions:list[f4]
    """),
    Kind("parting", Parting, """
        _gap:float _seed:int _half_width:float _half_depth:float _cell_start:i4 _order:i4(dancer)
    """),
    Kind("path-parting", PathParting, """
        _radius:f4 _responsibility:f4 _margin_at_end:float _stage:tuple[float,float,int]
        _surroundings:surroundings|none _cells:tuple[i4,i4] _middle:f4 _extent:f4 _yields:f4 _speed:f8 _moved:f8
        lack:f4
    """),
    Kind("paths", Paths, "path:f4 share:f4"),
    Kind("element", Element, """
        kind:int points:row[tuple[float,float]] strength:float start_beat:float end_beat:float groups:int source:str
        closed:bool radius:float fair:bool flow:int decay:float|none target:int target_group:int wedge:bool
        separation:float|none alignment:float cohesion:float
    """, whole=whole.element),
    Kind("element-table", ElementTable, """
        elements:list[element] _all_rows:f8~ _all_masks:u8 _all_vertices:f4 _first:int _fair:int grids:f4 active:i4
        _half:tuple[float,float] _separation:float _capacity:int _serial:int _slot_use:list[int] rows:f8~ masks:u8
        vertices:f4
    """, anew={"_serials": dict}, after=ElementTable.number_again, whole=whole.element_table),
    Kind("element-field", ElementField, """
        _table:element-table influence:f4 _memory:f8 _sums:f8 _near:f8~ _spreading:f8 _places:f8 _audience:u8
        _density:f8 _numbers:f8~ _area:f8 _mesh:f4 _cosines:f4 _start:i4 _order:i4
    """),
    Kind("wants", Wants, "rows:f4 _bits:u4 _kept:u4"),
    Kind("entrances", Entrances, """
        gates:row[gate] state:i1(presence) goal:f4 _gate:i4(gate) _size:tuple[float,float] _beyond:f4
    """),
    Kind("gate", Gate, "name:str x:float z:float width:float out_x:float out_z:float"),
    Kind("stage-view", StageView, """
        joint_position:f4 joint_rotation:f4 group:i4 present:b1 element_kind:i4 element_position:f4 element_level:f4
        element_radius:f4 element_strength:f4 element_flow:i4 element_first:i4 element_corners:i4 element_corner:f4
        element_count:int light:f4 light_count:int obstacle:f4 obstacle_count:int wall:f4 wall_count:int time:float
        beat:float measure:int phase:float beats_per_measure:int tempo:float stage_size:tuple[float,float]
        brightness:float flashes:bool filled:bool picture:f8|none energy:float spot:f8 count_in:float overlay:row[str]
        guide:f4 guide_count:int
    """),
    Kind("consensus", Consensus, "_heard:deque[consensus.heard] half_beats:bool"),
    Kind("consensus.heard", Heard, "time:float period:float weight:float"),
    Kind("preference", Preference, "tempo:float octaves:float"),
    Kind("timeline-follower", TimelineFollower, """
        _audio:audio-source _internal:hand-source _tap:hand-source
        _sources:dict[str,audio-source|direct-source|hand-source] _run:run _measures:measures _ruling:ruling
        _taps:tap-tempo _counting:counting-in _one_at:float|none _now:float _scale:float _locked:bool _share:float
        rejected:int hand_tempo:tuple[int,float] refused:int refusal:str
    """, anew={"on_seed": nothing}),
    Kind("audio-source", AudioSource, """
        name:str state:str confidence:float heard_at:float silent_since:float|none jumped:bool offset:float
        level:level detail:str consensus:consensus-ear pointer:pointer-ear _pointing:bool _restarts:int
        _song_since:float _kept_since:float _before_pause:str|none _paused_at:float rest_until:float
    """),
    Kind("beat-filter", BeatFilter, """
        _time:float _period:float number:int _var_time:float _cov:float _var_period:float _bias:float
        _before:tuple[float,float,float,float,float,float,int] updates:int _before_steps:int
    """),
    Kind("consensus-ear", ConsensusEar, """
        grid:grid _prefer:preference _consensus:consensus _first:bool share:float believed:bool
    """),
    Kind("counting-in", CountingIn, "_measures:int _armed_until:float _now:float _one:float|none"),
    Kind("direct-source", DirectSource, """
        name:str state:str confidence:float heard_at:float silent_since:float|none jumped:bool offset:float
        level:level detail:str _grid:grid|none _line:float|none _beats:int _measure:int anchored:bool _fresh:bool
    """),
    Kind("hand-source", HandSource, """
        name:str state:str confidence:float jumped:bool _grid:grid|none rules_until:float
    """),
    Kind("jump", Jump, "time:float before:float after:float cause:str"),
    Kind("level", Level, "factor:float _pivot_in:float _pivot_out:float"),
    Kind("measures", Measures, "follow_metre:bool coming:int|none _pinned:bool _agreed:bool _fresh:bool"),
    Kind("pointer-ear", PointerEar, """
        _filter:beat-filter|none _suspects:list[said] _line:float|none _beats:int _votes:int _voted:int share:float
        restarts:int
    """),
    Kind("ruling", Ruling, """
        _sources:dict[str,audio-source|direct-source|hand-source] _run:run _measures:measures _priority:row[str]
        _range:tuple[float,float] choice:str name:str free:bool held:bool _free_since:float _tempo_lost:float
        shift:int
    """),
    Kind("run", Run, "timeline:timeline goal:grid jumps:int last_jump:jump|none _leap:str|none"),
    Kind("said", Said, """
        time:float period:float confidence:float beat:int beats_per_measure:int measure:int jump:bool anchored:bool
    """),
    Kind("grid", Grid, "time:float period:float number:int"),
    Kind("tap-tempo", TapTempo, "_taps:list[float]"),
    Kind("timeline", Timeline, """
        tempo:float beat_origin:float time_origin:float beats_per_measure:int measure_origin:float
    """),
    Kind("wanted", Wanted, "step:int|none measures:int way:str"),
    Kind("hands", Hands, "other:i4(dancer) hand:i4(side) state:f4 _tempo:float held:bool"),
    Kind("placing", Placing, """
        turn:complex shift:complex _last_turn:complex _last_shift:complex _speed:complex _turning:float
    """),
    Kind("live-partner", LivePartner, """
        reader:live-reader unit:int begin:int seen:list[tuple[int,int,float]] _step:float _source:float
        _placing:placing _offset:f8 _speed:f8 _age:float
    """),
    Kind("live-reader", LiveReader, """
        units:constant-units rate:float k:float _stretches:constant-stretches _longest:int _ring:int _at:int _x:c16
        _x_height:f8 _score:f8~ _end:f8~ _cell:i8 _before:i8 _first:i8 _offset:i8 _real:f8 _imaginary:f8 _heights:f8
        _work:f8 _control:c16 _control_height:f8 _record_first:i8 _record_stop:i8 _head:c16 _head_height:f8 _root:c16
        _facing:c16 nearest:float _step:f8 _sums:c16 _squares:f8 _input_sum:c16 _input_square:f8 _frames:f8 _value:f8~
        _expected:c16 _shortest:f8 _most:f8
    """),
    Kind("holding", Holding, """
        leader:i4 hand:i4 closed:f8 within:b1 apart:f8 missed:int _left:f8 _place:f4 _wanted:f8 _told:b1 _amount:f8
        _ticks:int _rows:list[tuple[int,int]] _last:dict[tuple[int,int],tuple[float,float,float]]
        _laid:list[tuple[int,int,int,int]] _who:i4(dancer)* _hands:i4(side)* _looked:i4(dancer)* _where:i4* _far:f4*
    """, whole=whole.holding),
    Kind("read-leader", ReadLeader, """
        lore:constant-lore _shift:float partner:live-partner line:int|none still:float root:f4 contact:b1 turned:f4
        answered:bool held:bool news:str _told:tuple[int,int] _facing:complex _points:c16 _heights:f8
    """, whole=whole.read_leader),
    Kind("standing", Standing, "lock:foot-lock _legs:f4 _contact:b1 _pipeline:pose-pipeline"),
    Kind("inertia", Inertia, "settling:f4 began:f8~ age:f4 any_settles:bool"),
    Kind("landing", Landing, "lift:f4"),
    Kind("foot-lock", FootLock, "state:f4"),
    Kind("pose-pipeline", PosePipeline, """
        skeleton:constant-pose-skeleton sample:f8* placement:f8* share:f4* mean:i4(node)* amplitude:f4* head:f4*
        feet:f4* lock:bool settling:f4* age:f4* watched:i4(joint) position:f4* rotation:f4* _soles:f4 _count:int
        _parts:list[tuple[int,int]]
    """, anew={"_pool": nothing}, whole=PosePipeline.is_whole),
]  # fmt: skip
