// Group motion as material: a formation or evolution of the show is bent into a region or along a line. Values and edits.
import { placeInScore } from "./danced";
import type { SingleEdit } from "./document";
import { usesOf, WORDS } from "./formations";
import { awayFrom, distance, isWithin, roundPlace, simplified, type Place } from "./geometry";
import { entries, text, type Entry, type Group, type Score } from "./score";

/** A group's motion that can be bent. */
export interface Material {
  list: "formation" | "evolution";
  /** Its name, or a shape in words. */
  name: string;
  /** The segment that dances it and changes, from 1; 0: a new segment will dance it. */
  segment: number;
}

/** Where it can be bent to: into a region, or along a line. */
export interface Ground {
  kind: "into" | "along";
  /** What the document keeps: the name of a formation, or points as they are drawn. */
  to: string | Place[];
  /** Lines as they are shown; within a region, further ones are holes. */
  lines: Place[][];
}

/** Where a new segment goes: written measure from 0, measures, dancers. */
export interface Put {
  start: number;
  measures: number;
  group: string;
}

const MOST_POINTS = 64;
const NEAR_LINE_M = 0.6;

/** What a segment (from 1) dances, if that can be bent. */
export function materialOf(score: Score, segment: number): Material | null {
  const entry = entries(score, "segment")[segment - 1];
  for (const list of ["evolution", "formation"] as const) {
    const name = entry ? text(entry, list) : "";
    if (name) return { list, name, segment };
  }
  return null;
}

/** All that can be bent: what the selected segment dances, evolutions, formations, shapes. */
export function materials(score: Score, segment: number): Material[] {
  const chosen = materialOf(score, segment);
  const named = (list: Material["list"]): Material[] => entries(score, list).map((one) => ({ list, name: text(one, "name"), segment: 0 }));
  const words = WORDS.map((name): Material => ({ list: "formation", name, segment: 0 }));
  return [...(chosen ? [chosen] : []), ...named("evolution"), ...named("formation"), ...words];
}

/** A drawn line as a ground. */
export function drawnGround(points: Place[], closed: boolean): Ground {
  const few = simplified(points, 0.05, MOST_POINTS).map(roundPlace);
  const last = few.at(-1);
  if (closed && few.length > 3 && few[0] && last && distance(few[0], last) < 0.1) few.pop();
  return { kind: closed ? "into" : "along", to: few, lines: [closed && few[0] ? [...few, few[0]] : few] };
}

/** A formation of the show as a ground, by its lines; null if they are neither closed nor one line. */
export function namedGround(name: string, lines: Place[][]): Ground | null {
  const drawn = lines.filter((line) => line.length > 1);
  if (!drawn.length) return null;
  if (drawn.every((line) => line.length > 3 && distance(line[0] as Place, line.at(-1) as Place) < 0.02)) return { kind: "into", to: name, lines: drawn };
  return drawn.length === 1 ? { kind: "along", to: name, lines: drawn } : null;
}

/** The ground under a place: the nearest line within reach, else the smallest region around it. */
export function groundAt(place: Place, grounds: Ground[]): Ground | null {
  let found: Ground | null = null;
  let least = Infinity;
  for (const ground of grounds) {
    const line = ground.lines[0] as Place[];
    const cost = ground.kind === "along" ? awayFromLine(place, line) : isInRegion(place, ground.lines) ? 10 + areaOf(line) : Infinity;
    if (cost < least && (ground.kind === "into" || cost < NEAR_LINE_M)) [found, least] = [ground, cost];
  }
  return found;
}

function isInRegion(place: Place, lines: Place[][]): boolean {
  return lines.filter((line) => isWithin(place, line)).length % 2 === 1;
}

function awayFromLine(place: Place, line: Place[]): number {
  return Math.min(...line.slice(1).map((point, at) => awayFrom(place, line[at] as Place, point)));
}

function areaOf(line: Place[]): number {
  let sum = 0;
  line.forEach(([x, z], at) => {
    const [before, beyond] = line[at ? at - 1 : line.length - 1] as Place;
    sum += before * z - x * beyond;
  });
  return Math.abs(sum) / 2;
}

/** "into square", "along the drawn line". */
export function groundWords(ground: Ground): string {
  return `${ground.kind} ${typeof ground.to === "string" ? ground.to : ground.kind === "into" ? "the drawn region" : "the drawn line"}`;
}

/** The table of a bent formation or evolution. One that is bent already goes elsewhere, and is not bent twice. */
export function bentTable(score: Score, material: Material, ground: Ground): Entry {
  const own = entries(score, material.list)[numberOf(score, material) - 1];
  const { along: _a, into: _i, ...rest } = own && own["like"] !== undefined && (own["along"] !== undefined || own["into"] !== undefined) ? own : { name: "", like: material.name };
  return { ...rest, name: freeName(score, material.list, `${material.name} ${ground.kind === "into" ? "in a region" : "along a line"}`), [ground.kind]: ground.to };
}

/** The edits that keep it: of a segment, or of a new one. A bent one that only this segment dances is changed itself. */
export function bendEdits(score: Score, material: Material, ground: Ground, put: Put): SingleEdit[] {
  const { list, segment } = material;
  const number = numberOf(score, material);
  const own = entries(score, list)[number - 1];
  if (segment && own && own["like"] !== undefined && (own["along"] !== undefined || own["into"] !== undefined) && usesIn(score, material) === 1) {
    return [{ do: "change", at: [list, number], value: { [ground.kind]: ground.to, [ground.kind === "into" ? "along" : "into"]: null } }];
  }
  const table = bentTable(score, material, ground);
  return [{ do: "insert", at: [list], value: table }, danceEdit(score, material, text(table, "name"), put)];
}

/** The edits that show its ways while it is dragged, from places that are known already. */
export function triedEdits(score: Score, material: Material, places: Place[], put: Put): SingleEdit[] {
  const name = freeName(score, "formation", "dragged");
  return [{ do: "insert", at: ["formation"], value: { name, shape: "places", points: places } }, danceEdit(score, material, name, put)];
}

function danceEdit(score: Score, { list, segment }: Material, name: string, put: Put): SingleEdit {
  if (segment) return { do: "set", at: ["segment", segment, list], value: name };
  const group = put.group && put.group !== "*" ? { group: put.group } : {};
  return { do: "insert", at: ["segment"], value: { ...placeInScore(score, put.start), measures: put.measures, ...group, [list]: name } };
}

function numberOf(score: Score, { list, name }: Material): number {
  return entries(score, list).findIndex((one) => text(one, "name").toLowerCase() === name.trim().toLowerCase()) + 1;
}

/** How often a formation or evolution is used: danced, begun with, or named by another one. */
function usesIn(score: Score, { list, name }: Material): number {
  const folded = name.trim().toLowerCase();
  const is = (entry: Entry, key: string): boolean => text(entry, key).trim().toLowerCase() === folded;
  const danced = list === "formation" ? usesOf(score, name) : { segments: entries(score, "segment").filter((one) => is(one, "evolution")), groups: [] };
  const others = (["formation", "evolution"] as const).flatMap((each) => entries(score, each)).filter((one) => ["like", "along", "into"].some((key) => is(one, key)));
  return danced.segments.length + danced.groups.length + others.length;
}

function freeName(score: Score, list: string, wished: string): string {
  const word = wished.replace(/[^\p{L}\p{N} ]+/gu, " ").replace(/ +/g, " ").trim().slice(0, 54);
  const known = new Set(entries(score, list).map((one) => text(one, "name").toLowerCase()));
  for (let count = 1; ; count++) {
    const name = count === 1 ? word : `${word} ${count}`;
    if (!known.has(name.toLowerCase())) return name;
  }
}

/** The dancers (from 1) that words mean: "*", names of groups and numbers, as "tide + 1-3"; null if they mean more than that. */
export function dancersIn(groups: Group[], words: string): number[] | null {
  const all = groups.reduce((sum, group) => sum + group.dancers, 0);
  const found = new Set<number>();
  for (const part of words.split("+").map((one) => one.trim())) {
    const [, low, high] = /^(\d+)(?:\s*-\s*(\d+))?$/.exec(part) ?? [];
    let [first, last] = part === "*" || part === "" ? [1, all] : low ? [Number(low), Number(high ?? low)] : [0, 0];
    let at = 0;
    for (const group of groups) {
      if (group.name.toLowerCase() === part.toLowerCase()) [first, last] = [at + 1, at + group.dancers];
      at += group.dancers;
    }
    if (!first || last > all) return null;
    for (let dancer = first; dancer <= last; dancer++) found.add(dancer);
  }
  return [...found].sort((a, b) => a - b);
}
