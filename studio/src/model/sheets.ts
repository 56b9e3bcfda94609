// Sheets of a show as the engine lays them out: pages of lines, shapes and words in points, and the scenes that they show.
import { allBoxes, sectionSpans, type Box } from "./plan";
import type { Structure } from "./score";

export type Paper = "a4" | "letter";

/** What is drawn, in order: a kind, and its values. Points are x, y, x, y, …; inks are "#rrggbb" or null. */
export type SheetItem =
  | ["stroke", number[], number, string, number]
  | ["shape", number[], string | null, string | null, number]
  | ["disc", number, number, number, string | null, string | null, number]
  | ["words", number, number, number, number, string, 0 | 1, string, "l" | "m" | "r"];

export interface SheetPage {
  width: number;
  height: number;
  items: SheetItem[];
  /** Number of a scene, from 1, and where it stands: x, y, width, height. */
  areas: [number, number, number, number, number][];
}

export interface SheetScene {
  words: string;
  section: string;
  /** From 1, within the section if there is one. */
  measure: number;
  measures: number;
}

export interface Sheets {
  paper: Paper;
  /** Whose sheets they are; null: the storyboard. */
  dancer: number | null;
  /** All who are ever on the stage, from 1. */
  dancers: number[];
  scenes: SheetScene[];
  pages: SheetPage[];
  document: number;
}

const MOVES = ["segment", "element"];

/** Where a scene begins, in measures of the written score from 0; -1 if its section is gone. */
export function sceneStart(structure: Structure, scene: SheetScene): number {
  if (!scene.section) return scene.measure - 1;
  const span = sectionSpans(structure.score).find((one) => one.name.toLowerCase() === scene.section.toLowerCase());
  return span ? span.first + scene.measure - 1 : -1;
}

/** What a scene shows: the first segment or element that begins in it, or else one that goes on; null: only steps. */
export function sceneBox(structure: Structure, scene: SheetScene): Box | null {
  const first = sceneStart(structure, scene);
  const end = first + scene.measures;
  const moves = allBoxes(structure).filter((box) => MOVES.includes(box.list) && box.start < end && box.start + box.length > first);
  const rank = (box: Box): number => (box.start >= first ? box.start - first : 1000) + (box.list === "segment" ? 0 : 0.5);
  return moves.sort((one, other) => rank(one) - rank(other))[0] ?? null;
}

/** x, y, x, y, … as SVG's "x,y x,y …". */
export function svgPoints(flat: number[]): string {
  const pairs: string[] = [];
  for (let at = 0; at + 1 < flat.length; at += 2) pairs.push(`${flat[at]},${flat[at + 1]}`);
  return pairs.join(" ");
}

/** The name of a file with all sheets of a show. */
export function sheetsFile(name: string): string {
  const word = name.toLowerCase().replace(/[^a-z0-9]+/g, "-").replace(/^-|-$/g, "").slice(0, 60);
  return `${word || "show"}-sheets.pdf`;
}
