// What becomes of lines, places and elements that are put on the stage: edits of the document, and calls that act now.
import type { SingleEdit } from "./document";
import { roundPlace, simplified, type Place } from "./geometry";
import { placeInScore } from "./danced";
import { bendEdits, drawnGround, type Material } from "./material";
import { entries, text, type Entry, type Score } from "./score";
import type { Value } from "../net/values";

export type Becomes = "formation" | "way" | "flow" | "path" | "attract" | "bend";

export interface Drawn {
  becomes: Becomes;
  points: Place[];
  closed: boolean;
  /** Written measure, from 0. */
  start: number;
  measures: number;
  group: string;
  name: string;
  inside: boolean;
  pattern: string;
  /** How many: as many as there are dancers, a number, or by density [1/m²] or spacing [m]. */
  many: "dancers" | "count" | "density" | "spacing";
  amount: number;
  mirror: "" | "left-right" | "front-back";
  keep: "" | "left" | "right" | "front" | "back";
  singleFile: boolean;
  strength: number;
  /** What is bent into it, or along it. */
  material: Material | null;
}

const MOST_CHARACTERS = 240;

/** A name that no formation has: "drawn 1", "drawn 2", … */
export function freeName(score: Score, word: string): string {
  const known = new Set(entries(score, "formation").map((one) => text(one, "name").toLowerCase()));
  let number = 1;
  while (known.has(`${word} ${number}`)) number++;
  return `${word} ${number}`;
}

/** The table of a drawn formation. */
export function drawnFormation(drawn: Drawn): Entry {
  const table: Entry = { name: drawn.name, shape: "polyline", points: simplified(drawn.points).map(roundPlace) };
  if (drawn.closed) table["closed"] = true;
  if (drawn.closed && drawn.inside) table["dancers"] = "inside";
  if (drawn.pattern && drawn.inside) table["pattern"] = drawn.pattern;
  if (drawn.many !== "dancers") table[drawn.many] = drawn.many === "count" ? Math.round(drawn.amount) : drawn.amount;
  if (drawn.mirror) {
    table["mirror"] = drawn.mirror;
    if (drawn.keep) table["mirror_keep"] = drawn.keep;
  }
  return table;
}

/** The edits that put a drawn line into the score. */
export function drawnEdits(score: Score, drawn: Drawn): SingleEdit[] {
  const place = { ...placeInScore(score, drawn.start), measures: drawn.measures };
  const group = drawn.group && drawn.group !== "*" ? { group: drawn.group } : {};
  const points = simplified(drawn.points).map(roundPlace);
  switch (drawn.becomes) {
    case "formation":
      return [
        { do: "insert", at: ["formation"], value: drawnFormation(drawn) },
        { do: "insert", at: ["segment"], value: { ...place, ...group, formation: drawn.name } },
      ];
    case "bend":
      return drawn.material ? bendEdits(score, drawn.material, drawnGround(drawn.points, drawn.closed), drawn) : [];
    case "way":
      return [{ do: "insert", at: ["segment"], value: { ...place, ...group, path: points, ...(drawn.singleFile ? { single_file: true } : {}) } }];
    default: {
      const kind = drawn.becomes;
      const value = { kind, ...place, ...group, points, strength: drawn.strength, ...(drawn.closed ? { closed: true } : {}), ...(kind === "flow" ? { flow: "drawn" } : {}) };
      return [{ do: "insert", at: ["element"], value }];
    }
  }
}

/** A drawn line in the words of a live call, with as many points as it takes. */
export function pointsInWords(points: Place[]): string {
  for (let most = 64; ; most = Math.floor(most * 0.75)) {
    const words = simplified(points, 0.05, most).map(([x, z]) => `${x.toFixed(1)} ${z.toFixed(1)}`).join(", ");
    if (words.length <= MOST_CHARACTERS || most <= 2) return words;
  }
}

/** The call that makes an element act now. */
export function liveCall(kind: string, points: Place[], strength: number, measures: number, group: string): [string, ...Value[]] {
  const a: Place = points[0] ?? [0, 0];
  const b: Place = points.at(-1) ?? [0, 0];
  switch (kind) {
    case "spread":
      return ["/dance/spread", measures, group];
    case "cross":
      return ["/dance/cross", a[0], a[1], b[0], b[1], strength, measures, group];
    case "flow":
      return ["/dance/flow/drawn", pointsInWords(points), strength, measures, group];
    case "path":
      return ["/dance/path", pointsInWords(points), strength, measures, group];
    default:
      if (points.length > 1) return [`/dance/${kind}/drawn`, pointsInWords(points), strength, measures, group];
      return [`/dance/${kind}`, a[0], a[1], strength, measures, group];
  }
}

/** An element that is put with a tool: a point, or a bar from one point to the other. */
export function elementEntry(score: Score, kind: string, points: Place[], start: number, measures: number, strength: number, group: string): Entry {
  const a: Place = points[0] ?? [0, 0];
  const b = points.at(-1);
  return {
    kind, ...placeInScore(score, start), measures,
    ...(kind === "spread" ? {} : { at: roundPlace(a) }),
    ...(kind === "cross" && b ? { to: roundPlace(b) } : {}),
    ...(strength !== 1 ? { strength } : {}),
    ...(group && group !== "*" ? { group } : {}),
  };
}

/** The edits that keep a formation whose places were put by hand, and let its dancers go there by their numbers. */
export function placedEdits(score: Score, name: string, number: number, places: Place[], headings: number[], segment: { start: number; measures: number; group: string } | null): SingleEdit[] {
  const table: Entry = { name, shape: "places", points: places.map(roundPlace) };
  const turned = headings.map((one) => Math.round(one));
  if (turned.some((one) => one !== 0)) table["headings_deg"] = turned;
  if (number > 0) {
    const written = entries(score, "formation")[number - 1] ?? {};
    const gone = Object.fromEntries(Object.keys(written).filter((key) => !(key in table)).map((key) => [key, null]));
    const kept = Object.fromEntries(Object.entries(table).filter(([key]) => key !== "name"));
    return [{ do: "change", at: ["formation", number], value: { ...gone, ...kept } }];
  }
  const edits: SingleEdit[] = [{ do: "insert", at: ["formation"], value: table }];
  if (segment) {
    const group = segment.group && segment.group !== "*" ? { group: segment.group } : {};
    edits.push({ do: "insert", at: ["segment"], value: { ...placeInScore(score, segment.start), measures: segment.measures, ...group, formation: name, match: "number" } });
  }
  return edits;
}
