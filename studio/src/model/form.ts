// Forms: what the fields of entries are, what they hold, and the edits that change them. Pure.
import { fromHex, toHex } from "./colour";
import { entries, text, type Entry, type Score } from "./score";
import type { SingleEdit } from "./document";
import schema from "./schema.json";

export interface Field {
  key: string;
  words: string;
  /** "integer", "number", "text", "choice", "switch", "colour", "pair", "line", "numbers", "texts", "steps", "dancers", "json", or a list whose entry it names. */
  control: string;
  help: string;
  unit?: string;
  default?: unknown;
  choices?: (string | number)[];
  least?: number;
  most?: number;
  required?: boolean;
  folded?: boolean;
}

const SCHEMA = schema as unknown as Record<string, Field[]>;
/** Lists whose entries are called by their names: a new name goes wherever the old one stood. */
const NAMED = ["section", "group", "formation", "scene", "cue", "curve", "signal", "gate", "obstacle", "item", "view"];

export function fieldsOf(kind: string, entry: Entry): Field[] {
  const known = SCHEMA[kind] ?? [];
  const names = new Set(known.map((field) => field.key));
  const others = Object.keys(entry).filter((key) => !names.has(key));
  return [...known, ...others.map((key): Field => ({ key, words: key.replaceAll("_", " "), control: "json", help: "", folded: known.length > 0 }))];
}

export function isRenamed(kind: string, key: string): boolean {
  return key === "name" && NAMED.includes(kind);
}

/** What several entries hold in a key: the value if all have the same, and whether one has it written. */
export function common(all: Entry[], key: string): { value: unknown; same: boolean; written: boolean } {
  const [first] = all;
  const value = first?.[key];
  const said = JSON.stringify(value);
  return { value, same: all.every((one) => JSON.stringify(one[key]) === said), written: all.some((one) => one[key] !== undefined) };
}

/** The edits that give a key of entries a value; undefined removes it: its default holds again. */
export function fieldEdits(kind: string, numbers: number[], key: string, value: unknown): SingleEdit[] {
  return numbers.map((number): SingleEdit => {
    if (isRenamed(kind, key) && value !== undefined) return { do: "rename", at: [kind, number], value };
    return { do: "set", at: [kind, number, key], value: value ?? null };
  });
}

/** A number within the limits of its field; null if it is none. */
export function readNumber(field: Field, said: string): number | null {
  if (!said.trim()) return null;
  const value = Number(said.replace(",", "."));
  if (!Number.isFinite(value)) return null;
  const whole = field.control === "integer" ? Math.round(value) : value;
  return Math.min(field.most ?? Infinity, Math.max(field.least ?? -Infinity, whole));
}

/** How much a number changes for each step of a drag: one, or a hundredth of its range, or a tenth. */
export function dragStep(field: Field): number {
  if (field.control === "integer") return 1;
  const range = (field.most ?? Infinity) - (field.least ?? -Infinity);
  return range <= 2 ? 0.01 : 0.1;
}

/** A number that was dragged by some steps, within the limits of its field. */
export function dragged(field: Field, value: unknown, steps: number): number {
  const step = dragStep(field);
  const from = typeof value === "number" ? value : typeof field.default === "number" ? field.default : Math.max(field.least ?? 0, 0);
  const moved = Math.round((from + steps * step) / step) * step;
  return Math.min(field.most ?? Infinity, Math.max(field.least ?? -Infinity, Number(moved.toFixed(4))));
}

/** Numbers with commas or spaces between them; null if one of them is none. */
export function readNumbers(said: string): number[] | null {
  const parts = said.split(/[\s,;]+/).filter(Boolean).map(Number);
  return parts.every(Number.isFinite) ? parts : null;
}

/** A colour of a patch as #rrggbb: linear numbers, or a text, which is a word of the web, #rgb or #rrggbb. */
export function hexOf(colour: unknown): string {
  if (Array.isArray(colour)) return toHex(colour.map(Number));
  if (typeof colour !== "string") return "#808080";
  if (/^#[0-9a-f]{3}$/i.test(colour)) return `#${[...colour.slice(1)].map((digit) => digit + digit).join("")}`.toLowerCase();
  if (/^#[0-9a-f]{6}$/i.test(colour)) return colour.toLowerCase();
  const pen = typeof document === "undefined" ? null : document.createElement("canvas").getContext("2d");
  if (!pen) return "#808080";
  pen.fillStyle = "#808080"; // stays if the word is none
  pen.fillStyle = colour;
  return /^#[0-9a-f]{6}$/.test(String(pen.fillStyle)) ? String(pen.fillStyle) : "#808080";
}

/** The linear numbers that a patch has for #rrggbb. */
export const colourOfHex = fromHex;

/** The names that a field may have: of the entries of a list. */
export function namesOf(score: Score, list: string): string[] {
  const more = list === "section" ? ["end"] : [];
  const shapes = list === "formation" ? ["line", "circle", "grid", "triangle", "star", "spiral", "diagonal", "semicircle"] : [];
  return [...new Set([...entries(score, list).map((entry) => text(entry, "name")), ...more, ...shapes])].filter(Boolean);
}

/** Words for dancers: groups, attributes and places; those of a selection are joined by "+". */
export function dancerWords(score: Score): string[] {
  const groups = entries(score, "group");
  const attributes = groups.flatMap((group) => (Array.isArray(group["attributes"]) ? (group["attributes"] as string[]) : []));
  const own = Object.keys((score["selections"] as object | undefined) ?? {});
  return [...new Set([...groups.map((group) => text(group, "name")), ...own, ...attributes, "soloist", "left", "right", "front", "back", "centre"])];
}

/** A selection as a label: numbers alone are told to be dancers. */
export function wordsOfDancers(selection: string): string {
  if (!/^[\d\s+-]+$/.test(selection)) return selection;
  return `${/^\d+$/.test(selection.trim()) ? "dancer" : "dancers"} ${selection.trim().replaceAll(" + ", ", ").replaceAll("-", "–")}`;
}

/** A selection with a word more, or without it. */
export function toggled(selection: string, word: string): string {
  const parts = selection.split("+").map((part) => part.trim()).filter((part) => part && part !== "*");
  const low = word.toLowerCase();
  const left = parts.filter((part) => part.toLowerCase() !== low);
  if (left.length === parts.length) left.push(word);
  return left.join(" + ") || "*";
}

export interface WrittenStep {
  name: string;
  times: number;
}

/** The steps of a sequence as they are written, each with how often. */
export function readSteps(steps: unknown): WrittenStep[] {
  if (!Array.isArray(steps)) return [];
  return (steps as string[]).flatMap((words) => String(words).split(",")).map((part) => {
    const [, name = "", times] = /^\s*(.*?)(?:\s+x(\d+))?\s*$/.exec(part) ?? [];
    return { name, times: Number(times ?? 1) };
  });
}

export function writeSteps(steps: WrittenStep[]): string[] {
  return steps.filter((step) => step.name.trim()).map((step) => (step.times > 1 ? `${step.name.trim()} x${step.times}` : step.name.trim()));
}
