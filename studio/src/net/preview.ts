// Questions to the second engine: any measures, as written or with edits that are only tried (`live docs preview`).
import { signal } from "@preact/signals";
import { Link } from "./link";
import { DOCUMENT, frameKind, JOINTS, POSITIONS, readDocument, readJoints, readPositions, readWaveform, WAVEFORM, type Joints, type Positions, type Waveform } from "./frames";
import type { Edit, Fault } from "../model/document";

export interface Moment {
  tick: number;
  measure: number;
  time_s: number;
  steps?: string[];
}

export interface PreviewAnswer {
  moments: Moment[];
  positions: Positions[];
  joints: Joints | null;
  waveform: Waveform | null;
  /** A PDF. */
  document: Blob | null;
  /** All frames of joints, in order. */
  motions: Joints[];
  /** All other text frames, by kind. */
  texts: Record<string, Record<string, unknown>>;
  refused: Fault[] | null;
  replaced: boolean;
}

export interface Question {
  from?: number;
  to?: number;
  measure?: number;
  segment?: number;
  with?: Edit[];
  positions?: "measures" | "samples" | "none";
  joints?: boolean | number[];
  ways?: boolean;
  notes?: boolean;
  division?: boolean;
  planned?: boolean;
  [more: string]: unknown;
}

interface Asked {
  id: number;
  topic: string;
  question: Question;
  answer: PreviewAnswer;
  resolve: (answer: PreviewAnswer) => void;
}

/** One question at a time. A newer one of the same topic replaces one that waits; those of other topics have their turns. */
export class Preview {
  /** How many measures are simulated, while an answer takes long; null: none does. */
  readonly progress = signal<number | null>(null);
  private readonly link: Link;
  private count = 0;
  private present: Asked | null = null;
  private waiting: Asked[] = [];
  private opened = false;

  constructor(key: string) {
    this.link = new Link("/studio/preview", key);
    this.link.onOpen = () => {
      if (this.present) this.link.send({ ...this.present.question, id: this.present.id }); // once more: it was lost
    };
    this.link.onText = (told) => this.takeText(told);
    this.link.onBinary = (data) => this.takeBinary(data);
  }

  /** Ask; an urgent question interrupts what another topic has asked, which is asked again after it. */
  ask(question: Question, topic = "", urgent = false): Promise<PreviewAnswer> {
    if (!this.opened) {
      this.opened = true;
      this.link.open();
    }
    for (const old of this.waiting.filter((one) => one.topic === topic)) {
      old.answer.replaced = true;
      old.resolve(old.answer);
    }
    this.waiting = this.waiting.filter((one) => one.topic !== topic);
    return new Promise((resolve) => {
      const asked = { id: ++this.count, topic, question, resolve, answer: emptyAnswer() };
      if (urgent) this.waiting.unshift(asked);
      else this.waiting.push(asked);
      if (urgent && this.present && this.present.topic !== topic) {
        this.waiting.splice(1, 0, { ...this.present, id: ++this.count, answer: emptyAnswer() });
        this.present = null; // the engine ends the former question when it gets this one
      }
      this.next();
    });
  }

  private next(): void {
    const asked = this.present ? undefined : this.waiting.shift();
    if (!asked) return;
    this.present = asked;
    this.link.send({ ...asked.question, id: asked.id });
  }

  private takeText(told: Record<string, unknown>): void {
    const { present } = this;
    if (!present) return;
    const kind = String(told["kind"]);
    if (told["id"] !== undefined && told["id"] !== present.id) return;
    if (kind === "progress") {
      this.progress.value = Number(told["measures"]);
      return;
    }
    if (kind === "moments") present.answer.moments = told["moments"] as Moment[];
    else if (kind === "refused") present.answer.refused = told["refused"] as Fault[];
    else if (kind === "replaced") present.answer.replaced = true;
    else if (kind === "dancers") [present.answer.positions, present.answer.motions] = [[], []]; // an answer begins
    else if (kind === "motion") present.answer.motions = [];
    present.answer.texts[kind] = told;
    if (kind === "done" || kind === "refused" || kind === "replaced") {
      this.present = null;
      this.progress.value = null;
      present.resolve(present.answer);
      this.next();
    }
  }

  private takeBinary(data: DataView): void {
    if (!this.present) return;
    const kind = frameKind(data);
    if (kind === POSITIONS) this.present.answer.positions.push(readPositions(data));
    else if (kind === JOINTS) this.present.answer.motions.push((this.present.answer.joints = readJoints(data)));
    else if (kind === DOCUMENT) this.present.answer.document = readDocument(data);
    else if (kind === WAVEFORM) this.present.answer.waveform = readWaveform(data);
  }
}

function emptyAnswer(): PreviewAnswer {
  return { moments: [], positions: [], joints: null, waveform: null, document: null, motions: [], texts: {}, refused: null, replaced: false };
}
