// The show as the engine tells it: its structure, and how each change makes the next one. Plain values, no page.

export interface Group {
  name: string;
  dancers: number;
  colour: [number, number, number];
}

export interface Step {
  name: string;
  measures: number;
}

/** An entry of a list of the score, as it is written in the show's file. */
export type Entry = Record<string, unknown>;
export type Score = Record<string, unknown>;

export interface Structure {
  revision: number;
  groups: Group[];
  library: Step[];
  score: Score;
}

export interface Shift {
  list: string;
  /** From 1; null: nowhere. */
  from: number | null;
  to: number | null;
}

export interface Change {
  revision: number;
  what: string;
  by: string;
  of: number | null;
  edit: { do: string; at: (string | number)[]; value: unknown } | null;
  shifts: Shift[];
  entries: { at: [string] | [string, number]; value: unknown }[] | null;
  groups?: Group[];
}

export const LISTS = ["segment", "sequence", "improvise", "element", "signal", "curve", "at", "regroup", "section", "formation", "evolution", "scene", "cue", "pad", "group", "view", "gate", "obstacle", "item", "react"] as const;
export type ListName = (typeof LISTS)[number];

export function entries(score: Score, list: string): Entry[] {
  const found = score[list];
  return Array.isArray(found) ? (found as Entry[]) : [];
}

/** The structure after a change; null if the change does not say all, and the whole structure comes. */
export function applyChange(before: Structure, change: Change): Structure | null {
  if (change.revision !== before.revision + 1 || change.entries === null) return null;
  const score: Score = { ...before.score };
  const copies = new Set<string>();
  const rows = (list: string): Entry[] => {
    if (!copies.has(list)) {
      copies.add(list);
      score[list] = [...entries(score, list)];
    }
    return score[list] as Entry[];
  };
  for (const { list, from, to } of change.shifts) {
    const all = rows(list);
    const moved = from === null ? [{}] : all.splice(from - 1, 1);
    if (to !== null) all.splice(to - 1, 0, moved[0] ?? {});
  }
  for (const { at, value } of change.entries) {
    const [name, number] = at;
    if (number !== undefined) rows(name)[number - 1] = value as Entry;
    else if (value === null) delete score[name];
    else score[name] = value;
  }
  for (const list of copies) if (!entries(score, list).length) delete score[list]; // as the engine tells it
  return { ...before, revision: change.revision, groups: change.groups ?? before.groups, score };
}

export function text(entry: Entry, key: string, otherwise = ""): string {
  const value = entry[key];
  return typeof value === "string" ? value : otherwise;
}

export function number(entry: Entry, key: string, otherwise: number): number {
  const value = entry[key];
  return typeof value === "number" ? value : otherwise;
}
