// Pads for improvising: what can be launched for a column of dancers, and what a launch says to the engine.
import { entries, text, type Structure } from "./score";
import type { Value } from "../net/values";

export type Kind = "steps" | "formations" | "elements" | "looks";
export type Launch = "now" | "measure";

export interface Pad {
  kind: Kind;
  name: string;
  /** What it does, in a word or two. */
  words: string;
}

export interface Column {
  /** A selection; "*" for everybody. */
  who: string;
  label: string;
  group: number;
}

export interface Launched {
  pad: Pad;
  who: string;
  /** Danced measure (from 1) in which it begins, and the one after its last. */
  begins: number;
  ends: number;
}

const SHAPES = ["line", "circle", "grid", "triangle", "star", "diagonal", "spiral"];
const ELEMENTS: [string, string][] = [
  ["attract", "gather in the middle"], ["repel", "away from the middle"], ["spread", "spread out"], ["cross", "change sides"], ["wander", "wander"], ["flock", "as a flock"], ["pause", "stay"],
];

export function columns(structure: Structure, dancers: number[]): Column[] {
  const groups = structure.groups.map((group, index) => ({ who: group.name, label: group.name, group: index }));
  const chosen = dancers.length ? [{ who: dancers.join(" + "), label: `${dancers.length} selected`, group: -1 }] : [];
  return [{ who: "*", label: "everybody", group: -1 }, ...groups, ...chosen];
}

export function pads(structure: Structure, kind: Kind): Pad[] {
  switch (kind) {
    case "steps":
      return structure.library.map((step) => ({ kind, name: step.name, words: step.measures === 1 ? "1 measure" : `${step.measures} measures` }));
    case "formations": {
      const own = entries(structure.score, "formation").map((entry) => ({ kind, name: text(entry, "name"), words: "of this show" }));
      return [...own, ...SHAPES.filter((name) => !own.some((one) => one.name.toLowerCase() === name)).map((name) => ({ kind, name, words: "" }))];
    }
    case "elements":
      return ELEMENTS.map(([name, words]) => ({ kind, name, words }));
    case "looks":
      return [
        ...entries(structure.score, "scene").map((entry) => ({ kind, name: text(entry, "name"), words: "scene" })),
        ...entries(structure.score, "cue").map((entry) => ({ kind, name: text(entry, "name"), words: "cue" })),
      ];
  }
}

/** The control and its values that launch a pad for some dancers and measures. */
export function call(pad: Pad, who: string, launch: Launch, measures: number): [string, ...Value[]] {
  const next = launch === "measure";
  switch (pad.kind) {
    case "steps":
      return next ? ["/dance/step", pad.name, measures, who] : ["/dance/now", pad.name, who, measures];
    case "formations":
      return ["/dance/formation", pad.name, measures, who, next];
    case "looks":
      return [pad.words === "cue" ? "/dance/cue" : "/dance/scene", pad.name];
    case "elements":
      switch (pad.name) {
        case "attract":
        case "repel":
          return [`/dance/${pad.name}`, 0, 0, 1, measures, who, next];
        case "cross":
          return ["/dance/cross", 0, -2, 0, 2, 1, measures, who, next];
        case "wander":
        case "flock":
          return [`/dance/${pad.name}`, 1, measures, who, next];
        default:
          return [`/dance/${pad.name}`, measures, who, next];
      }
  }
}

/** What a launch in a danced measure (from 1) begins and ends. */
export function launched(pad: Pad, who: string, launch: Launch, measures: number, measure: number): Launched {
  const begins = launch === "measure" ? measure + 1 : measure;
  return { pad, who, begins, ends: begins + measures };
}

export type State = "waits" | "runs" | "idle";

/** What a pad of a column does in a measure, by what was launched; the latest counts for its dancers and kind. */
export function stateOf(pad: Pad, who: string, all: Launched[], measure: number): State {
  const last = all.findLast((one) => one.who === who && one.pad.kind === pad.kind && one.begins <= measure);
  const waits = all.some((one) => one.who === who && one.pad.kind === pad.kind && one.pad.name === pad.name && one.begins > measure);
  if (waits) return "waits";
  return last && last.pad.name === pad.name && last.ends > measure ? "runs" : "idle";
}
