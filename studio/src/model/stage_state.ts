// What one person sees and holds on the stage: the measure that is looked at, ways and ghosts, tools, and changes that are tried.
import { computed, effect, signal } from "@preact/signals";
import type { Positions } from "../net/frames";
import type { PreviewAnswer, Question } from "../net/preview";
import type { Value } from "../net/values";
import { Bending } from "./bending";
import type { Fault, SingleEdit, Ways } from "./document";
import { asLed, reached, writtenStart, type Reached } from "./danced";
import { distance, type Place } from "./geometry";
import { dancersIn } from "./material";
import { bodiesAt, endsOfWays, positionsAt, waysOf } from "./playback";
import type { Becomes } from "./stage_edits";
import type { Studio } from "./studio";

export type Tool = "select" | "lasso" | "line" | "curve" | "shape" | "attract" | "repel" | "spread" | "cross";

/** What stands above each dancer. */
export type Labels = "none" | "numbers" | "names";

/** A drawn line that waits for what becomes of it. */
export interface Stroke {
  points: Place[];
  closed: boolean;
}

/** A formation whose places are put by hand: place k belongs to dancer k of the list. */
export interface Placing {
  name: string;
  /** Its number in the document, from 1; 0: a new one. */
  number: number;
  dancers: number[];
  places: Place[];
  /** [degrees], 0 to the public, positive towards +x. */
  headings: number[];
}

export interface Meeting {
  measure: number;
  dancers: [number, number];
  distance: number;
}

export interface TooFar {
  measure: number;
  dancer: number;
  distance: number;
  reach: number;
}

export interface Played extends Reached {
  answer: PreviewAnswer;
  /** The same measures without the changes that are tried, for comparison. */
  before: PreviewAnswer | null;
}

const MOST_MEASURES = 64;
/** Measures that are simulated ahead: so many at once, so many in all; after an edit, and between two questions [ms]. */
const AHEAD_AT_ONCE = 2;
const MOST_AHEAD = 128;
const AHEAD_WAIT_MS = 1500;
const AHEAD_REST_MS = 120;
/** Measures whose bodies are played; in longer ranges they only stand. */
const MOST_BODIES = 16;

export class StageState {
  readonly tool = signal<Tool>("select");
  readonly labels = signal<Labels>("none");
  readonly distances = signal(false);
  readonly solid = signal(false);
  /** Whether elements that are put act at once, in the show that is danced. */
  readonly live = signal(false);
  readonly strength = signal(1);
  readonly measures = signal(4);
  readonly stroke = signal<Stroke | null>(null);
  /** What a line becomes: shown while it is drawn. */
  readonly becomes = signal<Becomes>("formation");
  /** Of those that can be bent along it or into it: which one, as "list name". */
  readonly bent = signal("");
  readonly placing = signal<Placing | null>(null);
  /** Where a place is that is dragged: its distances are shown. */
  readonly held = signal<Place | null>(null);
  /** The dancer that the keyboard stands on, from 1; 0: none. */
  readonly focus = signal(0);
  /** Whether changes are tried in the preview, and sent together. */
  readonly trying = signal(false);
  readonly tried = signal<SingleEdit[]>([]);
  /** Without the changes that are tried, to compare. */
  readonly without = signal(false);
  readonly played = signal<Played | null>(null);
  readonly playedPositions = signal<Positions | null>(null);
  readonly playedBefore = signal<Positions | null>(null);
  /** Joints of the played moment, while the stage is seen in 3D. */
  readonly playedBodies = signal<Float32Array | null>(null);
  /** The played measure, from 1, with a fraction. */
  readonly playedMeasure = signal(0);
  /** Places of a formation that is only thought of. */
  readonly thought = signal<Place[]>([]);
  /** Why there are none. */
  readonly refusal = signal<Pick<Fault, "what" | "remedy">[]>([]);
  readonly bending = new Bending(this);
  readonly momentAnswer = signal<PreviewAnswer | null>(null);
  /** Of the same measure: what would go wrong in it. */
  readonly momentNotes = signal<PreviewAnswer | null>(null);
  readonly segmentAnswer = signal<PreviewAnswer | null>(null);
  readonly waits = signal(false);

  /** The danced measure (from 1) at the cursor; null: now. */
  readonly looked = computed(() => {
    const cursor = this.studio.cursor.value;
    return cursor === null ? null : reached(this.studio.score.value, cursor).from;
  });
  /** Whether that measure comes only if somebody leads there. */
  readonly led = computed(() => this.studio.cursor.value !== null && reached(this.studio.score.value, this.studio.cursor.value).led);
  /** Where everybody stands at the cursor, by the preview. */
  readonly momentPositions = computed(() => {
    const answer = this.momentAnswer.value;
    const cursor = this.studio.cursor.value;
    const looked = this.looked.value;
    if (!answer || cursor === null || looked === null || Math.round(answer.moments[0]?.measure ?? 0) !== looked) return null;
    return positionsAt(answer.moments, answer.positions, looked + (cursor % 1), "measure");
  });
  readonly shown = computed(() => this.playedPositions.value ?? (this.looked.value === null ? this.studio.doc.positions.value : this.momentPositions.value));
  /** The stage's own picture, pale, while something else is shown. */
  readonly compared = computed(() => {
    if (this.playedPositions.value) return this.playedBefore.value;
    return this.looked.value === null ? null : this.studio.doc.positions.value;
  });
  readonly ways = computed((): Ways | null => {
    if (this.played.value) return null;
    const drag = this.studio.dragAnswer.value;
    if (drag) return waysIn(drag);
    const chosen = this.segmentAnswer.value;
    if (chosen) return waysIn(chosen);
    const moment = this.looked.value === null ? null : this.momentAnswer.value;
    return moment?.positions.length ? { from: 0, to: 0, segment: null, ...waysOf(moment.positions) } : null; // as they are danced
  });
  /** Where everybody stands at the end of the chosen measures. */
  readonly ghost = computed((): Positions | null => {
    if (this.played.value) return null;
    const drag = this.studio.dragAnswer.value;
    const chosen = this.segmentAnswer.value ?? (this.looked.value === null ? null : this.momentAnswer.value);
    const like = chosen?.positions.at(-1) ?? this.shown.value;
    const ways = drag && waysIn(drag);
    if (ways && like) return endsOfWays(ways.ways, ways.dancers, like);
    return chosen?.positions.at(-1) ?? null;
  });
  readonly faults = computed(() => {
    if (this.refusal.value.length) return { meetings: [], tooFar: [], notes: [], refused: this.refusal.value };
    const answer = this.played.value?.answer ?? this.studio.dragAnswer.value ?? this.segmentAnswer.value ?? (this.looked.value === null ? null : this.momentNotes.value);
    const notes = answer?.texts["notes"];
    return {
      meetings: (notes?.["meetings"] as Meeting[] | undefined) ?? [],
      tooFar: (notes?.["too_far"] as TooFar[] | undefined) ?? [],
      notes: (notes?.["notes"] as { measure: number | null; what: string }[] | undefined) ?? [],
      refused: [...(answer?.refused ?? []), ...refusedEdits(notes)],
    };
  });
  readonly alarmed = computed(() => {
    const { meetings, tooFar } = this.faults.value;
    return new Set([...meetings.flatMap((one) => one.dancers), ...tooFar.map((one) => one.dancer)]);
  });
  /** Dancers (from 1) whose ways are drawn or dragged just now; those of the others are planned together with them. Empty: nobody's, or everybody's. */
  readonly own = computed((): ReadonlySet<number> => {
    if (!this.studio.dragAnswer.value) return new Set();
    const groups = this.studio.doc.structure.value?.groups ?? [];
    const chosen = this.studio.selected.value;
    const entry = chosen.length === 1 && chosen[0]?.list === "segment" && !this.drawn.value ? this.studio.entry(chosen[0]) : undefined;
    const found = dancersIn(groups, this.drawn.value || String(entry?.["group"] ?? "*")) ?? [];
    return new Set(found.length < groups.reduce((sum, group) => sum + group.dancers, 0) ? found : []);
  });
  /** For whom a line is drawn; "": none is. */
  readonly drawn = signal("");
  /** Groups with ways that are planned together with those that are drawn. */
  readonly together = computed((): string[] => {
    const own = this.own.value;
    const ways = own.size ? this.ways.value : null;
    const groups = this.studio.doc.structure.value?.groups ?? [];
    const first = groups.map((_, index) => groups.slice(0, index).reduce((sum, group) => sum + group.dancers, 1));
    const moves = new Set(ways?.dancers.filter((dancer, row) => !own.has(dancer) && isMoving(ways.ways[row] ?? [])));
    return groups.filter((group, index) => Array.from({ length: group.dancers }, (_, at) => (first[index] as number) + at).some((dancer) => moves.has(dancer))).map((group) => group.name);
  });
  private playing = 0;
  private ahead = 0;
  private drags = 0;

  constructor(readonly studio: Studio) {}

  /** Ask the preview whenever what is looked at changes; returns what ends it. */
  watch(): () => void {
    const stops = [
      effect(() => {
        const measure = this.looked.value;
        this.about(measure === null ? null : { from: measure, to: measure, positions: "samples", ways: false, notes: false, ...asLed(this.led.value) }, "moment", this.momentAnswer);
      }),
      effect(() => {
        const measure = this.looked.value;
        this.about(measure === null ? null : { from: measure, to: measure, positions: "none", ways: false, ...asLed(this.led.value) }, "notes", this.momentNotes);
      }),
      effect(() => {
        const chosen = this.studio.selected.value.filter((one) => one.list === "segment");
        const one = chosen.length === 1 ? chosen[0] : undefined;
        if (!one) this.segmentAnswer.value = null;
        this.about(one ? { segment: one.number, ...asLed(this.measuresOf("segment", one.number)?.led ?? false) } : null, "segment", this.segmentAnswer);
      }),
      effect(() => {
        const played = this.solid.value ? this.played.peek() : null;
        if (played && !played.answer.motions.length && played.to - played.from < MOST_BODIES) void this.play(played);
      }),
      effect(() => {
        void this.studio.doc.revision.value;
        if (this.studio.doc.structure.value) this.simulateAhead();
      }),
      this.studio.cursor.subscribe(() => { if (this.played.peek()) this.stop(); }),
      effect(() => {
        void this.studio.selected.value;
        void this.studio.doc.revision.value;
        this.studio.dragAnswer.value = null;
      }),
    ];
    return () => {
      for (const stop of stops) stop();
      this.stop();
      this.ahead++;
    };
  }

  /** Have the preview simulate the score while nothing else is asked, a little at a time, so that what is clicked is there. */
  private simulateAhead(): void {
    const mine = ++this.ahead;
    const last = Math.min(Math.ceil(this.studio.length.peek()), MOST_AHEAD);
    const next = async (measure: number): Promise<void> => {
      if (mine !== this.ahead || measure > last) return;
      if (!document.hidden) await this.studio.preview.ask({ measure }, "ahead");
      setTimeout(() => void next(document.hidden ? measure : measure + AHEAD_AT_ONCE), AHEAD_REST_MS);
    };
    setTimeout(() => void next(AHEAD_AT_ONCE), AHEAD_WAIT_MS);
  }

  private about(question: Question | null, topic: string, into: { value: PreviewAnswer | null }): void {
    const { doc, preview } = this.studio;
    const tried = this.without.value ? [] : this.tried.value;
    void doc.revision.value;
    if (!doc.structure.value || !question) {
      into.value = null;
      return;
    }
    if (topic !== "notes") this.waits.value = true;
    void preview.ask({ ...question, ...(tried.length ? { with: tried } : {}) }, topic, topic !== "notes").then((answer) => {
      if (answer.replaced) return;
      if (topic !== "notes") this.waits.value = false;
      into.value = answer;
    });
  }

  /** What edits would change in some danced measures, while they are dragged: planned ways, or simulated ones of elements. */
  drag(edits: SingleEdit[], { from, to, led }: Reached, simulated = false): void {
    const all = [...this.tried.value, ...edits];
    const last = Math.min(to, from + MOST_MEASURES - 1);
    const question: Question = { from, to: last, with: all, notes: true, ...asLed(led), ...(simulated ? { positions: "samples" } : { positions: "none", planned: true }) };
    const drag = ++this.drags;
    void this.studio.preview.ask(question, "drag", true).then((answer) => {
      if (answer.replaced || drag !== this.drags) return;
      if (simulated && answer.positions.length) answer.texts["ways"] = { ...answer.texts["ways"], ...waysOf(answer.positions) };
      this.studio.dragAnswer.value = answer;
    });
  }

  /** Nothing is dragged any more: answers that still come are forgotten. */
  endDrag(): void {
    this.drags++;
    this.studio.dragAnswer.value = null;
  }

  /** Send edits, or keep them to be tried. True: taken. */
  async send(edits: SingleEdit[]): Promise<boolean> {
    if (this.trying.value) {
      this.tried.value = [...this.tried.value, ...edits];
      return true;
    }
    const answer = await this.studio.doc.edits(edits);
    this.endDrag();
    return !answer.refused;
  }

  /** Call the show now; without a connection that is told, because a late call would surprise. */
  call(address: string, ...values: Value[]): void {
    const { values: live, doc } = this.studio;
    if (live.link.state.value === "open") live.send(address, ...values);
    else doc.tell("refused", "Nothing was sent: there is no connection to the show");
  }

  async sendTried(): Promise<void> {
    const answer = await this.studio.doc.edits(this.tried.value);
    if (!answer.refused) this.discard();
  }

  discard(): void {
    this.tried.value = [];
    this.without.value = false;
    this.endDrag();
    this.trying.value = false;
    this.stop();
  }

  /** The measures of an entry; null if it is gone. */
  measuresOf(list: string, number: number): Reached | null {
    const entry = this.studio.entry({ list, number });
    if (!entry) return null;
    const { score, beats } = this.studio;
    return reached(score.value, writtenStart(score.value, entry, beats.value), this.studio.box({ list, number })?.length ?? 1);
  }

  /** The written measure (from 0) where something new begins: that of the cursor, or the next one. */
  here(): number {
    return Math.floor(this.studio.cursor.value ?? (this.studio.playhead.value ?? -1) + 1);
  }

  /** Play measures of the preview, on the beat, again and again. */
  async play({ from, to, led }: Reached): Promise<void> {
    this.stop();
    const last = Math.min(to, from + MOST_MEASURES - 1);
    const question: Question = { from, to: last, ...asLed(led), positions: "samples", joints: this.solid.value && last - from < MOST_BODIES };
    const tried = this.tried.value;
    this.waits.value = true;
    const ask = (edits: SingleEdit[], topic: string): Promise<PreviewAnswer> => this.studio.preview.ask({ ...question, ...(edits.length ? { with: edits } : {}) }, topic);
    const [answer, before] = await Promise.all([ask(tried, "play"), tried.length ? ask([], "before") : null]);
    this.waits.value = false;
    if (answer.replaced) return;
    if (answer.refused || !answer.positions.length) {
      this.studio.doc.tell("refused", `Measures ${from} to ${last} cannot be played`, answer.refused ?? []);
      return;
    }
    this.played.value = { answer, before, from, to: last, led };
    const begun = performance.now();
    const first = answer.moments[0]?.time_s ?? 0;
    const length = (answer.moments.at(-1)?.time_s ?? first) - first;
    const frame = (now: number): void => {
      const time = first + (length > 0 ? (((now - begun) / 1000) % length) : 0);
      const shown = this.without.value && before ? before : answer;
      const other = this.without.value ? answer : before;
      this.playedPositions.value = positionsAt(shown.moments, shown.positions, time, "time_s");
      this.playedBefore.value = other ? positionsAt(other.moments, other.positions, time, "time_s") : null;
      this.playedBodies.value = bodiesAt(shown.moments, shown.motions, time);
      this.playedMeasure.value = from + ((time - first) / Math.max(length, 1e-6)) * (last - from + 1);
      this.playing = requestAnimationFrame(frame);
    };
    this.playing = requestAnimationFrame(frame);
  }

  stop(): void {
    cancelAnimationFrame(this.playing);
    this.played.value = null;
    this.playedPositions.value = null;
    this.playedBefore.value = null;
    this.playedBodies.value = null;
  }

  /** Back to what is danced now. */
  now(): void {
    this.stop();
    this.studio.cursor.value = null;
  }
}

function waysIn(answer: PreviewAnswer | null): Ways | null {
  const found = answer?.texts["ways"] as unknown as Ways | undefined;
  return found?.ways ? found : null;
}

function isMoving(way: Place[]): boolean {
  const [first, last] = [way[0], way.at(-1)];
  return first !== undefined && last !== undefined && distance(first, last) > 0.3;
}

function refusedEdits(notes: Record<string, unknown> | undefined): { what: string; remedy?: string }[] {
  const answers = (notes?.["answers"] as { refused?: { what: string; remedy?: string }[] }[] | undefined) ?? [];
  return answers.flatMap((one) => one.refused ?? []);
}
