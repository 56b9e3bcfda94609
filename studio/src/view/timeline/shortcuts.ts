// What keys do in the timeline; the table of all keys shows them as well.
import { copied, hasDancers, joinEdits, moveEdits, pasteEdits, placeKeys, resizeEdits, splitEdits, unitOf, FIXED } from "../../model/arrange";
import type { Box, Row } from "../../model/plan";
import type { Shortcut } from "../../ui/keys";
import type { Studio } from "../../model/studio";
import { timelineOf } from "./state";

const PHRASE = 8;

/** The measure at which things are put: the cursor, or where the show is danced. */
export function putAt(studio: Studio): number {
  return studio.cursor.value ?? Math.floor(studio.playhead.value ?? 0);
}

/** The dancers of the selected row; null: none is selected. */
export function rowDancers(studio: Studio): string | null {
  return studio.rows.value.find((row) => row.id === studio.row.value)?.selection ?? null;
}

function step(studio: Studio): number {
  return studio.snap.value === "beat" ? 1 / studio.beats.value : studio.snap.value === "none" ? 1 / 16 : 1;
}

/** Another box of the same row, or the cursor by a step if none is selected. */
function along(studio: Studio, by: number): void {
  const [one] = studio.chosenBoxes();
  if (!one) {
    studio.cursor.value = Math.max(0, putAt(studio) + by * step(studio));
    return;
  }
  const state = timelineOf(studio);
  const row = state.rows.value[state.rowOf(one)];
  const sorted = [...(row?.boxes ?? [])].sort((a, b) => a.start - b.start || (row?.lane.get(a) ?? 0) - (row?.lane.get(b) ?? 0));
  show(studio, sorted[sorted.findIndex((box) => box.list === one.list && box.number === one.number) + by]);
}

/** The nearest box of the next row that has some. */
function across(studio: Studio, by: number): void {
  const [one] = studio.chosenBoxes();
  const state = timelineOf(studio);
  const rows = state.rows.value;
  const at = one ? one.start : putAt(studio);
  let index = one ? state.rowOf(one) : by > 0 ? -1 : rows.length;
  for (index += by; index >= 0 && index < rows.length; index += by) {
    const boxes = rows[index]?.kind === "danced" ? [] : (rows[index]?.boxes ?? []);
    if (boxes.length) {
      show(studio, boxes.reduce((near, box) => (Math.abs(box.start - at) < Math.abs(near.start - at) ? box : near)));
      return;
    }
  }
}

function show(studio: Studio, box: Box | undefined): void {
  if (!box) return;
  const state = timelineOf(studio);
  studio.select(box);
  state.reveal(box);
  state.focus(box);
}

function nudge(studio: Studio, sign: number): void {
  const boxes = studio.chosenBoxes().filter((box) => !FIXED.includes(box.list));
  const by = sign * Math.max(0, ...boxes.map((box) => unitOf(box.list, studio.snap.value, studio.beats.value)));
  if (boxes.length && Math.min(...boxes.map((box) => box.start)) + by >= 0) void studio.doc.edits(moveEdits(boxes, by, () => null, false, studio.ground.value));
}

function toRow(studio: Studio, sign: number): void {
  const state = timelineOf(studio);
  const boxes = studio.chosenBoxes().filter((box) => hasDancers(box.list));
  if (boxes.length) void studio.doc.edits(state.editsOf({ kind: "move", boxes, from: 0, by: 0, rows: sign, copy: false }));
}

function resize(studio: Studio, by: number): void {
  const boxes = studio.chosenBoxes();
  const sections = studio.selected.value.filter((one) => one.list === "section");
  void studio.doc.edits([
    ...resizeEdits(boxes, by, "end", studio.ground.value),
    ...sections.flatMap((one) => {
      const measures = Number(studio.entry(one)?.["measures"] ?? 8) + by;
      return measures >= 1 ? [{ do: "resize" as const, at: [one.list, one.number], value: measures }] : [];
    }),
  ]);
}

export function duplicate(studio: Studio): void {
  const boxes = studio.chosenBoxes().filter((box) => !FIXED.includes(box.list));
  if (!boxes.length) return;
  const later = Math.max(...boxes.map((box) => box.start + Math.max(box.length, 1))) - Math.min(...boxes.map((box) => box.start));
  void studio.doc.edits(moveEdits(boxes, Math.ceil(later), () => null, true, studio.ground.value));
}

export function copy(studio: Studio): void {
  const boxes = studio.chosenBoxes();
  if (boxes.length) studio.clipboard.value = copied(boxes);
}

export async function paste(studio: Studio): Promise<void> {
  const kept = studio.clipboard.value;
  if (!kept.length) return;
  const before = new Map(kept.map((one) => [one.list, ((studio.score.peek()[one.list] as unknown[] | undefined) ?? []).length]));
  const answer = await studio.doc.edits(pasteEdits(kept, putAt(studio), rowDancers(studio), studio.ground.value));
  if (answer.refused) return;
  studio.selected.value = kept.map((one) => {
    const number = (before.get(one.list) ?? 0) + 1;
    before.set(one.list, number);
    return { list: one.list, number };
  });
}

export function split(studio: Studio): void {
  told(studio, splitEdits(studio.chosenBoxes(), putAt(studio), studio.ground.value));
}

export function join(studio: Studio): void {
  told(studio, joinEdits(studio.chosenBoxes(), studio.ground.value));
}

function told(studio: Studio, edits: ReturnType<typeof splitEdits>): void {
  if (typeof edits === "string") studio.doc.tell("told", edits);
  else void studio.doc.edits(edits);
}

function selectAll(studio: Studio): void {
  const row = studio.rows.value.find((one) => one.id === studio.row.value);
  const rows = row ? [row] : studio.rows.value.filter((one) => one.kind === "group" || one.kind === "part");
  studio.selected.value = rows.flatMap((one) => one.boxes.map(({ list, number }) => ({ list, number })));
}

/** After all that was sent before, so that quick presses add up. */
function inTurn(act: (studio: Studio) => void): (studio: Studio) => void {
  return (studio) => studio.doc.inTurn(() => act(studio));
}

/** Where a measure of the written score (from 0) lies: in its section, if there are sections. */
export function placeOf(studio: Studio, measure: number): { measure: number; section?: string } {
  return placeKeys("segment", measure, studio.ground.peek()) as { measure: number; section?: string };
}

/** Begin a box on a row: a signal, a call, a formation or steps. */
export async function addHere(studio: Studio, row: Row, measure: number): Promise<void> {
  const place = placeOf(studio, measure);
  const group = row.selection === null ? {} : { group: row.selection };
  if (row.kind === "signals") await studio.insert("signal", { ...place, name: `signal ${measure + 1}` });
  else if (row.kind === "calls") await studio.insert("at", { ...place, call: "/dance/light/level", values: [1.0] });
  else if (studio.mode.value === "motion") await studio.insert("segment", { ...place, ...group, measures: 4, formation: "circle" });
  else await studio.insert("sequence", { ...place, ...group, steps: [studio.doc.structure.value?.library[0]?.name ?? "walk"] });
}

/** A box at the cursor, on the chosen row. */
function addAtCursor(studio: Studio): void {
  const row = studio.rows.value.find((one) => one.id === studio.row.value);
  if (!row || row.kind === "curve") studio.doc.tell("told", "Choose a row first, by its name.");
  else void addHere(studio, row, Math.floor(putAt(studio))).then(() => { const [box] = studio.chosenBoxes(); show(studio, box); });
}

/** The cursor by so many measures. */
function leap(studio: Studio, by: number): void {
  studio.select(null);
  studio.cursor.value = Math.min(Math.max(0, Math.floor(putAt(studio)) + by), studio.length.value - 1);
}

export const TIMELINE_SHORTCUTS: Shortcut[] = [
  { keys: "ArrowLeft", words: "the box before; without one, the cursor earlier", run: (studio) => along(studio, -1) },
  { keys: "ArrowRight", words: "the next box; without one, the cursor later", run: (studio) => along(studio, 1) },
  { keys: "ArrowUp", words: "a box of the row above", run: (studio) => across(studio, -1) },
  { keys: "ArrowDown", words: "a box of the row below", run: (studio) => across(studio, 1) },
  { keys: "Alt+ArrowLeft", words: "move what is selected earlier", run: inTurn((studio) => nudge(studio, -1)) },
  { keys: "Alt+ArrowRight", words: "move what is selected later", run: inTurn((studio) => nudge(studio, 1)) },
  { keys: "Alt+ArrowUp", words: "give it to the row above", run: inTurn((studio) => toRow(studio, -1)) },
  { keys: "Alt+ArrowDown", words: "give it to the row below", run: inTurn((studio) => toRow(studio, 1)) },
  { keys: "Shift+ArrowLeft", words: "shorter", run: inTurn((studio) => resize(studio, -1)) },
  { keys: "Shift+ArrowRight", words: "longer", run: inTurn((studio) => resize(studio, 1)) },
  { keys: "Ctrl+A", words: "select all of the row", run: selectAll },
  { keys: "Ctrl+C", words: "copy", run: copy },
  { keys: "Ctrl+X", words: "cut", run: inTurn((studio) => { copy(studio); void studio.removeSelected(); }) },
  { keys: "Ctrl+V", words: "paste at the cursor", run: inTurn((studio) => void paste(studio)) },
  { keys: "Ctrl+D", words: "repeat what is selected behind itself", run: inTurn(duplicate) },
  { keys: "S", words: "split at the cursor", run: inTurn(split) },
  { keys: "J", words: "join the selected boxes", run: inTurn(join) },
  { keys: "P", words: "name the phrase that begins at the cursor", run: (studio) => { timelineOf(studio).phrase.value = Math.floor(putAt(studio)); } },
  { keys: "+", words: "zoom in", run: (studio) => timelineOf(studio).zoom(1.25) },
  { keys: "-", words: "zoom out", run: (studio) => timelineOf(studio).zoom(0.8) },
  { keys: "0", words: "the whole show", run: (studio) => timelineOf(studio).fit(0, studio.length.value) },
  { keys: "PageUp", words: "the cursor eight measures earlier", run: (studio) => leap(studio, -PHRASE) },
  { keys: "PageDown", words: "the cursor eight measures later", run: (studio) => leap(studio, PHRASE) },
  { keys: "N", words: "a new box on the chosen row, at the cursor", run: addAtCursor },
  { keys: "Home", words: "the cursor at the beginning", run: (studio) => { studio.cursor.value = 0; timelineOf(studio).element?.scrollTo({ left: 0 }); } },
  { keys: "1", words: "steps", run: (studio) => { studio.mode.value = "steps"; } },
  { keys: "2", words: "group motion", run: (studio) => { studio.mode.value = "motion"; } },
];
