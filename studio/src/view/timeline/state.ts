// Where the timeline stands: its geometry, what is visible, what is held, and what the preview says of it.
import { computed, signal } from "@preact/signals";
import { hasDancers, moveEdits, resizeEdits } from "../../model/arrange";
import { asLed, reached } from "../../model/danced";
import type { Box, Row } from "../../model/plan";
import type { SingleEdit } from "../../model/document";
import type { Studio } from "../../model/studio";

/** Top and bottom of the phrases in the ruler [px]. */
export const PHRASES: readonly [number, number] = [26, 40];
/** Height of a lane, of a row of a curve, and of the ruler [px]. */
export const LANE = 26;
const ROW_MARGIN = 7;
const CURVE = 47;
export const RULER = 92;
export const MIN_SCALE = 1.5;
export const MAX_SCALE = 640;
/** Parts of a row that are made or left out as one [measures]. */
export const CHUNK = 32;
const SCREENS = 0.5;
const MOST_ELEMENTS = 300;
/** What changes who dances which step: it is simulated, not only planned. */
const STEP_LISTS = ["sequence", "improvise"];
/** Before what has to be simulated is tried; what is only planned is tried at once [ms]. */
const TRY_WAIT_MS = 150;
const MOST_TRIED = 32;

/** What is done with the pointer, as it stands now. */
export type Gesture =
  | { kind: "move"; boxes: Box[]; from: number; by: number; rows: number; copy: boolean }
  | { kind: "begin" | "end"; boxes: Box[]; by: number }
  | { kind: "canon"; list: string; number: number; start: number; beats: number; row: number }
  | { kind: "marquee"; x: [number, number]; y: [number, number] }
  | { kind: "drop"; list: string; value: Record<string, unknown>; start: number; length: number; row: number }
  | { kind: "section"; number: number; start: number; measures: number; to: number | null };

export interface Ghost {
  row: number;
  lane: number;
  start: number;
  length: number;
  label: string;
}

export interface Caution {
  refused: boolean;
  words: string;
}

export class TimelineState {
  /** Left border and width of what is seen [px], in steps, so that little is drawn anew while it is scrolled. */
  readonly seen = signal<{ left: number; width: number }>({ left: 0, width: 1600 });
  readonly gesture = signal<Gesture | null>(null);
  readonly caution = signal<Caution | null>(null);
  readonly follow = signal(true);
  /** The names' width [px]. */
  readonly names = signal(132);
  /** Entries that somebody changed just now: key, and who. */
  readonly flashes = signal<Map<string, string>>(new Map());
  /** The danced division of the range. */
  readonly danced = signal<Row[]>([]);
  readonly naming = signal<number | null>(null);
  /** The measure (from 0) in which a phrase begins that is being named. */
  readonly phrase = signal<number | null>(null);
  element: HTMLElement | null = null;
  private tried = "";
  private timer = 0;

  readonly rows = computed(() => [...this.studio.rows.value, ...this.danced.value]);
  /** Top of each row, and the end of the last one [px]. */
  readonly tops = computed(() => {
    const tops = [RULER];
    for (const row of this.rows.value) tops.push((tops.at(-1) as number) + heightOf(row));
    return tops;
  });
  /** First and last chunk of the rows that are seen. */
  readonly chunks = computed<[number, number]>(() => {
    const { left, width } = this.seen.value;
    const size = CHUNK * this.studio.scale.value;
    return [Math.floor((left - SCREENS * width) / size), Math.floor((left + (1 + SCREENS) * width) / size)];
  });
  readonly firstChunk = computed(() => this.chunks.value[0]);
  readonly lastChunk = computed(() => this.chunks.value[1]);
  /** How many boxes begin in each chunk. */
  private readonly counts = computed(() => {
    const counts: number[] = [];
    for (const row of this.rows.value) for (const box of row.boxes) {
      const at = Math.floor(box.start / CHUNK);
      counts[at] = (counts[at] ?? 0) + 1;
    }
    return counts;
  });
  /** So many boxes are seen that they are painted, and only the selected ones are elements. */
  readonly dense = computed(() => {
    const [first, last] = this.chunks.value;
    return this.counts.value.slice(Math.max(first, 0), last + 1).reduce((sum, count) => sum + (count ?? 0), 0) > MOST_ELEMENTS;
  });
  readonly ghosts = computed(() => this.ghostsOf(this.gesture.value));

  constructor(readonly studio: Studio) {}

  /** The content's place of a pointer: measures, and the index of the row (-1: the ruler). */
  place(event: { clientX: number; clientY: number }): { x: number; y: number; measure: number; row: number } {
    const border = (this.element as HTMLElement).getBoundingClientRect();
    const x = event.clientX - border.left + (this.element?.scrollLeft ?? 0) - this.names.value;
    const y = event.clientY - border.top + (this.element?.scrollTop ?? 0);
    const inRuler = event.clientY - border.top < RULER;
    return { x, y, measure: Math.max(0, x / this.studio.scale.value), row: inRuler ? -1 : this.rowAt(y) };
  }

  rowAt(y: number): number {
    const tops = this.tops.value;
    let row = 0;
    while (row < tops.length - 2 && y >= (tops[row + 1] as number)) row++;
    return row;
  }

  /** The box at a place of the content. */
  boxAt(place: { x: number; y: number; measure: number; row: number }): Box | undefined {
    const row = this.rows.peek()[place.row];
    if (!row || row.kind === "danced" || row.kind === "curve") return undefined;
    const lane = Math.floor((place.y - (this.tops.peek()[place.row] ?? 0) - 3) / LANE);
    const scale = this.studio.scale.peek();
    return row.boxes.findLast((box) => row.lane.get(box) === lane && place.measure >= box.start && place.measure <= box.start + Math.max(box.length, 5 / scale));
  }

  rowOf(box: { list: string; number: number }): number {
    return this.rows.value.findIndex((row) => row.boxes.some((one) => one.list === box.list && one.number === box.number));
  }

  look(): void {
    const { element } = this;
    if (!element) return;
    const width = element.clientWidth;
    const grid = Math.max(64, SCREENS * 0.5 * width);
    const left = Math.floor(element.scrollLeft / grid) * grid;
    const seen = this.seen.peek();
    if (seen.left !== left || seen.width !== width) this.seen.value = { left, width };
  }

  /** Zoom about a place of the window [px from the left], or the middle. */
  zoom(factor: number, clientX: number | null = null): void {
    const { element, studio } = this;
    const before = studio.scale.peek();
    const after = Math.min(MAX_SCALE, Math.max(MIN_SCALE, before * factor));
    if (!element || after === before) return;
    const left = element.getBoundingClientRect().left + this.names.peek();
    const at = clientX === null ? (element.clientWidth - this.names.peek()) / 2 : clientX - left;
    const measure = (element.scrollLeft + at) / before;
    element.style.setProperty("--px", `${after}px`);
    studio.scale.value = after;
    element.scrollLeft = measure * after - at;
    this.look();
  }

  /** Show measures from side to side. */
  fit(first: number, measures: number): void {
    const { element, studio } = this;
    if (!element) return;
    const scale = Math.min(MAX_SCALE, Math.max(MIN_SCALE, (element.clientWidth - this.names.peek() - 24) / Math.max(measures, 0.5)));
    element.style.setProperty("--px", `${scale}px`);
    studio.scale.value = scale;
    element.scrollLeft = first * scale - 8;
    this.look();
  }

  /** Scroll so that a box is seen. */
  reveal(box: Box): void {
    const { element } = this;
    if (!element) return;
    const scale = this.studio.scale.peek();
    const room = element.clientWidth - this.names.peek();
    const [from, to] = [box.start * scale, (box.start + box.length) * scale];
    if (from < element.scrollLeft || Math.min(to, from + room * 0.8) > element.scrollLeft + room) element.scrollLeft = Math.max(0, from - 0.2 * room);
    const row = this.rowOf(box);
    const [top, end] = [this.tops.peek()[row] ?? 0, this.tops.peek()[row + 1] ?? 0];
    if (top - RULER < element.scrollTop) element.scrollTop = top - RULER;
    else if (end > element.scrollTop + element.clientHeight) element.scrollTop = end - element.clientHeight;
    this.look();
  }

  /** Give a box the focus, when it is there. */
  focus(box: { list: string; number: number }): void {
    requestAnimationFrame(() => this.element?.querySelector<HTMLElement>(`[data-key="${box.list} ${box.number}"]`)?.focus({ preventScroll: true }));
  }

  /** The edits of what is held. */
  editsOf(gesture: Gesture | null): SingleEdit[] {
    const { studio } = this;
    const ground = studio.ground.peek();
    switch (gesture?.kind) {
      case "move":
        return moveEdits(gesture.boxes, gesture.by, (box) => this.whoAfter(gesture, box), gesture.copy, ground);
      case "begin":
      case "end":
        return resizeEdits(gesture.boxes, gesture.by, gesture.kind, ground);
      case "canon":
        return [{ do: "set", at: [gesture.list, gesture.number, "beats_later"], value: gesture.beats || null }];
      case "drop":
        return [{ do: "insert", at: [gesture.list], value: gesture.value }];
      default:
        return [];
    }
  }

  /** The dancers of a box that has been moved by some rows; null: as before. */
  private whoAfter(gesture: { rows: number }, box: Box): string | null {
    if (!gesture.rows || !hasDancers(box.list)) return null;
    return this.rows.peek()[this.rowAfter(gesture, box)]?.selection ?? null;
  }

  private rowAfter(gesture: { rows: number }, box: Box): number {
    const row = this.rowOf(box);
    if (!gesture.rows || !hasDancers(box.list)) return row;
    const places = this.rows.peek().flatMap((one, index) => (one.selection !== null && one.kind !== "danced" ? [index] : []));
    const at = places.indexOf(row);
    return places[Math.min(Math.max(at + gesture.rows, 0), places.length - 1)] ?? row;
  }

  private ghostsOf(gesture: Gesture | null): Ghost[] {
    switch (gesture?.kind) {
      case "move":
        return gesture.boxes.map((box) => {
          const row = this.rowAfter(gesture, box);
          const lane = row === this.rowOf(box) ? (this.rows.peek()[row]?.lane.get(box) ?? 0) : 0;
          return { row, lane, start: box.start + gesture.by, length: box.length, label: box.label };
        });
      case "begin":
      case "end":
        return gesture.boxes.map((box) => {
          const row = this.rowOf(box);
          const start = box.start + (gesture.kind === "begin" ? gesture.by : 0);
          const length = box.length + (gesture.kind === "begin" ? -gesture.by : gesture.by);
          return { row, lane: this.rows.peek()[row]?.lane.get(box) ?? 0, start, length, label: box.label };
        });
      case "canon":
        return [{ row: gesture.row, lane: 0, start: gesture.start + gesture.beats / this.studio.beats.peek(), length: 1, label: `${gesture.beats} ${gesture.beats === 1 ? "beat" : "beats"} later` }];
      case "drop":
        return [{ row: gesture.row, lane: 0, start: gesture.start, length: gesture.length, label: "" }];
      default:
        return [];
    }
  }

  /** Ask what the preview says of what is held; it shows the ways on the stage. */
  ask(): void {
    const gesture = this.gesture.peek();
    const edits = this.editsOf(gesture);
    const said = JSON.stringify(edits);
    if (said === this.tried) return;
    this.tried = said;
    this.caution.value = null;
    clearTimeout(this.timer);
    if (!edits.length) return;
    if (isPlanned(edits)) void this.askNow(edits, said);
    else this.timer = window.setTimeout(() => void this.askNow(edits, said), TRY_WAIT_MS);
  }

  private async askNow(edits: SingleEdit[], said: string): Promise<void> {
    const ghosts = this.ghosts.peek();
    if (!ghosts.length) return;
    const first = Math.max(0, Math.floor(Math.min(...ghosts.map((ghost) => ghost.start))));
    const last = Math.ceil(Math.max(...ghosts.map((ghost) => ghost.start + Math.max(ghost.length, 1))));
    const { from, to, led } = reached(this.studio.score.peek(), first, Math.min(last - first, MOST_TRIED));
    const list = edits.length === 1 ? edits : [{ do: "together" as const, edits }];
    const answer = await this.studio.preview.ask({ from, to, ...asLed(led), with: list, positions: "none", planned: isPlanned(edits), notes: true }, "timeline", true);
    if (answer.replaced || said !== this.tried || !this.gesture.peek()) return;
    const told = answer.texts["notes"] as { answers?: { refused?: { what: string; remedy?: string }[] }[]; notes?: { what: string }[]; meetings?: unknown[]; too_far?: { dancer: number; measure: number }[] } | undefined;
    const faults = answer.refused ?? told?.answers?.flatMap((one) => one.refused ?? []) ?? [];
    const [fault] = faults;
    if (fault) {
      this.caution.value = { refused: true, words: `${fault.what}${fault.remedy ? ` – ${fault.remedy}` : ""}` };
      return;
    }
    const far = new Set(told?.too_far?.map((one) => one.dancer) ?? []).size;
    const near = told?.meetings?.length ?? 0;
    const known = new Set(this.studio.doc.doubts.peek().map((doubt) => doubt.what));
    const fresh = told?.notes?.find((doubt) => !known.has(doubt.what));
    const words = [fresh?.what ?? "", far ? `${far} cannot get there in time: make it longer, or record a longer step` : "", near ? `${near} ${near === 1 ? "pair comes" : "pairs come"} too near` : ""];
    this.caution.value = words.some(Boolean) ? { refused: false, words: words.filter(Boolean).join("; ") } : null;
    this.studio.dragAnswer.value = answer;
  }

  /** Let go: send the edits, or forget them. */
  async end(commit: boolean): Promise<void> {
    const gesture = this.gesture.peek();
    const edits = commit ? this.editsOf(gesture) : [];
    clearTimeout(this.timer);
    this.tried = "";
    this.gesture.value = null;
    this.caution.value = null;
    if (edits.length) await this.studio.doc.edits(edits);
    else this.studio.dragAnswer.value = null;
  }
}

function isPlanned(edits: SingleEdit[]): boolean {
  return !edits.some((one) => STEP_LISTS.includes(String(one.at[0])));
}

export function heightOf(row: Row): number {
  return row.kind === "curve" ? CURVE : row.lanes * LANE + ROW_MARGIN;
}

const states = new WeakMap<Studio, TimelineState>();

export function timelineOf(studio: Studio): TimelineState {
  const found = states.get(studio) ?? new TimelineState(studio);
  states.set(studio, found);
  return found;
}
