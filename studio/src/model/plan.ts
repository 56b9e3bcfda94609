// The written score over measures: sections in a row, each once, and the boxes of all entries in rows.
import { entries, number, text, type Entry, type Score, type Structure } from "./score";

export interface SectionSpan {
  name: string;
  /** First measure, from 0. */
  first: number;
  measures: number;
  repeat: number;
  wait: boolean;
  then: string;
  /** Its number in the document, from 1; 0 in a score without sections. */
  number: number;
}

export interface Box {
  list: string;
  /** Its number in the document, from 1. */
  number: number;
  entry: Entry;
  /** Measures from 0; may be fractions. */
  start: number;
  length: number;
  label: string;
  /** The dancers, as a selection; "*" for all. */
  group: string;
}

export interface Row {
  id: string;
  label: string;
  kind: "signals" | "curve" | "calls" | "group" | "part" | "danced";
  /** Whom boxes of this row are for, as a selection; null: nobody. */
  selection: string | null;
  /** Index of the group; -1: none, or several. */
  group: number;
  depth: number;
  boxes: Box[];
  /** Of a part: where it stands apart from its row, [first, last) in measures. */
  apart: [number, number][];
  /** Boxes that overlap lie in lanes below one another. */
  lanes: number;
  lane: Map<Box, number>;
}

export type Mode = "steps" | "motion";

const OPEN_END = 16;
const LENGTHS: Record<string, number> = { segment: 4, element: 4, at: 0, signal: 0, regroup: 0 };
const STEP_LISTS = ["sequence", "improvise"];
const MOTION_LISTS = ["segment", "element", "regroup"];
const CALL_LISTS = ["signal", "curve", "at"];

export function beatsPerMeasure(score: Score): number {
  const clock = score["clock"] as Entry | undefined;
  return clock ? number(clock, "beats_per_measure", 4) : 4;
}

export function bpm(score: Score): number {
  const music = score["music"] as Entry | undefined;
  const clock = score["clock"] as Entry | undefined;
  return number(music ?? {}, "bpm", number(clock ?? {}, "bpm", 112));
}

export function stageSize(score: Score): { width: number; depth: number } {
  const stage = (score["stage"] as Entry | undefined) ?? {};
  return { width: number(stage, "width", 8), depth: number(stage, "depth", 6) };
}

export function sectionSpans(score: Score): SectionSpan[] {
  let first = 0;
  return entries(score, "section").map((entry, index) => {
    const measures = number(entry, "measures", 8);
    const span = {
      name: text(entry, "name"), first, measures, repeat: number(entry, "repeat", 1), wait: entry["wait"] === true,
      then: text(entry, "then"), number: index + 1,
    };
    first += measures;
    return span;
  });
}

/** Measures of the whole written score; where it has no end, some beyond the last entry. */
export function scoreLength(structure: Structure): number {
  const { score } = structure;
  const spans = sectionSpans(score);
  const last = spans.at(-1);
  if (last) return last.first + last.measures;
  const loop = score["loop_measures"];
  if (typeof loop === "number") return loop;
  const ends = allBoxes(structure).map((box) => box.start + Math.max(box.length, 1));
  return Math.max(OPEN_END, ...ends.map(Math.ceil));
}

/** Whether the score ends, or begins again, after its last measure. */
export function hasEnd(score: Score): boolean {
  return sectionSpans(score).length > 0 || typeof score["loop_measures"] === "number";
}

/** Measures that are shown of a score without an end: they grow with the playhead (measures from 0), in few steps. */
export function grown(written: number, playhead: number | null): number {
  return Math.max(written, OPEN_END * Math.ceil(((playhead ?? 0) + 4) / OPEN_END));
}

/** How many measures a written sequence lasts. */
export function sequenceLength(steps: unknown, library: Map<string, number>): number {
  if (!Array.isArray(steps)) return 1;
  let total = 0;
  for (const word of steps as string[]) {
    for (const part of String(word).split(",")) {
      const [, name = "", times] = /^\s*(.*?)(?:\s+x(\d+))?\s*$/.exec(part) ?? [];
      total += (library.get(name.toLowerCase()) ?? 1) * Number(times ?? 1);
    }
  }
  return Math.max(total, 1);
}

function boxLength(list: string, entry: Entry, library: Map<string, number>, rest: number): number {
  const written = entry["measures"];
  if (typeof written === "number") return written;
  if (list === "sequence") return sequenceLength(entry["steps"], library);
  if (list === "improvise") return Math.max(rest, 1);
  if (list === "curve") {
    const points = entry["points"];
    const last = Array.isArray(points) ? (points.at(-1) as [number, number] | undefined) : undefined;
    return last ? Math.max(last[0], 0.25) : 1;
  }
  return LENGTHS[list] ?? 1;
}

/** The address of a control as words: "light rim colour". */
export function controlWords(address: string): string {
  return address.replace("/dance/", "").replace(/[/_]/g, " ");
}

export function boxLabel(list: string, entry: Entry): string {
  switch (list) {
    case "segment":
      return text(entry, "formation") || text(entry, "evolution") || (entry["path"] ? "travel" : "pause");
    case "sequence":
      return Array.isArray(entry["steps"]) ? (entry["steps"] as string[]).join(", ") : "";
    case "improvise":
      return "improvise";
    case "element":
      return text(entry, "kind");
    case "signal":
    case "curve":
      return text(entry, "name");
    case "at":
      return text(entry, "signal") || text(entry, "scene") || controlWords(text(entry, "call"));
    case "regroup":
      return `${text(entry, "dancers")} to ${text(entry, "group")}`;
    default:
      return text(entry, "name");
  }
}

export function allBoxes(structure: Structure): Box[] {
  const { score } = structure;
  const spans = sectionSpans(score);
  const beats = beatsPerMeasure(score);
  const library = new Map(structure.library.map((step) => [step.name.toLowerCase(), step.measures]));
  const whole = spans.reduce((sum, span) => sum + span.measures, 0);
  const boxes: Box[] = [];
  for (const list of [...STEP_LISTS, ...MOTION_LISTS, ...CALL_LISTS]) {
    entries(score, list).forEach((entry, index) => {
      const written = entry["measure"];
      if (list === "signal" && typeof written !== "number") return;
      const name = text(entry, "section").toLowerCase();
      const span = name ? spans.find((one) => one.name.toLowerCase() === name) : undefined;
      const beat = number(entry, "beat", 1);
      const start = (span?.first ?? 0) + (typeof written === "number" ? written : 1) - 1 + (beat - 1) / beats;
      const end = span ? span.first + span.measures : whole || start + OPEN_END;
      const length = boxLength(list, entry, library, end - start);
      boxes.push({
        list, number: index + 1, entry, start, length, label: boxLabel(list, entry),
        group: list === "regroup" ? text(entry, "dancers", "*") : text(entry, "group", "*"),
      });
    });
  }
  entries(score, "cue").forEach((entry, index) => {
    const span = spans.find((one) => one.name.toLowerCase() === text(entry, "section").toLowerCase());
    if (span) boxes.push({ list: "cue", number: index + 1, entry, start: span.first, length: 0, label: text(entry, "name"), group: "*" });
  });
  return boxes;
}

/** The rows of the timeline in one of its two modes: those of groups, with the parts that have boxes of their own. */
export function planRows(structure: Structure, mode: Mode): Row[] {
  const boxes = allBoxes(structure);
  const shown = boxes.filter((box) => (mode === "steps" ? STEP_LISTS : MOTION_LISTS).includes(box.list));
  const rows: Row[] = [];
  const add = (id: string, label: string, kind: Row["kind"], group: number, depth: number, own: Box[], selection: string | null = null): void => {
    const { lanes, lane } = laneOf(own);
    rows.push({ id, label, kind, group, depth, boxes: own, lanes, lane, selection, apart: depth ? apartOf(own) : [] });
  };
  add("signals", "Signals", "signals", -1, 0, boxes.filter((box) => box.list === "signal"));
  for (const box of boxes) if (box.list === "curve") add(`curve ${box.number}`, box.label, "curve", -1, 0, [box]);
  add("calls", "Calls and cues", "calls", -1, 0, boxes.filter((box) => box.list === "at" || box.list === "cue"));
  const everybody = shown.filter((box) => isEverybody(box.group));
  add("all", "Everybody", "part", -1, 0, everybody, "*");
  const names = structure.groups.map((group) => group.name.toLowerCase());
  const parts = new Map<string, Box[]>();
  for (const box of shown) {
    const name = box.group.trim().toLowerCase();
    if (isEverybody(box.group) || names.includes(name)) continue;
    parts.set(name, [...(parts.get(name) ?? []), box]);
  }
  const groupOf = structure.groups.flatMap((group, index) => Array<number>(group.dancers).fill(index));
  structure.groups.forEach((group, index) => {
    const name = group.name.toLowerCase();
    add(`group ${index}`, group.name, "group", index, 0, shown.filter((box) => box.group.trim().toLowerCase() === name), group.name);
    for (const [words, own] of parts) {
      if (namedGroups(words, names, groupOf).join() === String(index)) {
        add(`part ${words}`, own[0]?.group ?? words, "part", index, 1, own, own[0]?.group ?? words);
        parts.delete(words);
      }
    }
  });
  for (const [words, own] of parts) add(`part ${words}`, own[0]?.group ?? words, "part", -1, 0, own, own[0]?.group ?? words);
  return rows;
}

/** The measures in which a part has boxes; gaps of less than a measure are none. */
function apartOf(boxes: Box[]): [number, number][] {
  const found: [number, number][] = [];
  for (const box of [...boxes].sort((a, b) => a.start - b.start)) {
    const last = found.at(-1);
    if (last && box.start <= last[1] + 1) last[1] = Math.max(last[1], box.start + box.length);
    else found.push([box.start, box.start + Math.max(box.length, 1)]);
  }
  return found;
}

function isEverybody(words: string): boolean {
  return ["", "*"].includes(words.trim());
}

/** Indices of the groups that a selection names, or to which its numbered dancers belong; `groupOf`: by dancer. */
function namedGroups(words: string, names: string[], groupOf: number[]): number[] {
  const parts = words.split(/[+&()-]/).map((part) => part.trim());
  const numbered = parts.flatMap((part) => (/^\d+$/.test(part) ? [groupOf[Number(part) - 1] ?? -1] : []));
  return names.flatMap((name, index) => (parts.includes(name) || numbered.includes(index) ? [index] : []));
}

function laneOf(boxes: Box[]): { lanes: number; lane: Map<Box, number> } {
  const free: number[] = [];
  const lane = new Map<Box, number>();
  for (const box of [...boxes].sort((a, b) => a.start - b.start || b.length - a.length)) {
    let at = free.findIndex((end) => end <= box.start + 1e-6);
    if (at < 0) at = free.length;
    free[at] = box.start + Math.max(box.length, 0.25);
    lane.set(box, at);
  }
  return { lanes: Math.max(free.length, 1), lane };
}

/** Where a measure of the written score (from 0) lies: as `measure` and `section` of an entry. */
export function writtenPlace(score: Score, start: number, section: string): { measure: number; section?: string } {
  const spans = sectionSpans(score);
  const span = spans.find((one) => start >= one.first && start < one.first + one.measures) ?? spans.at(-1);
  if (!span) return { measure: start + 1 };
  if (!section && spans.length === 0) return { measure: start + 1 };
  return { measure: start - span.first + 1, section: span.name };
}

/** Seconds into the music at a measure (from 0), by its lines or its tempo; null if nothing is known. */
export function musicTime(score: Score, measure: number): number {
  const music = (score["music"] as Entry | undefined) ?? {};
  const lines = entries(music as Score, "line");
  const first = lines[0];
  if (first && lines.length > 1) {
    const times = lines.map((line) => number(line, "time_s", 0));
    const index = Math.min(Math.max(Math.floor(measure), 0), times.length - 2);
    const a = times[index] ?? 0;
    const b = times[index + 1] ?? a + 2;
    return a + (measure - index) * (b - a);
  }
  return number(music, "one_at_s", 0) + (measure * beatsPerMeasure(score) * 60) / bpm(score);
}
