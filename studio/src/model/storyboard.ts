// The storyboard: a picture for each moment at which somebody arrives, in the order of the score.
import { allBoxes, sectionSpans, stageSize, type Box } from "./plan";
import { dancedMeasure, reached } from "./danced";
import { wordsOfDancers } from "./form";
import type { Structure } from "./score";
import type { PreviewAnswer } from "../net/preview";

/** Measures of one question: pictures come while the rest is simulated. */
const MOST_MEASURES = 16;
const MOST_PICTURES = 400;
const MOVES = ["segment", "element"];

export interface Picture {
  /** Measures of the written score, from 0: where it begins, and where all have arrived. */
  first: number;
  last: number;
  section: string;
  boxes: Box[];
  /** The danced measure (from 1) at whose line it is taken; in a led storyboard, as it is written. */
  danced: number;
}

export interface Taken {
  /** x, z [m] and heading [rad] of each dancer. */
  rows: Float32Array;
  present: Uint8Array;
  steps: string[];
}

/** Whether the storyboard shows the score as somebody dances it who leads: some of it comes only then. */
export function isLed(structure: Structure): boolean {
  return allBoxes(structure).some((box) => MOVES.includes(box.list) && dancedMeasure(structure.score, Math.floor(box.start)) === null);
}

/** The pictures of a score: where it begins, and after each formation or way. */
export function pictures(structure: Structure): Picture[] {
  const moves = allBoxes(structure).filter((box) => MOVES.includes(box.list));
  const led = isLed(structure);
  const spans = sectionSpans(structure.score);
  const section = (measure: number): string => spans.find((span) => measure >= span.first && measure < span.first + span.measures)?.name ?? "";
  const found = new Map<number, Picture>();
  found.set(0, { first: 0, last: 0, section: section(0), boxes: [], danced: 1 });
  for (const box of [...moves].sort((a, b) => a.start + a.length - b.start - b.length)) {
    const first = Math.floor(box.start);
    const last = Math.ceil(box.start + box.length);
    if (last <= first) continue;
    const danced = led ? first + 1 : reached(structure.score, first).from;
    const known = found.get(last);
    if (known) {
      known.boxes.push(box);
      known.first = Math.min(known.first, first);
    } else found.set(last, { first, last, section: section(first), boxes: [box], danced: danced + last - first });
  }
  return [...found.values()].sort((a, b) => a.last - b.last).slice(0, MOST_PICTURES);
}

/** Questions to the preview that reach all pictures: of at most 16 measures each. */
export function ranges(all: Picture[]): [number, number][] {
  const wanted = [...new Set(all.map((picture) => picture.danced))].sort((a, b) => a - b);
  const found: [number, number][] = [];
  for (const measure of wanted) {
    const open = found.at(-1);
    if (open && measure - open[0] < MOST_MEASURES) open[1] = measure;
    else found.push([measure, measure]);
  }
  return found;
}

/** Where everybody stands at each danced measure line of an answer. */
export function takenAt(answer: PreviewAnswer): Map<number, Taken> {
  const found = new Map<number, Taken>();
  answer.moments.forEach((moment, index) => {
    const positions = answer.positions[index];
    const measure = Math.round(moment.measure);
    if (positions && !found.has(measure)) found.set(measure, { rows: positions.rows, present: positions.present, steps: moment.steps ?? [] });
  });
  return found;
}

/** "measures 5 to 8" of a picture, as people count. */
export function measuresText(picture: Picture): string {
  if (picture.last === 0) return "beginning";
  return picture.last - picture.first === 1 ? `measure ${picture.last}` : `measures ${picture.first + 1} to ${picture.last}`;
}

export function title(picture: Picture): string {
  return [...new Set(picture.boxes.map((box) => box.label + (box.group && box.group.trim() !== "*" ? ` (${wordsOfDancers(box.group)})` : "")))].join(", ") || "All begin here";
}

/** A place on the stage in a dancer's words: "1.2 m left, 0.5 m in front of the middle", as the public sees it. */
export function placeText(x: number, z: number, structure: Structure): string {
  const { width, depth } = stageSize(structure.score);
  const near = 0.15;
  const side = Math.abs(x) < near ? "on the centre line" : `${Math.abs(x).toFixed(1)} m ${x < 0 ? "left" : "right"}`;
  const along = Math.abs(z) < near ? "halfway back" : `${Math.abs(z).toFixed(1)} m ${z > 0 ? "in front" : "behind"}`;
  const edge = Math.min(width / 2 - Math.abs(x), depth / 2 - Math.abs(z));
  return `${side}, ${along}${edge < 0.4 ? ", at the edge" : ""}`;
}

/** The nearest others at each side of a dancer, as the public sees them: who stands left and right. */
export function neighbours(taken: Taken, dancer: number): { left: number | null; right: number | null } {
  const at = (row: number): [number, number] => [taken.rows[3 * row] ?? 0, taken.rows[3 * row + 1] ?? 0];
  const [x, z] = at(dancer - 1);
  const best = { left: [Infinity, null] as [number, number | null], right: [Infinity, null] as [number, number | null] };
  for (let row = 0; row < taken.present.length; row++) {
    if (row === dancer - 1 || !taken.present[row]) continue;
    const [ox, oz] = at(row);
    const away = Math.hypot(ox - x, oz - z);
    const side = ox < x ? "left" : "right";
    if (Math.abs(oz - z) < Math.max(1, Math.abs(ox - x)) && away < best[side][0]) best[side] = [away, row + 1];
  }
  return { left: best.left[1], right: best.right[1] };
}
