// The keyboard of the studio: what each key does, in one table, which the help shows as well.
import { gapOf } from "../model/gap";
import type { Studio } from "../model/studio";

export interface Shortcut {
  keys: string;
  words: string;
  run: (studio: Studio) => void;
}

const step = (studio: Studio): number => (studio.snap.value === "beat" ? 1 / studio.beats.value : 1);

function move(studio: Studio, by: number): void {
  const edits = studio.selected.value.flatMap((one) => {
    const entry = studio.entry(one);
    const measure = Number(entry?.["measure"] ?? 1);
    const wanted = measure + (one.list === "element" ? by : Math.sign(by) * Math.max(1, Math.abs(by)));
    return wanted >= 1 ? [{ do: "move" as const, at: [one.list, one.number], value: wanted }] : [];
  });
  if (edits.length) void studio.doc.edits(edits);
  else studio.cursor.value = Math.max(0, (studio.cursor.value ?? Math.floor(studio.playhead.value ?? 0)) + by);
}

function resize(studio: Studio, by: number): void {
  const edits = studio.selected.value.flatMap((one) => {
    const length = studio.box(one)?.length ?? 1;
    return length + by > 0 && !["at", "signal", "regroup", "curve"].includes(one.list)
      ? [{ do: "resize" as const, at: [one.list, one.number], value: Math.round(length + by) }]
      : [];
  });
  if (edits.length) void studio.doc.edits(edits);
}

export const SHORTCUTS: Shortcut[] = [
  { keys: "Ctrl+Z", words: "undo", run: (studio) => void studio.doc.undo() },
  { keys: "Ctrl+Shift+Z", words: "redo", run: (studio) => void studio.doc.redo() },
  { keys: "Ctrl+Y", words: "redo", run: (studio) => void studio.doc.redo() },
  { keys: "Delete", words: "delete what is selected", run: (studio) => void studio.removeSelected() },
  { keys: "Backspace", words: "delete what is selected", run: (studio) => void studio.removeSelected() },
  { keys: "Ctrl+D", words: "repeat what is selected behind itself", run: (studio) => void studio.copySelected(longest(studio)) },
  { keys: "ArrowLeft", words: "earlier", run: (studio) => move(studio, -step(studio)) },
  { keys: "ArrowRight", words: "later", run: (studio) => move(studio, step(studio)) },
  { keys: "Shift+ArrowLeft", words: "shorter", run: (studio) => resize(studio, -1) },
  { keys: "Shift+ArrowRight", words: "longer", run: (studio) => resize(studio, 1) },
  { keys: "Escape", words: "select nothing; look at what is danced now", run: (studio) => { studio.select(null); studio.cursor.value = null; studio.dancers.value = []; } },
  { keys: "+", words: "zoom in", run: (studio) => { studio.scale.value = Math.min(studio.scale.value * 1.25, 480); } },
  { keys: "-", words: "zoom out", run: (studio) => { studio.scale.value = Math.max(studio.scale.value / 1.25, 4); } },
  { keys: "Tab", words: "next box, handle or button", run: () => {} },
  { keys: "1", words: "steps", run: (studio) => { studio.mode.value = "steps"; } },
  { keys: "2", words: "group motion", run: (studio) => { studio.mode.value = "motion"; } },
  { keys: "W", words: "compare the ways into the selected formation", run: (studio) => { studio.choosing.value = gapOf(studio.boxes.value, studio.selected.value) !== null; } },
  { keys: "G", words: "GO: the next cue", run: (studio) => studio.values.send("/dance/go") },
];

function longest(studio: Studio): number {
  return Math.max(1, ...studio.selected.value.map((one) => Math.ceil(studio.box(one)?.length ?? 1)));
}

function name(event: KeyboardEvent): string {
  const key = event.key.length === 1 ? event.key.toUpperCase() : event.key;
  const shift = event.shiftKey && event.key !== "+";
  return `${event.ctrlKey || event.metaKey ? "Ctrl+" : ""}${shift ? "Shift+" : ""}${key}`;
}

export function listen(studio: Studio): () => void {
  const onKey = (event: KeyboardEvent): void => {
    const target = event.target as HTMLElement;
    if (target.closest("input, textarea, select, [contenteditable], dialog[open]") || event.key === "Tab") return;
    const found = SHORTCUTS.find((one) => one.keys === name(event));
    if (!found || (target.closest("[role=slider]") && event.key.startsWith("Arrow"))) return;
    event.preventDefault();
    found.run(studio);
  };
  document.addEventListener("keydown", onKey);
  return () => document.removeEventListener("keydown", onKey);
}
