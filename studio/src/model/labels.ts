// Labels of the patterns of recorded couples, as a person sets them: plain values, no page.

export interface Pattern {
  take: string;
  from_s: number;
  to_s: number;
  label: string;
}

export interface Take {
  name: string;
  seconds: number;
  beats: number[];
  style: string | null;
}

export interface LabelFacts {
  pairs: string;
  file: string;
  pattern_beats: number;
  rate: number;
  takes: Take[];
  revision: number;
  labels: string[];
  pattern: Pattern[];
}

export interface Slot {
  from: number;
  to: number;
}

/** Keys of the labels, in their order. */
export const LABEL_KEYS = "123456789abcdefghijkmnopqrtuvwxyz"; // without l and s, which loop and slow

const SAME_S = 0.02;

/** The patterns of a take: every so many beats, from the beat `first` (from 0) on; the last one may be shorter by half. */
export function slotsOf(take: Take, first: number, beats: number): Slot[] {
  const cuts = take.beats.filter((_, index) => index % beats === first % beats).filter((at) => at >= 0 && at <= take.seconds);
  const found: Slot[] = [];
  for (let index = 0; index + 1 < cuts.length; index++) found.push({ from: cuts[index] as number, to: cuts[index + 1] as number });
  const last = cuts.at(-1);
  const usual = found.at(-1);
  if (last !== undefined && usual && take.seconds - last > 0.5 * (usual.to - usual.from)) found.push({ from: last, to: take.seconds });
  return found;
}

/** The beat, from 0, on which the patterns of a take begin, as its labels have them; 0 without any. */
export function firstOf(take: Take, patterns: Pattern[], beats: number): number {
  const known = patterns.find((one) => one.take === take.name);
  if (!known) return 0;
  let best = 0;
  take.beats.forEach((at, index) => {
    if (Math.abs(at - known.from_s) < Math.abs((take.beats[best] ?? 0) - known.from_s)) best = index;
  });
  return best % beats;
}

/** The slot in which a time lies; -1: none. */
export function slotAt(slots: Slot[], time: number): number {
  return slots.findIndex((one) => time >= one.from && time < one.to);
}

/** The label of a slot: that of the pattern over its middle. */
export function labelOf(patterns: Pattern[], take: string, slot: Slot): string | null {
  const middle = 0.5 * (slot.from + slot.to);
  return patterns.find((one) => one.take === take && one.from_s <= middle && middle < one.to_s)?.label ?? null;
}

/** The patterns with another label for a slot; null takes it away. What lies over the slot gives way. */
export function labelled(patterns: Pattern[], take: string, slot: Slot, label: string | null): Pattern[] {
  const kept = patterns.filter((one) => one.take !== take || one.to_s <= slot.from + SAME_S || one.from_s >= slot.to - SAME_S);
  if (label !== null) kept.push({ take, from_s: slot.from, to_s: slot.to, label });
  return kept;
}

/** The patterns of a take moved to other slots, one after the other, when its patterns begin on another beat. */
export function moved(patterns: Pattern[], take: Take, before: Slot[], after: Slot[]): Pattern[] {
  const names = before.map((slot) => labelOf(patterns, take.name, slot));
  let found = patterns.filter((one) => one.take !== take.name);
  after.forEach((slot, index) => {
    const name = names[index];
    if (name) found = labelled(found, take.name, slot, name);
  });
  return found;
}

/** A name that the file takes; an empty text: it does not. */
export function cleanName(text: string): string {
  const name = text.trim();
  return /^[\p{L}\p{N}][\p{L}\p{N}_ .+'/-]{0,39}$/u.test(name) ? name : "";
}

/** Labels and patterns with a label called otherwise. */
export function renamed(labels: string[], patterns: Pattern[], label: string, name: string): { labels: string[]; patterns: Pattern[] } {
  return {
    labels: [...new Set(labels.map((one) => (one === label ? name : one)))],
    patterns: patterns.map((one) => (one.label === label ? { ...one, label: name } : one)),
  };
}

/** A label that the program suggests from one time to another [s]. */
export interface Suggestion extends Slot {
  label: string;
}

/** What is suggested for most of a slot; null: nothing for half of it. */
export function suggestionOf(spans: Suggestion[], slot: Slot): string | null {
  const seconds = new Map<string, number>();
  for (const one of spans) {
    const inside = Math.min(one.to, slot.to) - Math.max(one.from, slot.from);
    if (inside > 0) seconds.set(one.label, (seconds.get(one.label) ?? 0) + inside);
  }
  const [label, most] = [...seconds].sort((a, b) => b[1] - a[1])[0] ?? ["", 0];
  return most > 0.5 * (slot.to - slot.from) ? label : null;
}

/** How many slots of all takes have a label, and how many there are. */
export function progressOf(facts: LabelFacts, patterns: Pattern[], firsts: Record<string, number>): { done: number; of: number } {
  let done = 0;
  let of = 0;
  for (const take of facts.takes) {
    for (const slot of slotsOf(take, firsts[take.name] ?? 0, facts.pattern_beats)) {
      of += 1;
      if (labelOf(patterns, take.name, slot) !== null) done += 1;
    }
  }
  return { done, of };
}
