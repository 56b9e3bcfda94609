// What the engine tells about the steps of the show, and how it is said.
import type { SingleEdit } from "./document";
import type { Box } from "./plan";

export interface Take {
  take: string;
  mirrored: boolean;
  direction: string;
  distance_m: number;
  turn_deg: number;
  begin_foot: string;
  end_foot: string;
  begin_pose: string;
  end_pose: string;
  bpm: number;
  author: string;
  style: string;
}

export interface StepFacts {
  name: string;
  measures: number;
  beats: number;
  direction: string;
  distance_m: number;
  turn_deg: number;
  begin_foot: string;
  end_foot: string;
  follows: string[];
  precedes: string[];
  connected: boolean;
  takes: Take[];
}

export interface Missing {
  measure: number;
  from: string | null;
  to: string | null;
  needs: string;
  because: string[];
  joints?: [string, number][];
}

/** Sequences of the score that follow each other without a pause, as one. */
export interface Chain {
  group: string;
  /** Measures of the written score, from 0. */
  start: number;
  words: string[];
}

const TURN_DEG = 45;
const LONGEST = 64;

export function measuresInWords(measures: number): string {
  return measures === 1 ? "1 measure" : `${measures} measures`;
}

/** Where a step goes: all directions in which it is there. */
export function directionInWords(step: StepFacts): string {
  const plain = [...new Set(step.takes.map((take) => take.direction.replace(/^(short|long) /, "")))];
  if (plain.length > 3) return "all directions";
  return plain.join(", ") || "in place";
}

export function turnInWords(degrees: number): string {
  if (Math.abs(degrees) < TURN_DEG) return "";
  const turns = Math.abs(degrees) / 360;
  const size = turns > 0.9 ? `${Math.round(turns * 2) / 2} turn${turns > 1.2 ? "s" : ""}` : turns > 0.4 ? "half turn" : "quarter turn";
  return `${size} ${degrees > 0 ? "left" : "right"}`;
}

/** "left → right": the foot that begins, and the one put down last. */
export function feetInWords(step: { begin_foot: string; end_foot: string }): string {
  if (!step.begin_foot && !step.end_foot) return "both feet stay";
  return `${step.begin_foot || "either"} → ${step.end_foot || "both"}`;
}

export function stepDetail(step: StepFacts): string {
  return [measuresInWords(step.measures), directionInWords(step), turnInWords(step.turn_deg)].filter(Boolean).join(" · ");
}

/** Takes in words that tell them apart. */
export function takeInWords(take: Take, number: number): string {
  const words = [take.direction, take.mirrored ? "mirrored" : "", take.begin_pose ? `from ${take.begin_pose}` : "", take.style, take.author];
  return `${number}: ${words.filter(Boolean).join(", ")}`;
}

/** Choose a take of a step to be danced, or leave it out; null: none would stay. With all takes the show needs no list. */
export function takesEdit(facts: StepFacts, chosen: string[] | undefined, take: string, danced: boolean): SingleEdit | null {
  const all = [...new Set(facts.takes.filter((one) => !one.mirrored).map((one) => one.take))]; // mirror images go with their takes
  const kept = new Set(chosen ?? all);
  if (danced) kept.add(take);
  else kept.delete(take);
  const names = all.filter((name) => kept.has(name));
  if (!names.length) return null;
  return { do: "set", at: ["takes", facts.name], value: names.length === all.length ? null : names };
}

export function isWanted(step: { name: string; takes?: Take[] }, wanted: string): boolean {
  const words = wanted.toLowerCase().split(/\s+/).filter(Boolean);
  const text = [step.name, ...(step.takes ?? []).flatMap((take) => [take.direction, take.style, take.author])].join(" ").toLowerCase();
  return words.every((word) => text.includes(word));
}

/** A sequence as it is written in the score: repeats become one entry. */
export function written(steps: string[]): string[] {
  const found: [string, number][] = [];
  for (const name of steps) {
    const last = found.at(-1);
    if (last?.[0] === name) last[1] += 1;
    else found.push([name, 1]);
  }
  return found.map(([name, times]) => (times > 1 ? `${name} x${times}` : name));
}

/** The sequences of each group, those that touch joined: each at most as long as the engine checks at once. */
export function chainsOf(boxes: Box[]): Chain[] {
  const found: (Chain & { end: number })[] = [];
  const own = boxes.filter((box) => box.list === "sequence" && box.entry["choose"] !== "random" && Array.isArray(box.entry["steps"]));
  for (const box of own.sort((a, b) => a.start - b.start)) {
    const group = box.group.trim().toLowerCase();
    const words = (box.entry["steps"] as unknown[]).map(String);
    const before = found.find((one) => one.group === group && Math.abs(one.end - box.start) < 1e-6);
    if (before && box.start + box.length - before.start <= LONGEST) {
      before.words.push(...words);
      before.end = box.start + box.length;
    } else found.push({ group, start: box.start, words, end: box.start + box.length });
  }
  return found.filter((one) => one.end - one.start <= LONGEST).map(({ end: _, ...chain }) => chain);
}
