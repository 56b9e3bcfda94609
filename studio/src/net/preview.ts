// Questions to the second engine: any measures, as written or with edits that are only tried (docs/web.md).
import { Link } from "./link";
import { frameKind, JOINTS, POSITIONS, readJoints, readPositions, type Joints, type Positions } from "./frames";
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
  [more: string]: unknown;
}

/** One question at a time: a newer one replaces one that is not answered yet. */
export class Preview {
  private readonly link: Link;
  private count = 0;
  private present: { id: number; answer: PreviewAnswer; resolve: (answer: PreviewAnswer) => void } | null = null;
  private unsent: object | null = null;
  private opened = false;
  /** Called while measures are simulated, with their number. */
  onProgress: (measures: number) => void = () => {};

  constructor(key: string) {
    this.link = new Link("/studio/preview", key);
    this.link.onOpen = () => {
      if (this.unsent) this.link.send(this.unsent);
    };
    this.link.onText = (told) => this.takeText(told);
    this.link.onBinary = (data) => this.takeBinary(data);
  }

  ask(question: Question): Promise<PreviewAnswer> {
    if (!this.opened) {
      this.opened = true;
      this.link.open();
    }
    if (this.present) {
      this.present.answer.replaced = true;
      this.present.resolve(this.present.answer);
    }
    const id = ++this.count;
    this.unsent = { ...question, id };
    return new Promise((resolve) => {
      this.present = { id, resolve, answer: { moments: [], positions: [], joints: null, texts: {}, refused: null, replaced: false } };
      this.link.send(this.unsent);
    });
  }

  private takeText(told: Record<string, unknown>): void {
    const { present } = this;
    if (!present) return;
    const kind = String(told["kind"]);
    if (kind === "progress") {
      this.onProgress(Number(told["measures"]));
      return;
    }
    if (told["id"] !== undefined && told["id"] !== present.id) return;
    if (kind === "moments") present.answer.moments = told["moments"] as Moment[];
    else if (kind === "refused") present.answer.refused = told["refused"] as Fault[];
    else if (kind === "replaced") present.answer.replaced = true;
    present.answer.texts[kind] = told;
    if (kind === "done" || kind === "refused" || kind === "replaced") {
      this.present = null;
      this.unsent = null;
      present.resolve(present.answer);
    }
  }

  private takeBinary(data: DataView): void {
    if (!this.present) return;
    const kind = frameKind(data);
    if (kind === POSITIONS) this.present.answer.positions.push(readPositions(data));
    else if (kind === JOINTS) this.present.answer.joints = readJoints(data);
  }
}
