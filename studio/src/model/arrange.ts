// Edits of boxes of the timeline: moved, resized, copied, split, joined, pasted. Pure: values in, edits out.
import { beatsPerMeasure, sectionSpans, type Box, type SectionSpan } from "./plan";
import { entries, number, text, type Entry, type Score } from "./score";
import type { SingleEdit } from "./document";

export type Snap = "measure" | "beat" | "none";

/** What begins at whole measures, at beats of measures, or anywhere. */
const AT_BEATS = ["at", "signal"];
const ANYWHERE = ["element"];
/** What has no length of its own. */
export const POINTS = ["at", "signal", "regroup", "cue"];
/** What cannot be moved in time. */
export const FIXED = ["cue"];
/** What has no dancers. */
const NOBODY = ["at", "signal", "curve", "cue"];
const FINEST = 1 / 64;

export interface Ground {
  spans: SectionSpan[];
  beats: number;
  library: Map<string, number>;
}

export function groundOf(score: Score, library: { name: string; measures: number }[]): Ground {
  return { spans: sectionSpans(score), beats: beatsPerMeasure(score), library: new Map(library.map((step) => [step.name.toLowerCase(), step.measures])) };
}

/** The smallest distance by which a box of a list moves [measures]. */
export function unitOf(list: string, snap: Snap, beats: number): number {
  const wished = snap === "measure" ? 1 : snap === "beat" ? 1 / beats : FINEST;
  return AT_BEATS.includes(list) || ANYWHERE.includes(list) ? wished : 1;
}

/** By how much a box moves so that it begins on the grid, and not before the score. */
export function snappedMove(box: Box, by: number, unit: number): number {
  return Math.max(Math.round((box.start + by) / unit) * unit, 0) - box.start;
}

/** The keys that say where something begins (measures of the written score from 0). */
export function placeKeys(list: string, start: number, ground: Ground, inSection = true): Entry {
  const at = Math.max(start, 0);
  const span = inSection ? (ground.spans.find((one) => at >= one.first && at < one.first + one.measures) ?? ground.spans.at(-1)) : undefined;
  const within = at - (span?.first ?? 0);
  const section = span ? { section: span.name } : {};
  if (ANYWHERE.includes(list)) return { measure: rounded(within + 1), ...section };
  const whole = Math.floor(within + 1e-6);
  if (!AT_BEATS.includes(list)) return { measure: whole + 1, ...section };
  return { measure: whole + 1, beat: rounded((within - whole) * ground.beats + 1), ...section };
}

function rounded(value: number): number {
  return Math.round(value * 64) / 64;
}

/** The key that names who dances, of a list. */
export function whoKey(list: string): string {
  return list === "regroup" ? "dancers" : "group";
}

export function hasDancers(list: string): boolean {
  return !NOBODY.includes(list);
}

/** What is different from the entry: keys that are already so are left out. */
function different(entry: Entry, keys: Entry): Entry {
  const starts: Entry = { measure: 1, beat: 1, group: "*" };
  return Object.fromEntries(Object.entries(keys).filter(([key, value]) => (entry[key] ?? starts[key]) !== value));
}

/** Move boxes by measures, and to other dancers; with `copy` they stay, too. */
export function moveEdits(boxes: Box[], by: number, who: (box: Box) => string | null, copy: boolean, ground: Ground): SingleEdit[] {
  const movable = boxes.filter((box) => !FIXED.includes(box.list));
  const sorted = copy ? [...movable].sort((a, b) => b.number - a.number) : movable;
  return sorted.flatMap((box): SingleEdit[] => {
    const group = hasDancers(box.list) ? who(box) : null;
    const inSection = typeof box.entry["section"] === "string";
    const place = placeKeys(box.list, box.start + by, ground, inSection);
    const keys = different(box.entry, { ...place, ...(group === null ? {} : { [whoKey(box.list)]: group }) });
    const at = [box.list, box.number];
    if (copy) return [{ do: "copy", at, value: keys }];
    return Object.keys(keys).length ? [{ do: "change", at, value: keys }] : [];
  });
}

/** Make boxes longer at their end, or at their beginning. */
export function resizeEdits(boxes: Box[], by: number, edge: "begin" | "end", ground: Ground): SingleEdit[] {
  return boxes.flatMap((box): SingleEdit[] => {
    if (POINTS.includes(box.list) || box.list === "curve") return [];
    const length = rounded(edge === "end" ? box.length + by : box.length - by);
    if (length <= 0 || by === 0) return [];
    const at = [box.list, box.number];
    if (edge === "end") return [{ do: "resize", at, value: length }];
    const place = placeKeys(box.list, box.start + by, ground, typeof box.entry["section"] === "string");
    return [{ do: "change", at, value: { ...different(box.entry, place), measures: length } }];
  });
}

/** Steps as they follow each other, repeats written out: name and measures. */
export function stepList(steps: unknown, library: Map<string, number>): { name: string; measures: number }[] {
  if (!Array.isArray(steps)) return [];
  return (steps as string[]).flatMap((words) => String(words).split(",")).flatMap((part) => {
    const [, name = "", times] = /^\s*(.*?)(?:\s+x(\d+))?\s*$/.exec(part) ?? [];
    return Array.from({ length: Number(times ?? 1) }, () => ({ name, measures: library.get(name.toLowerCase()) ?? 1 }));
  });
}

/** Names of steps, with repeats as in "walk x3". */
export function writtenSteps(names: string[]): string[] {
  const found: { name: string; times: number }[] = [];
  for (const name of names) {
    const last = found.at(-1);
    if (last?.name === name) last.times++;
    else found.push({ name, times: 1 });
  }
  return found.map(({ name, times }) => (times > 1 ? `${name} x${times}` : name));
}

/** Split boxes at a measure; words if one of them cannot be split there. */
export function splitEdits(boxes: Box[], at: number, ground: Ground): SingleEdit[] | string {
  const edits: SingleEdit[] = [];
  const cut = boxes.filter((box) => at > box.start + 1e-6 && at < box.start + box.length - 1e-6).sort((a, b) => b.number - a.number);
  if (!cut.length) return "Put the cursor into a selected box, then split.";
  for (const box of cut) {
    const first = rounded(at - box.start);
    if (unitOf(box.list, "none", ground.beats) === 1 && first !== Math.round(first)) return "This can be split at measure lines only.";
    const place = different(box.entry, placeKeys(box.list, at, ground, typeof box.entry["section"] === "string"));
    const where = [box.list, box.number];
    if (box.list === "sequence") {
      const steps = stepList(box.entry["steps"], ground.library);
      let end = 0;
      let count = 0;
      while (count < steps.length && end < first) end += steps[count++]?.measures ?? 1;
      if (end > first) return `“${steps[count - 1]?.name ?? ""}” takes several measures: split before or after it.`;
      const limited = typeof box.entry["measures"] === "number";
      const names = steps.map((step) => step.name);
      if (!limited && count < names.length) {
        edits.push({ do: "copy", at: where, value: { ...place, steps: writtenSteps(names.slice(count)) } });
        edits.push({ do: "set", at: [...where, "steps"], value: writtenSteps(names.slice(0, count)) });
        continue;
      }
      const shift = names.length ? count % names.length : 0;
      edits.push({ do: "copy", at: where, value: { ...place, steps: writtenSteps([...names.slice(shift), ...names.slice(0, shift)]), measures: box.length - first } });
      edits.push({ do: "set", at: [...where, "measures"], value: first });
      continue;
    }
    if (POINTS.includes(box.list) || box.list === "curve") continue;
    edits.push({ do: "copy", at: where, value: { ...place, measures: rounded(box.length - first) } });
    edits.push({ do: "resize", at: where, value: first });
  }
  return edits;
}

/** Join boxes of one row to one; words if they cannot be joined. */
export function joinEdits(boxes: Box[], ground: Ground): SingleEdit[] | string {
  const sorted = [...boxes].sort((a, b) => a.start - b.start);
  const [first] = sorted;
  if (!first || sorted.length < 2) return "Select two or more boxes of a row, then join.";
  if (sorted.some((box) => box.list !== first.list || box.group.toLowerCase() !== first.group.toLowerCase())) return "Only boxes of one kind and one row can be joined.";
  if (POINTS.includes(first.list) || ["curve", "improvise"].includes(first.list)) return "These cannot be joined.";
  const end = Math.max(...sorted.map((box) => box.start + box.length));
  const at = [first.list, first.number];
  const edits: SingleEdit[] = [];
  if (first.list === "sequence") {
    const names = sorted.flatMap((box) => {
      const steps = stepList(box.entry["steps"], ground.library).map((step) => step.name);
      const limited = box.entry["measures"];
      return typeof limited === "number" && limited > 0 && steps.length ? repeatedTo(steps, limited, ground.library) : steps;
    });
    edits.push({ do: "change", at, value: { steps: writtenSteps(names), ...(first.entry["measures"] === undefined ? {} : { measures: null }) } });
  } else edits.push({ do: "resize", at, value: rounded(end - first.start) });
  const others = sorted.slice(1).sort((a, b) => b.number - a.number);
  return [...edits, ...others.map((box): SingleEdit => ({ do: "delete", at: [box.list, box.number] }))];
}

function repeatedTo(names: string[], measures: number, library: Map<string, number>): string[] {
  const found: string[] = [];
  let left = measures;
  for (let index = 0; left > 0 && index < 1000; index++) {
    const name = names[index % names.length] as string;
    found.push(name);
    left -= library.get(name.toLowerCase()) ?? 1;
  }
  return found;
}

/** What Ctrl+C keeps: entries without their place, and where they begin after the first of them [measures]. */
export interface Copied {
  list: string;
  entry: Entry;
  after: number;
}

export function copied(boxes: Box[]): Copied[] {
  const kept = boxes.filter((box) => !FIXED.includes(box.list));
  const first = Math.min(...kept.map((box) => box.start));
  return kept.map((box) => {
    const { measure: _m, beat: _b, section: _s, ...entry } = box.entry;
    return { list: box.list, entry, after: box.start - first };
  });
}

/** Put copied entries at a measure, for these dancers (null: as they were). */
export function pasteEdits(kept: Copied[], at: number, who: string | null, ground: Ground): SingleEdit[] {
  const one = new Set(kept.map((each) => String(each.entry[whoKey(each.list)] ?? "*").toLowerCase())).size === 1;
  return kept.map((each): SingleEdit => {
    const unit = unitOf(each.list, "none", ground.beats);
    const start = Math.round((at + each.after) / unit) * unit;
    const group = who !== null && one && hasDancers(each.list) && each.list !== "regroup" ? { group: who } : {};
    return { do: "insert", at: [each.list], value: { ...each.entry, ...placeKeys(each.list, start, ground), ...group } };
  });
}

/** Divide a score without sections: all of it becomes one, of this name. */
export function firstSectionEdits(score: Score, name: string, measures: number): SingleEdit[] {
  const edits: SingleEdit[] = [{ do: "insert", at: ["section"], value: { name, measures } }];
  if (score["loop_measures"] !== undefined) edits.push({ do: "set", at: ["loop_measures"], value: null });
  for (const list of ["segment", "sequence", "improvise", "regroup", "element", "signal", "curve", "at"]) {
    entries(score, list).forEach((entry, index) => {
      const isPlaced = list !== "signal" || typeof entry["measure"] === "number";
      if (isPlaced && entry["section"] === undefined) edits.push({ do: "set", at: [list, index + 1, "section"], value: name });
    });
  }
  return edits;
}

/** A name that no entry of a list has. */
export function freeName(score: Score, list: string, wished: string): string {
  const names = new Set(entries(score, list).map((entry) => text(entry, "name").toLowerCase()));
  for (let count = 1; ; count++) {
    const name = count === 1 ? wished : `${wished} ${count}`;
    if (!names.has(name.toLowerCase())) return name;
  }
}

/** The points of a curve: measures from its beginning, and values from 0 to 1. */
export function curvePoints(entry: Entry): [number, number][] {
  const points = entry["points"];
  if (!Array.isArray(points)) return [];
  return points.filter((one): one is [number, number] => Array.isArray(one) && typeof one[0] === "number" && typeof one[1] === "number");
}

/** A phrase of the music, in measures from 0; `number`: its entry, from 1, or 0 where nobody wrote it. */
export interface Phrase {
  start: number;
  measures: number;
  name: string;
  number: number;
}

/** Phrases of the music, or every eight measures. */
export function phrases(score: Score, length: number): Phrase[] {
  const written = writtenPhrases(score);
  const all = written.length ? written : Array.from({ length: Math.ceil(length / 8) }, (_, index) => ({ start: 8 * index, name: "", number: 0 }));
  return all.filter((one) => one.start < length).map((one, index) => ({ ...one, measures: (all[index + 1]?.start ?? length) - one.start }));
}

function writtenPhrases(score: Score): { start: number; name: string; number: number }[] {
  const music = (score["music"] as Score | undefined) ?? {};
  return entries(music, "phrase")
    .map((one, index) => ({ start: number(one, "measure", 1) - 1, name: text(one, "name"), number: index + 1 }))
    .sort((one, other) => one.start - other.start);
}

/** What a phrase that begins in a measure (from 0) is called from now on; an empty name takes a phrase away that is there. Null: nothing changes. */
export function phraseEdit(score: Score, start: number, name: string): SingleEdit | null {
  const all = writtenPhrases(score);
  const known = all.find((one) => one.start === start);
  const at = ["music", "phrase"];
  if (known) {
    if (known.name === name) return null;
    return name ? { do: "set", at: [...at, known.number, "name"], value: name } : { do: "delete", at: [...at, known.number] };
  }
  const before = all.findLast((one) => one.start < start)?.number ?? 0;
  return { do: "insert", at: before === all.length ? at : [...at, before + 1], value: name ? { measure: start + 1, name } : { measure: start + 1 } };
}
