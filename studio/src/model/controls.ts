// Controls in words: what can be called at a beat, or when a signal comes; and how an entry of the score names it. Pure.
import { controlWords } from "./plan";
import { text, type Entry } from "./score";
import type { Surface, Value, Widget } from "../net/values";

export interface Choice {
  /** The page of the control surface, and the control's name on it. */
  page: string;
  words: string;
  /** What it does. */
  help: string;
  widget: Widget;
}

/** Pages with controls of the machine or of one evening: nothing that a score calls. */
const NOT_IN_SCORES = ["midi", "breaker", "latency", "audio", "output", "document", "clock"];
/** Nor these, of the pages that are left. */
const NOT_CALLED = /^\/dance\/(why|undo|redo|back|practice|takeover|voice|partner\/path)$/;

export function nameOf(widget: Widget): string {
  return widget.label.replaceAll("_", " ");
}

/** What a score can call, in the order of the surface. */
export function choicesOf(surface: Surface | null): Choice[] {
  return (surface?.pages ?? []).filter((page) => !NOT_IN_SCORES.includes(page.title)).flatMap((page) =>
    page.widgets.filter((widget) => !NOT_CALLED.test(widget.address)).map((widget) => ({ page: page.title, words: nameOf(widget), help: widget.words, widget })));
}

/** The choices in which all of the words are found. */
export function found(choices: Choice[], wanted: string): Choice[] {
  const words = wanted.toLowerCase().split(/\s+/).filter(Boolean);
  return choices.filter((one) => words.every((word) => `${one.page} ${one.words} ${one.help}`.toLowerCase().includes(word)));
}

/** The choice that an entry names; undefined: none of them, or no control at all. */
export function choiceOf(choices: Choice[], entry: Entry): Choice | undefined {
  const address = text(entry, "call");
  const values = JSON.stringify(valuesOf(entry));
  const same = choices.filter((one) => one.widget.address === address);
  return same.find((one) => JSON.stringify(one.widget.values) === values) ?? same.find((one) => !one.widget.values.length) ?? same[0];
}

export function valuesOf(entry: Entry): Value[] {
  const values = entry["values"];
  return Array.isArray(values) ? (values as Value[]) : [];
}

/** The keys of an entry that calls a control, with the values that it begins with. */
export function calling({ widget }: Choice): { call: string; values: Value[] } {
  const begins: Record<Widget["kind"], Value[]> = {
    fader: [widget.start[0] ?? widget.maximum[0] ?? 1], colour: widget.start.length ? widget.start : [1, 1, 1], button: widget.values, toggle: [1], pad: [0, 0],
  };
  return { call: widget.address, values: begins[widget.kind] };
}

/** A control with its values, in a line: "light level 0.5". */
export function wordsOfCall(choices: Choice[], entry: Entry): string {
  const choice = choiceOf(choices, entry);
  if (!choice) return controlWords(text(entry, "call"));
  return choice.page === "show" || choice.page === "stage" ? choice.words : `${choice.page}: ${choice.words}`;
}
