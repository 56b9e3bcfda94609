// The keyboard of the studio: what each key does, in one table, which the help shows as well.
import { gapOf } from "../model/gap";
import type { Studio } from "../model/studio";
import { TIMELINE_SHORTCUTS } from "../view/timeline/shortcuts";

export interface Shortcut {
  keys: string;
  words: string;
  run: (studio: Studio) => void;
}

export const SHORTCUTS: Shortcut[] = [
  { keys: "Ctrl+Z", words: "undo", run: (studio) => void studio.doc.undo() },
  { keys: "Ctrl+Shift+Z", words: "redo", run: (studio) => void studio.doc.redo() },
  { keys: "Ctrl+Y", words: "redo", run: (studio) => void studio.doc.redo() },
  { keys: "Delete", words: "delete what is selected", run: (studio) => studio.doc.inTurn(() => void studio.removeSelected()) },
  { keys: "Backspace", words: "delete what is selected", run: (studio) => studio.doc.inTurn(() => void studio.removeSelected()) },
  { keys: "Escape", words: "select nothing; look at what is danced now", run: (studio) => { studio.select(null); studio.cursor.value = null; studio.range.value = null; studio.dancers.value = []; } },
  { keys: "Tab", words: "next row, handle or button", run: () => {} },
  { keys: "W", words: "compare the ways into the selected formation", run: (studio) => { studio.choosing.value = gapOf(studio.boxes.value, studio.selected.value) !== null; } },
  { keys: "G", words: "GO: the next cue", run: (studio) => studio.values.send("/dance/go") },
  ...TIMELINE_SHORTCUTS,
];

function name(event: KeyboardEvent): string {
  const key = event.key.length === 1 ? event.key.toUpperCase() : event.key;
  const shift = event.shiftKey && event.key !== "+";
  return `${event.ctrlKey || event.metaKey ? "Ctrl+" : ""}${event.altKey ? "Alt+" : ""}${shift ? "Shift+" : ""}${key}`;
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
