// The show that all pages edit: its structure, edits that are sent and answered, and undo.
import { computed, effect, signal } from "@preact/signals";
import { Link } from "../net/link";
import { frameKind, JOINTS, PICTURE, POSITIONS, readJoints, readPicture, readPositions, type Joints, type Positions, type ProjectedPicture } from "../net/frames";
import { NOTHING, type Launches, type Pad, type Page } from "./pads";
import { applyChange, type Change, type Structure } from "./score";

export interface Clock {
  time: number;
  measure: number;
  beat: number;
  bpm: number;
  section: string | null;
  score_measure: number;
  source: string;
  /** The most likely other measure line: how many beats later, and its share. */
  runner_up: [number, number];
  /** Whether the operator is asked about it. */
  asks: boolean;
  elements: StageElement[];
  late_frames: number;
  frame_ms: number;
}

export interface StageElement {
  kind: string;
  at: [number, number];
  radius: number;
  strength: number;
  level: number;
  from: number | null;
  to: number | null;
}

export interface Person {
  name: string;
  /** Numbers, from 1, by the list of the score, or "dancer". */
  selected: Record<string, number[]>;
}

export interface Fault {
  what: string;
  remedy?: string;
  file?: string;
  line?: number | null;
  field?: string;
  measure?: number | null;
  dancers?: string | null;
}

export interface Ways {
  from: number;
  to: number;
  dancers: number[];
  /** Of each dancer the places (x, z) [m], 32 in each measure. */
  ways: [number, number][][];
  segment: number | null;
}

export interface Answer {
  id: string;
  revision?: number;
  refused?: Fault[];
  waits?: string[];
  notes?: Fault[];
}

export type SingleEdit = { do: "insert" | "change" | "move" | "resize" | "copy" | "delete" | "rename" | "set"; at: (string | number)[]; value?: unknown };
/** An edit, or several that are one. */
export type Edit = SingleEdit | { do: "together"; edits: SingleEdit[] };

export interface Notice {
  id: number;
  tone: "refused" | "told";
  title: string;
  faults: Fault[];
}

/** An edit that has no answer yet. */
interface WaitingEdit {
  id: string;
  edit: Edit;
  /** The revision that its sender saw. */
  base: number | null;
  /** Whether it has left this page. */
  sent: boolean;
}

const MOST_NOTICES = 4;
const ANSWER_WAIT = 65_000;

/** Presses of keys that wait for the answers to earlier ones; more are left out. */
const MOST_TURNS = 32;

/** One show, seen through its stream. */
export class ShowDocument {
  readonly structure = signal<Structure | null>(null);
  readonly clock = signal<Clock | null>(null);
  readonly positions = signal<Positions | null>(null);
  readonly joints = signal<Joints | null>(null);
  /** The picture as it is projected; null: none yet. */
  readonly picture = signal<ProjectedPicture | null>(null);
  readonly people = signal<Person[]>([]);
  /** The pads of each page, in order; null until they are told. */
  readonly pads = signal<Record<Page, Pad[]> | null>(null);
  /** What waits, runs and cannot follow. */
  readonly launches = signal<Launches>(NOTHING);
  readonly doubts = signal<{ measure: number | null; what: string }[]>([]);
  readonly notices = signal<Notice[]>([]);
  readonly lastChange = signal<Change | null>(null);
  /** Edits that wait for their answers, in order. */
  readonly waiting = signal<WaitingEdit[]>([]);
  readonly link: Link;
  readonly revision = computed(() => this.structure.value?.revision ?? 0);
  private wants: Record<string, unknown> = { positions: 30, clock: 10, joints: 0, notes: true };
  private answers = new Map<string, (answer: Answer) => void>();
  /** Answers whose change has not come yet. */
  private early: Answer[] = [];
  private count = 0;
  private noticeCount = 0;
  /** Whether there is a new connection, whose structure has not come yet. */
  private opened = false;
  private turns: Promise<void> = Promise.resolve();
  private turnsWait = 0;
  private page = Math.random().toString(36).slice(2, 8);

  constructor(key: string, readonly by: string) {
    this.link = new Link("/studio/stream", key);
    this.link.onOpen = () => {
      this.link.send({ ...this.wants, name: by });
      this.opened = true;
    };
    this.link.onText = (told) => this.take(told);
    this.link.onBinary = (data) => {
      const kind = frameKind(data);
      if (kind === POSITIONS) this.positions.value = { ...readPositions(data) };
      else if (kind === JOINTS) this.joints.value = readJoints(data);
      else if (kind === PICTURE) this.picture.value = readPicture(data);
    };
  }

  /** Say what this page wants to see; see `live docs web`. */
  want(wants: Record<string, unknown>): void {
    this.wants = { ...this.wants, ...wants };
    this.link.send(wants);
  }

  /** Send an edit; the promise is kept with the engine's answer. A refusal is told as a notice, too. */
  edit(edit: Edit, quiet = false): Promise<Answer> {
    const id = `${this.page} ${++this.count}`;
    const mine: WaitingEdit = { id, edit, base: this.revision.value || null, sent: false };
    this.waiting.value = [...this.waiting.value, mine];
    return this.asked(id, () => this.sendEdit(mine), quiet);
  }

  /** Send edits that are one: all are taken or none, and one undo takes them back. */
  edits(list: SingleEdit[], quiet = false): Promise<Answer> {
    if (!list.length) return Promise.resolve({ id: "" });
    if (list.length === 1) return this.edit(list[0] as SingleEdit, quiet);
    return this.edit({ do: "together", edits: list }, quiet);
  }

  /** Do something that begins from the show as it is, after all that was sent before is answered and known here: a key
   * that is held down moves a box step by step, also on a slow connection. */
  inTurn(act: () => void): void {
    if (this.turnsWait >= MOST_TURNS) return;
    this.turnsWait++;
    this.turns = this.turns.then(() => this.settled()).then(() => {
      this.turnsWait--;
      act();
    });
  }

  private settled(): Promise<void> {
    if (!this.waiting.value.length) return Promise.resolve();
    return new Promise((resolve) => {
      const stop = effect(() => {
        if (!this.waiting.value.length) {
          resolve();
          queueMicrotask(() => stop());
        }
      });
    });
  }

  undo(): Promise<Answer> {
    return this.back("undo");
  }

  redo(): Promise<Answer> {
    return this.back("redo");
  }

  tell(tone: Notice["tone"], title: string, faults: Fault[] = []): void {
    const notice = { id: ++this.noticeCount, tone, title, faults };
    this.notices.value = [...this.notices.value, notice].slice(-MOST_NOTICES);
  }

  dismiss(id: number): void {
    this.notices.value = this.notices.value.filter((notice) => notice.id !== id);
  }

  private back(word: "undo" | "redo"): Promise<Answer> {
    const id = `${this.page} ${++this.count}`;
    return this.asked(id, () => this.link.send({ do: word, id, by: this.by }), false);
  }

  private sendEdit(mine: WaitingEdit): boolean {
    const { id, edit, base } = mine;
    if (this.opened) return false; // it is sent with the structure
    const said = edit.do === "together" ? edit : { ...edit, value: edit.value ?? null };
    mine.sent = this.link.send({ ...said, id, by: this.by, base });
    return mine.sent;
  }

  /** After a lost connection: send what was not taken once more; tell where that is not known. */
  private sendAgain(revision: number): void {
    this.opened = false;
    for (const mine of this.waiting.value) {
      if (!mine.sent || mine.base === revision) this.sendEdit(mine);
      else {
        const what = "the connection was lost while this was sent, and the show has changed since";
        this.answered({ id: mine.id, refused: [{ what, remedy: "look whether it was taken, and repeat it if not" }] }, false);
      }
    }
  }

  private asked(id: string, send: () => boolean, quiet: boolean): Promise<Answer> {
    return new Promise((resolve) => {
      const timer = window.setTimeout(() => this.answered({ id, refused: [{ what: "the engine did not answer" }] }, quiet), ANSWER_WAIT);
      this.answers.set(id, (answer) => {
        clearTimeout(timer);
        resolve(answer);
        if (answer.refused && !quiet) this.tell("refused", "Not changed", answer.refused);
        if (answer.notes?.length) this.tell("told", "What no longer fits", answer.notes);
        if (answer.waits?.length) this.tell("told", `From the next start on: ${answer.waits.join(", ")}`);
      });
      send();
    });
  }

  private answered(answer: Answer, _quiet: boolean): void {
    this.waiting.value = this.waiting.value.filter((one) => one.id !== answer.id);
    const how = this.answers.get(answer.id);
    this.answers.delete(answer.id);
    how?.(answer);
  }

  /** Keep what edits promised once this page has what they changed: an answer may come before the change. */
  private answerEarly(): void {
    const ready = this.early.filter((one) => (one.revision ?? 0) <= this.revision.value);
    this.early = this.early.filter((one) => !ready.includes(one));
    for (const answer of ready) this.answered(answer, false);
  }

  private take(told: Record<string, unknown>): void {
    switch (told["kind"]) {
      case "structure":
        this.structure.value = told as unknown as Structure;
        this.answerEarly();
        if (this.opened) this.sendAgain(this.revision.value);
        break;
      case "change": {
        const change = told as unknown as Change;
        const before = this.structure.value;
        const after = before && applyChange(before, change);
        if (after) this.structure.value = after;
        this.lastChange.value = change;
        this.answerEarly();
        break;
      }
      case "replacement":
        this.lastChange.value = told as unknown as Change;
        break;
      case "clock":
        this.clock.value = told as unknown as Clock;
        break;
      case "notes":
        this.doubts.value = (told["notes"] as { measure: number | null; what: string }[]) ?? [];
        break;
      case "pads":
        this.pads.value = told["pads"] as Record<Page, Pad[]>;
        break;
      case "launches":
        this.launches.value = told as unknown as Launches;
        break;
      case "people":
        this.people.value = (told["people"] as Person[]) ?? [];
        break;
      case "answer": {
        const answer = told as unknown as Answer;
        if ((answer.revision ?? 0) > this.revision.value) this.early.push(answer);
        else this.answered(answer, false);
        break;
      }
      case "refused":
        this.tell("refused", String(told["refused"]));
        break;
    }
  }
}
