// Pads for improvising, as the engine tells them: what can be launched, what waits and runs, and what cannot follow.
import type { Clock } from "./document";
import type { Structure } from "./score";
import type { Value } from "../net/values";

export type Page = "own" | "step" | "phrase" | "formation" | "element" | "look";
export type When = "now" | "beat" | "measure" | "section";
export type Follow = "stop" | "again" | "next" | "first" | "other";

export interface Pad {
  /** Kind and name, as `/dance/launch` takes them. */
  pad: string;
  kind: string;
  name: string;
  /** What it does, in a few words. */
  words: string;
  /** Of a kept pad: the name of what it launches, for how many measures, and what follows. */
  does?: string;
  measures?: number;
  follow?: Follow;
}

export interface Launch {
  pad: string;
  /** The dancers; "*" for everybody. */
  who: string;
  state: "waits" | "runs" | "refused";
  /** Danced beats from 0; null: nobody knows yet. */
  due?: number | null;
  until?: number | null;
  when?: When;
  follow?: Follow;
  /** Why it was refused. */
  why?: string;
}

/** What could follow an element that has ended, the best one first. */
export interface WhatNext {
  /** The kind of the element. */
  after: string;
  who: string;
  pads: { pad: string; name: string; measures: number }[];
}

export interface Launches {
  /** Beats of a measure. */
  beats: number;
  next?: WhatNext | null;
  launches: Launch[];
  /** By column, the steps that cannot follow at once: so many measures later; -1: not at all. */
  away: Record<string, Record<string, number>>;
}

export interface Column {
  /** A selection; "*" for everybody. */
  who: string;
  label: string;
  group: number;
}

export const WHENS: [When, string, string][] = [
  ["now", "Now", "at once; a step at the next half beat"],
  ["beat", "Beat", "at the next beat"],
  ["measure", "Measure", "at the next measure line"],
  ["section", "Section", "at the end of the section, or of the phrase of the music; else of eight measures"],
];
export const FOLLOWS: [Follow, string, string][] = [
  ["stop", "the score", "→ score"], ["again", "itself again", "↻ again"], ["next", "the next pad", "→ next"], ["first", "the first pad", "⇤ first"], ["other", "any other pad", "⤨ other"],
];
export const NOTHING: Launches = { beats: 4, launches: [], away: {} };

export function columns(structure: Structure, dancers: number[]): Column[] {
  const groups = structure.groups.map((group, index) => ({ who: group.name, label: group.name, group: index }));
  const chosen = dancers.length ? [{ who: dancers.join(" + "), label: `${dancers.length} selected`, group: -1 }] : [];
  return [{ who: "*", label: "everybody", group: -1 }, ...groups, ...chosen];
}

/** The command that launches a pad; a kept pad has its own measures and what follows. */
export function launchCall(pad: Pad, who: string, when: When, measures: number, follow: Follow): [string, ...Value[]] {
  return pad.measures === undefined ? ["/dance/launch", pad.pad, who, when, measures, follow] : ["/dance/launch", pad.pad, who, when];
}

/** "next for 1-8": whom a suggestion is for. */
export function nextInWords(next: WhatNext): string {
  return `after ${next.after}, next${next.who === "*" ? "" : ` for ${next.who}`}:`;
}

/** The command that launches a suggestion, in the measures that its dancers need. */
export function nextCall(next: WhatNext, index: number, when: When): [string, ...Value[]] | null {
  const pad = next.pads[index];
  return pad ? ["/dance/launch", pad.pad, next.who, when, pad.measures] : null;
}

/** What a pad of a column does: it waits, runs or was refused; null: nothing. */
export function launchOf(all: Launches, pad: Pad, who: string): Launch | null {
  const folded = who.toLowerCase();
  const own = all.launches.filter((one) => one.pad === pad.pad && one.who.toLowerCase() === folded);
  return own.find((one) => one.state === "waits") ?? own.find((one) => one.state === "runs") ?? own[0] ?? null;
}

/** Measures until the step of a pad can be danced by a column; 0: at once, -1: never. */
export function measuresAway(all: Launches, pad: Pad, who: string): number {
  return pad.kind === "step" ? (all.away[who]?.[pad.does ?? pad.name] ?? 0) : 0;
}

export function awayInWords(measures: number): string {
  if (measures < 0) return "no way leads to it from what is danced now";
  return `what is danced now does not lead into it at once: ${measures === 1 ? "1 measure" : `${measures} measures`} later`;
}

/** Danced beats from 0. */
export function dancedBeats(clock: Clock, beats: number): number {
  return (clock.measure - 1) * beats + clock.beat - 1;
}

/** The number to count: 1 in the last beat before it. Null: nobody knows when it comes. */
export function countOf(launch: Launch, danced: number): number | null {
  return typeof launch.due === "number" ? Math.max(1, Math.ceil(launch.due - danced - 1e-3)) : null;
}

/** How much of a running launch is over, 0 to 1. */
export function shareOf(launch: Launch, danced: number): number {
  if (typeof launch.due !== "number" || typeof launch.until !== "number" || launch.until <= launch.due) return 0;
  return Math.min(Math.max((danced - launch.due) / (launch.until - launch.due), 0), 1);
}

/** "2 of 4": the measure of a running launch. */
export function measureOf(launch: Launch, danced: number, beats: number): string {
  if (typeof launch.due !== "number" || typeof launch.until !== "number") return "";
  const first = Math.floor(launch.due / beats + 1e-3);
  const of = Math.max(1, Math.ceil(launch.until / beats - 1e-3) - first);
  return `${Math.min(of, Math.max(1, Math.floor(danced / beats + 1e-3) - first + 1))} of ${of}`;
}

/** The launch that comes next; null if none waits. */
export function nextOf(all: Launches): Launch | null {
  const waits = all.launches.filter((one) => one.state === "waits" && typeof one.due === "number");
  return waits.sort((a, b) => (a.due ?? 0) - (b.due ?? 0))[0] ?? null;
}

/** "side step, ember": what a launch is, in words. */
export function launchInWords(launch: Launch): string {
  const name = launch.pad.slice(launch.pad.indexOf(" ") + 1);
  return `${name}, ${launch.who === "*" ? "everybody" : launch.who}`;
}

/** A name for a kept pad that no other has. */
export function freePadName(pad: Pad, taken: string[]): string {
  const known = taken.map((name) => name.toLowerCase().trim());
  for (let count = 1; ; count++) {
    const name = count === 1 ? pad.name : `${pad.name} ${count}`;
    if (!known.includes(name.toLowerCase().trim())) return name.slice(0, 64);
  }
}
