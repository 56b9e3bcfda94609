// Formations of the show as tables: what each shape takes, where each is used, and what an edit changes.
import { entries, text, type Entry, type Score, type Structure } from "./score";
import type { SingleEdit } from "./document";

export interface Places {
  slots: [number, number][];
  heading: number[];
  soloists: number;
  lines: [number, number][][];
  least_m: number | null;
  fits: boolean;
  outside: number[];
  scale: number;
  move: [number, number];
  remedy: string;
  warnings: string[];
  waiting: number;
  empty: number;
  refused?: { what: string; remedy?: string }[];
}

export const SHAPES: [string, string][] = [
  ["line", "Line"], ["arc", "Arc"], ["circle", "Circle"], ["ellipse", "Ellipse"], ["rectangle", "Rectangle"], ["polygon", "Polygon"],
  ["star", "Star"], ["spiral", "Spiral"], ["grid", "Rows"], ["text", "Letters"], ["polyline", "Drawn lines"], ["path", "SVG path"],
  ["places", "Places by hand"],
];
/** Formations that need no table: words of a segment. */
export const WORDS = ["line", "circle", "grid", "triangle", "star", "spiral", "arc", "rectangle", "hexagon", "circle poisson", "star inside"];
export const INSIDE = ["grid", "diagonal", "concentric", "poisson"];

/** Keys that a shape has of its own. */
const OWN: Record<string, string[]> = {
  arc: ["arc_deg"], polygon: ["corners", "points"], star: ["corners", "inner"], spiral: ["turns"], text: ["text"], path: ["path"],
  polyline: ["points", "closed"], places: ["points", "headings_deg"],
};
const OF_SHAPES = [...new Set(Object.values(OWN).flat())];

export function isDrawn(table: Entry): boolean {
  return table["shape"] === "polyline" || table["shape"] === "places";
}

/** The drawn lines of a table, as lists of points. */
export function linesOf(table: Entry): [number, number][][] {
  const points = table["points"];
  if (!Array.isArray(points) || !points.length) return [];
  if (typeof (points[0] as unknown[])?.[0] === "number") return [points as [number, number][]];
  return points as [number, number][][];
}

/** The table with another shape: what the new one has no use for leaves, what it needs comes. */
export function withShape(table: Entry, shape: string): Entry {
  const kept = Object.fromEntries(Object.entries(table).filter(([key]) => !OF_SHAPES.includes(key) || (OWN[shape] ?? []).includes(key)));
  const found: Entry = { ...kept, shape };
  if (shape === "text") found["text"] = text(table, "text") || "LIVE";
  if (shape === "path") found["path"] = table["path"] ?? "M -3 0 C -1 -3 1 3 3 0";
  if (shape === "polyline" || shape === "places") found["points"] = linesOf(table).length ? table["points"] : [[-3, 0], [0, -1.5], [3, 0]];
  if (shape === "places") {
    found["points"] = linesOf(found).flat();
    for (const key of ["size", "pattern", "dancers", "weights", "count", "spacing", "density", "mirror", "mirror_at", "mirror_keep", "focus"]) delete found[key];
  }
  if (shape === "grid") for (const key of ["dancers", "pattern", "weights", "focus", "mirror", "mirror_at", "mirror_keep"]) delete found[key];
  return found;
}

/** The table with dancers on the lines or inside, and a pattern; "" for the usual one. */
export function withPattern(table: Entry, dancers: "on" | "inside", pattern: string): Entry {
  const found: Entry = { ...table };
  for (const key of ["dancers", "pattern", "weights", "focus", "focus_reach", "focus_strength", ...(dancers === "on" ? ["density"] : [])]) delete found[key];
  if (dancers === "inside") found["dancers"] = "inside";
  if (pattern && pattern !== "even") found["pattern"] = pattern;
  if (pattern === "weighted") {
    if (dancers === "on") found["weights"] = (table["weights"] as number[] | undefined) ?? [1, 3, 1];
    else {
      found["focus"] = table["focus"] ?? [0, 0];
      found["focus_reach"] = table["focus_reach"] ?? 2;
      found["focus_strength"] = table["focus_strength"] ?? 3;
    }
  }
  return found;
}

export function isInside(table: Entry): boolean {
  return table["dancers"] === "inside" || (table["dancers"] === undefined && INSIDE.includes(text(table, "pattern")));
}

/** Where a formation is used: segments by number (from 1), and groups that begin with it. */
export function usesOf(score: Score, name: string): { segments: number[]; groups: string[] } {
  const folded = name.trim().toLowerCase();
  const is = (entry: Entry): boolean => text(entry, "formation").trim().toLowerCase() === folded;
  return {
    segments: entries(score, "segment").flatMap((entry, index) => (is(entry) ? [index + 1] : [])),
    groups: entries(score, "group").flatMap((entry) => (is(entry) ? [text(entry, "name")] : [])),
  };
}

/** A name that no formation has yet: "star 2". */
export function freeName(score: Score, wanted: string): string {
  const names = new Set(entries(score, "formation").map((entry) => text(entry, "name").toLowerCase()));
  if (!names.has(wanted.toLowerCase())) return wanted;
  for (let number = 2; ; number++) {
    const name = `${wanted.replace(/ \d+$/, "")} ${number}`;
    if (!names.has(name.toLowerCase())) return name;
  }
}

/** The edits that make a formation of the document (by number from 1; 0: a new one) what the table says. */
export function formationEdits(score: Score, number: number, table: Entry): SingleEdit[] {
  const before = entries(score, "formation")[number - 1];
  if (!before) return [{ do: "insert", at: ["formation"], value: table }];
  const edits: SingleEdit[] = [];
  if (text(table, "name") !== text(before, "name")) edits.push({ do: "rename", at: ["formation", number], value: text(table, "name") });
  const changed: Entry = {};
  for (const key of new Set([...Object.keys(before), ...Object.keys(table)])) {
    if (key !== "name" && JSON.stringify(before[key]) !== JSON.stringify(table[key])) changed[key] = table[key] ?? null;
  }
  if (Object.keys(changed).length) edits.push({ do: "change", at: ["formation", number], value: changed });
  return edits;
}

/** A drawn stroke with few points: those that keep it within `near` [m]. */
export function simplified(line: [number, number][], near = 0.06): [number, number][] {
  if (line.length < 3) return line;
  const [first, last] = [line[0] as [number, number], line.at(-1) as [number, number]];
  let [far, at] = [0, 0];
  const length = Math.hypot(last[0] - first[0], last[1] - first[1]);
  for (let index = 1; index < line.length - 1; index++) {
    const [x, z] = line[index] as [number, number];
    const away = length < 1e-9
      ? Math.hypot(x - first[0], z - first[1])
      : Math.abs((last[0] - first[0]) * (z - first[1]) - (last[1] - first[1]) * (x - first[0])) / length;
    if (away > far) [far, at] = [away, index];
  }
  if (far <= near) return [first, last];
  return [...simplified(line.slice(0, at + 1), near).slice(0, -1), ...simplified(line.slice(at), near)];
}

/** How many dancers a formation is shown for: everybody, or a group. */
export function dancersOf(structure: Structure | null, group: string): number {
  const groups = structure?.groups ?? [];
  const own = groups.find((one) => one.name === group);
  return Math.min(Math.max(own ? own.dancers : groups.reduce((sum, one) => sum + one.dancers, 0), 1), 400);
}
