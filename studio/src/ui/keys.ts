// The keyboard of the studio: what each key does, in one table, which the help shows as well.
import { gapOf } from "../model/gap";
import type { Studio } from "../model/studio";
import { TIMELINE_SHORTCUTS } from "../view/timeline/shortcuts";

export interface Shortcut {
  keys: string;
  words: string;
  run: (studio: Studio) => void;
}

const GENERAL: Shortcut[] = [
  { keys: "Ctrl+Z", words: "undo", run: (studio) => void studio.doc.undo() },
  { keys: "Ctrl+Shift+Z", words: "redo", run: (studio) => void studio.doc.redo() },
  { keys: "Ctrl+Y", words: "redo", run: (studio) => void studio.doc.redo() },
  { keys: "Delete", words: "delete what is selected", run: (studio) => studio.doc.inTurn(() => void studio.removeSelected()) },
  { keys: "Backspace", words: "delete what is selected", run: (studio) => studio.doc.inTurn(() => void studio.removeSelected()) },
  { keys: "Escape", words: "select nothing; look at what is danced now", run: (studio) => { studio.select(null); studio.cursor.value = null; studio.range.value = null; studio.dancers.value = []; } },
  { keys: "Tab", words: "next row, handle or button", run: () => {} },
  { keys: "W", words: "compare the ways into the selected formation", run: (studio) => { studio.choosing.value = gapOf(studio.boxes.value, studio.selected.value) !== null; } },
  { keys: "G", words: "GO: the next cue", run: (studio) => studio.values.send("/dance/go") },
  { keys: "F6", words: "to the next part of the page", run: () => toPart(1) },
  { keys: "Shift+F6", words: "to the part before", run: () => toPart(-1) },
  { keys: "?", words: "these keys", run: (studio) => { studio.helping.value = true; } },
];

const SHORTCUTS = [...GENERAL, ...TIMELINE_SHORTCUTS];

type Words = Pick<Shortcut, "keys" | "words">;

/** What the keys do, with headings; those of the stage act while it has the focus. */
export const KEY_PAGES: [string, Words[]][] = [
  ["Everywhere", GENERAL],
  ["Timeline", TIMELINE_SHORTCUTS],
  ["Stage, when it has the focus", [
    { keys: "Arrows", words: "to the nearest dancer; with a tool: move its pen, with Shift a metre" },
    { keys: "Space", words: "select the dancer, or not; with a tool: put a point" },
    { keys: "Ctrl+A", words: "select everybody" },
    { keys: "Enter", words: "with a tool: put a point; twice at a place: the line ends" },
    { keys: "Backspace", words: "with a tool: take the last point back" },
  ]],
  ["Library", [{ keys: "Enter", words: "put it at the cursor, for the chosen row or the selected dancers" }, { keys: "Space", words: "look at it" }]],
  ["Handle of a group's motion", [{ keys: "Arrows", words: "choose the region or line to which it bends" }, { keys: "Enter", words: "keep it" }, { keys: "Escape", words: "let it be" }]],
  ["Diamond of a canon, handles, points", [{ keys: "Arrows", words: "move it" }, { keys: "Delete", words: "remove a point of a curve" }]],
];

/** Give the next part of the page the focus: its first control. */
function toPart(by: number): void {
  const parts = [...document.querySelectorAll<HTMLElement>("#app > header, main > section")];
  const here = parts.findIndex((part) => part.contains(document.activeElement));
  const next = parts[here < 0 ? (by > 0 ? 0 : parts.length - 1) : (here + by + parts.length) % parts.length];
  next?.querySelector<HTMLElement>("button:not([disabled]), input, select, [tabindex='0']")?.focus();
}

function name(event: KeyboardEvent): string {
  const key = event.key.length === 1 ? event.key.toUpperCase() : event.key;
  const shift = event.shiftKey && !["+", "?"].includes(event.key);
  return `${event.ctrlKey || event.metaKey ? "Ctrl+" : ""}${event.altKey ? "Alt+" : ""}${shift ? "Shift+" : ""}${key}`;
}

export function listen(studio: Studio): () => void {
  const onKey = (event: KeyboardEvent): void => {
    const target = event.target as HTMLElement;
    if (target.closest("dialog[open]") || (target.closest("input, textarea, select, [contenteditable]") && event.key !== "F6") || event.key === "Tab") return;
    const found = SHORTCUTS.find((one) => one.keys === name(event));
    if (!found || (target.closest("[role=slider]") && event.key.startsWith("Arrow"))) return;
    event.preventDefault();
    found.run(studio);
  };
  document.addEventListener("keydown", onKey);
  return () => document.removeEventListener("keydown", onKey);
}
