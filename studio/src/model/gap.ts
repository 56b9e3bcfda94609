// Between two formations: the free measures, the ways to choose from, and the edit that a choice is.
import type { SingleEdit } from "./document";
import type { Box } from "./plan";
import type { Entry } from "./score";
import type { Selected } from "./studio";

export const MATCHES: [string, string, string][] = [
  ["squared", "Calm", "nobody crosses: least sum of squared distances"],
  ["shortest", "Shortest", "least way, before they give way"],
  ["equal", "Equal", "all go equally far"],
  ["both", "Between", "short and equal at once"],
  ["bottleneck", "Least longest", "nobody goes far"],
  ["number", "By number", "the first dancer to the first place"],
];
export const WAYS: [string, string][] = [["mended", "give way"], ["straight", "straight"], ["divided", "bent by halves"]];

/** A choice of a key as it is said everywhere on the page. */
export function choiceInWords(key: string, choice: string): string {
  const known = key === "match" ? MATCHES : key === "way" ? WAYS : [];
  return known.find(([name]) => name === choice)?.[1].toLowerCase() ?? choice;
}
export const FACINGS: [string, string][] = [["", "as usual"], ["linear", "evenly"], ["tangent", "along the way"], ["measures", "measure by measure"], ["declared", "by hand"]];

export interface Option {
  match?: string;
  way?: string;
  facing?: string;
  headings_deg?: number[];
}

export interface OptionFigures {
  option: Option;
  total_m: number;
  longest_m: number;
  shortest_m: number;
  meetings: { measure: number; dancers: [number, number]; distance: number }[];
  too_far: { measure: number; dancer: number; distance: number; reach: number }[];
  ways: [number, number][][];
  headings: number[][];
  refused?: { what: string }[];
}

/** What is to be chosen: the ways of a segment that is there (`number`), or of one in the free measures before it. */
export interface Gap {
  /** The segment that they lead to, by number. */
  to: number;
  /** Measures of the written score, from 0. */
  start: number;
  length: number;
  /** Whether a segment has to be put into free measures. */
  free: boolean;
  group: string;
  formation: string;
  /** What comes before, in words; empty if that is not a formation. */
  after: string;
}

const CLOSE = 1e-6;

/** The gap before the later one of the selected segments; null if they lead into no formation, or are not a pair. */
export function gapOf(boxes: Box[], selected: Selected[]): Gap | null {
  const chosen = selected
    .filter((one) => one.list === "segment")
    .flatMap((one) => boxes.filter((box) => box.list === "segment" && box.number === one.number))
    .sort((a, b) => a.start - b.start);
  const last = chosen.at(-1);
  const before = chosen.length === 2 ? chosen[0] : undefined;
  if (!last || chosen.length > 2 || selected.length !== chosen.length || typeof last.entry["formation"] !== "string") return null;
  const gap: Gap = {
    to: last.number, start: last.start, length: last.length, free: false, group: last.group,
    formation: String(last.entry["formation"]), after: "",
  };
  if (!before) return gap;
  if (before.group.trim().toLowerCase() !== last.group.trim().toLowerCase()) return null;
  const end = before.start + before.length;
  gap.after = before.label;
  if (last.start < end - CLOSE) return null;
  if (last.start > end + CLOSE) Object.assign(gap, { start: end, length: last.start - end, free: true });
  return gap;
}

/** The free measures before a formation, back to the last segment of the same dancers; null if there are none. */
export function freeBefore(boxes: Box[], gap: Gap): Gap | null {
  const own = gap.group.trim().toLowerCase();
  const before = boxes.filter((box) => box.list === "segment" && box.number !== gap.to && box.group.trim().toLowerCase() === own && box.start < gap.start);
  const last = before.sort((a, b) => b.start + b.length - (a.start + a.length))[0];
  const end = last ? last.start + last.length : 0;
  if (!last || gap.free || end > gap.start - CLOSE) return null;
  return { ...gap, start: end, length: gap.start - end, free: true, after: last.label };
}

/** Keys of a segment for an option; null removes one, where `entry` has it and the option leaves it out. */
export function keysOf(option: Option, entry: Entry | null): Entry {
  const found: Entry = {};
  const usual: Entry = { match: "squared", way: "mended", facing: "" };
  for (const key of ["match", "way", "facing"] as const) {
    const value = option[key] ?? usual[key];
    if (value !== usual[key]) found[key] = value;
    else if (entry && entry[key] !== undefined) found[key] = null;
  }
  if (option.facing === "declared") found["headings_deg"] = option.headings_deg ?? [0];
  else if (entry && entry["headings_deg"] !== undefined) found["headings_deg"] = null;
  return found;
}

/** The segment that fills free measures, at a place of the written score. */
export function fillEntry(gap: Gap, place: { measure: number; section?: string }, option: Option): Entry {
  const group = gap.group && gap.group !== "*" ? { group: gap.group } : {};
  return { ...place, measures: Math.round(gap.length), ...group, formation: gap.formation, ...keysOf(option, null) };
}

/** The edits of a choice. `linked`: places in the order of the dancers, linked by hand, as a formation of its own. */
export function gapEdits(gap: Gap, place: { measure: number; section?: string }, entry: Entry, option: Option, linked: { name: string; table: Entry } | null): SingleEdit[] {
  const how: Option = linked ? { ...option, match: "number" } : option;
  const edits: SingleEdit[] = linked ? [{ do: "insert", at: ["formation"], value: { ...linked.table, name: linked.name } }] : [];
  if (gap.free) edits.push({ do: "insert", at: ["segment"], value: { ...fillEntry(gap, place, how), ...(linked ? { formation: linked.name } : {}) } });
  else {
    const changed = { ...keysOf(how, entry), ...(linked ? { formation: linked.name } : {}) };
    if (Object.keys(changed).length) edits.push({ do: "change", at: ["segment", gap.to], value: changed });
  }
  return edits;
}

/** Links with one more, from a dancer's row to a place's row: the two dancers exchange their places. */
export function linkedAlso(places: number[], dancer: number, place: number): number[] {
  const found = [...places];
  const other = found.indexOf(place);
  if (other >= 0) found[other] = found[dancer] ?? -1;
  found[dancer] = place;
  return found;
}

/** The place of the way at a share of its time, 0 to 1. */
export function alongWay(way: [number, number][], share: number): [number, number] {
  const at = Math.min(Math.max(share, 0), 1) * (way.length - 1);
  const index = Math.min(Math.floor(at), way.length - 2);
  const a = way[Math.max(index, 0)] ?? ([0, 0] as [number, number]);
  const b = way[index + 1] ?? a;
  const part = at - index;
  return [a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1])];
}
