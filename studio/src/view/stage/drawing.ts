// What the pointer does on the floor: selecting dancers, drawing lines, putting elements.
import { signal } from "@preact/signals";
import { distance, isClosed, isWithin, simplified, type Place } from "../../model/geometry";
import { drawnFrom, hideDrawn, showDrawn } from "../../model/drawn";
import { elementEntry, liveCall } from "../../model/stage_edits";
import { reached } from "../../model/danced";
import type { Studio } from "../../model/studio";
import type { StageState, Tool } from "../../model/stage_state";
import { placeIn } from "./paint_marks";
import type { Sketch } from "./paint";

const GRAB_M = 0.4;
/** A press that moves less than this is a click [m]. */
const STILL_M = 0.15;
const ELEMENT_TOOLS: Tool[] = ["attract", "repel", "spread", "cross"];

export function isElementTool(tool: Tool): boolean {
  return ELEMENT_TOOLS.includes(tool);
}

export function isDrawingTool(tool: Tool): boolean {
  return ["line", "curve", "shape"].includes(tool);
}

/** Turns presses on the floor into selections, strokes and elements. */
export class Drawing {
  readonly sketch = signal<Sketch | null>(null);
  /** Where the keyboard's pen stands; null: the keyboard chooses dancers. */
  readonly pen = signal<Place | null>(null);
  private begun: Place | null = null;
  private more = false;
  private outline = false;
  private pressed = false;

  constructor(private readonly studio: Studio, private readonly stage: StageState) {}

  down(place: Place, more: boolean, outline: boolean): void {
    const tool = this.stage.tool.value;
    this.pressed = true;
    this.begun = place;
    this.more = more;
    this.outline = outline || tool === "lasso";
    if (tool === "select" || tool === "lasso") {
      if (this.nearest(place) && !this.outline) {
        this.choose(place, more);
        this.begun = null;
      } else this.sketch.value = { points: [place], closed: this.outline, kind: "select" };
    } else if (tool === "line") this.addPoint(place);
    else this.sketch.value = { points: [place], closed: tool === "shape", kind: "line" };
  }

  move(place: Place): void {
    const { sketch, begun } = this;
    const now = sketch.value;
    if (!this.pressed || !begun || !now) return;
    const tool = this.stage.tool.value;
    if (now.kind === "select" && !this.outline) {
      sketch.value = { ...now, closed: true, points: [begun, [place[0], begun[1]], place, [begun[0], place[1]]] };
    } else if (tool === "line" || tool === "cross") {
      const kept = tool === "cross" ? [begun] : now.points.slice(0, this.lineBegun);
      sketch.value = { ...now, points: distance(place, begun) > STILL_M ? [...kept, place] : kept };
    } else if (distance(now.points.at(-1) as Place, place) > 0.03) {
      sketch.value = { ...now, points: [...now.points, place] };
    }
    this.show();
  }

  /** What the line would become as it is now; an answer on its way is waited for. */
  private show(): void {
    const now = this.sketch.value;
    const tool = this.stage.tool.value;
    if (!now || now.kind !== "line" || now.points.length < 2 || isElementTool(tool)) return;
    const closed = tool === "shape" || (tool === "curve" && isClosed(now.points));
    if (closed && now.points.length < 4) return;
    showDrawn(this.stage, drawnFrom(this.stage, { points: now.points, closed }));
  }

  up(place: Place): void {
    const { begun } = this;
    const now = this.sketch.value;
    const tool = this.stage.tool.value;
    if (!this.pressed) return;
    this.pressed = false;
    this.begun = null;
    if (!begun || !now) return;
    if (now.kind === "select") {
      this.sketch.value = null;
      if (now.points.length < 3 || now.points.every((one) => distance(one, begun) < STILL_M)) {
        this.choose(begun, this.more || (tool === "lasso" && this.nearest(begun) > 0)); // a finger has no Shift key
      } else this.chooseWithin(now.points);
    } else if (isElementTool(tool)) {
      this.sketch.value = null;
      void this.put(tool, tool === "cross" ? [begun, distance(begun, place) > STILL_M ? place : [begun[0], begun[1] + 2]] : [begun]);
    } else if (tool === "line") {
      if (distance(begun, place) > STILL_M && now.points.length === 2) this.finish();
      else this.lineBegun = now.points.length;
    } else this.finish();
  }

  cancel(): void {
    if (this.sketch.value?.kind === "line") hideDrawn(this.stage);
    this.sketch.value = null;
    this.begun = null;
    this.pressed = false;
    this.lineBegun = 0;
  }

  private lineBegun = 0;

  /** Add a point to a line that is drawn by clicks, or by keyboard. */
  addPoint(place: Place): void {
    const former = this.sketch.value?.kind === "line" ? this.sketch.value.points : [];
    const points = former.length && distance(former.at(-1) as Place, place) < 0.02 ? former : [...former, place];
    this.lineBegun = points.length;
    this.sketch.value = { points, closed: this.stage.tool.value === "shape", kind: "line" };
    this.show();
  }

  removePoint(): void {
    const now = this.sketch.value;
    if (!now) return;
    const points = now.points.slice(0, -1);
    this.lineBegun = points.length;
    this.sketch.value = points.length ? { ...now, points } : null;
  }

  /** The line is drawn: ask what becomes of it. */
  finish(): void {
    const now = this.sketch.value;
    const tool = this.stage.tool.value;
    this.cancel();
    if (!now || now.points.length < 2) return;
    const closed = tool === "shape" || (tool === "curve" && isClosed(now.points));
    this.stage.stroke.value = { points: tool === "line" ? now.points : simplified(now.points, 0.03), closed };
  }

  /** Put an element: live at once, else into the score at the cursor, and play its measures. */
  async put(kind: Tool, points: Place[]): Promise<void> {
    const { stage, studio } = this;
    const measures = stage.measures.value;
    if (stage.live.value) {
      stage.call(...liveCall(kind, points, stage.strength.value, measures, studio.whom.value));
      return;
    }
    const start = stage.here();
    const value = elementEntry(studio.score.value, kind, points, start, measures, stage.strength.value, studio.whom.value);
    const taken = await stage.send([{ do: "insert", at: ["element"], value }]);
    if (!taken) return;
    await stage.play(reached(studio.score.value, start, measures));
  }

  nearest([x, z]: Place): number {
    const positions = this.stage.shown.value;
    let found = 0;
    let least = GRAB_M;
    for (let dancer = 1; dancer <= (positions?.count ?? 0); dancer++) {
      if (!positions?.present[dancer - 1]) continue;
      const away = distance(placeIn(positions, dancer), [x, z]);
      if (away < least) [found, least] = [dancer, away];
    }
    return found;
  }

  choose(place: Place, more: boolean): void {
    const dancer = this.nearest(place);
    if (dancer) {
      this.stage.focus.value = dancer;
      this.toggle(dancer, more);
    } else if (!more) this.studio.dancers.value = [];
  }

  toggle(dancer: number, more: boolean): void {
    const known = this.studio.dancers.value;
    if (!more) this.studio.dancers.value = [dancer];
    else this.studio.dancers.value = known.includes(dancer) ? known.filter((one) => one !== dancer) : [...known, dancer].sort((a, b) => a - b);
  }

  private chooseWithin(outline: Place[]): void {
    const positions = this.stage.shown.value;
    if (!positions) return;
    const found: number[] = [];
    for (let dancer = 1; dancer <= positions.count; dancer++) if (positions.present[dancer - 1] && isWithin(placeIn(positions, dancer), outline)) found.push(dancer);
    this.studio.dancers.value = this.more ? [...new Set([...this.studio.dancers.value, ...found])].sort((a, b) => a - b) : found;
  }
}
