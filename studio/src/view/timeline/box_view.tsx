import { useSignal } from "@preact/signals";
import type { Studio } from "../../model/studio";
import type { Box } from "../../model/plan";

/** Height of a lane [px]. */
export const LANE = 26;
const EDGE = 8;
const FIXED = ["at", "signal", "regroup", "curve"];

interface Drag {
  kind: "move" | "begin" | "end";
  x: number;
  /** Measures that it has been moved, or has become longer. */
  by: number;
  copy: boolean;
}

/** A box of the timeline. It is dragged to move it, at its edges to resize it; with Alt it is copied. */
export function BoxView({ studio, box, lane, colour, group }: { studio: Studio; box: Box; lane: number; colour: string; group: number }) {
  const drag = useSignal<Drag | null>(null);
  const now = drag.value;
  const start = box.start + (now && now.kind !== "end" ? now.by : 0);
  const length = box.length + (now?.kind === "end" ? now.by : now?.kind === "begin" ? -now.by : 0);
  const chosen = studio.isSelected(box);
  const isPoint = box.length === 0;
  return (
    <button
      class={`box ${box.list}${isPoint ? " point" : ""}${now ? " held" : ""}`}
      aria-pressed={chosen}
      aria-label={`${words(box)}, measure ${format(start + 1)}${isPoint ? "" : `, ${format(length)} long`}`}
      title={words(box)}
      style={{ "--start": start, "--length": Math.max(length, 0), top: `${3 + lane * LANE}px`, ...(group >= 0 && box.list === "sequence" ? { "--box": colour } : {}) }}
      onPointerDown={(event) => {
        if (event.button !== 0) return;
        const target = event.currentTarget as HTMLElement;
        if (!chosen || event.shiftKey) studio.select(box, event.shiftKey || event.ctrlKey || event.metaKey);
        target.setPointerCapture(event.pointerId);
        const inside = event.clientX - target.getBoundingClientRect().left;
        const width = target.offsetWidth;
        const fixed = FIXED.includes(box.list);
        const kind = !fixed && width > 3 * EDGE && inside > width - EDGE ? "end" : !fixed && width > 3 * EDGE && inside < EDGE ? "begin" : "move";
        drag.value = { kind, x: event.clientX, by: 0, copy: event.altKey };
      }}
      onPointerMove={(event) => {
        if (!now) return;
        const by = snapped(studio, box, (event.clientX - now.x) / studio.scale.value);
        const limit = now.kind === "move" ? -box.start : now.kind === "end" ? -box.length + smallest(studio, box) : -box.start;
        const most = now.kind === "begin" ? box.length - smallest(studio, box) : Infinity;
        drag.value = { ...now, by: Math.min(Math.max(by, limit), most), copy: event.altKey };
      }}
      onPointerUp={() => {
        drag.value = null;
        if (now && now.by !== 0) void finish(studio, box, now);
      }}
      onPointerCancel={() => { drag.value = null; }}
      onClick={(event) => {
        if (event.detail === 0) studio.select(box, event.shiftKey); // by keyboard
      }}
    >
      <span>{box.label}</span>
    </button>
  );
}

function words(box: Box): string {
  const kinds: Record<string, string> = { segment: "formation", sequence: "steps", at: "call", element: "element", improvise: "improvisation" };
  return `${kinds[box.list] ?? box.list}: ${box.label}${box.group && box.group !== "*" ? ` (${box.group})` : ""}`;
}

function format(measure: number): string {
  return String(Math.round(measure * 100) / 100);
}

/** Whole measures for what begins at measure lines only. */
function grid(studio: Studio, box: Box): number {
  const fine = ["element", "at", "signal"].includes(box.list);
  if (!fine) return 1;
  return studio.snap.value === "measure" ? 1 : studio.snap.value === "beat" ? 1 / studio.beats.value : 1 / 64;
}

function smallest(studio: Studio, box: Box): number {
  return box.list === "element" ? grid(studio, box) : 1;
}

function snapped(studio: Studio, box: Box, by: number): number {
  const unit = grid(studio, box);
  return Math.round(by / unit) * unit;
}

async function finish(studio: Studio, box: Box, drag: Drag): Promise<void> {
  const chosen = studio.selected.value.length ? studio.selected.value : [box];
  if (drag.kind === "move") {
    const edits = chosen.flatMap((one) => {
      const entry = studio.entry(one);
      const beat = Number(entry?.["beat"] ?? 1);
      const beats = studio.beats.value;
      const from = Number(entry?.["measure"] ?? 1) + (beat - 1) / beats;
      const to = from + drag.by;
      if (to < 1) return [];
      const hasBeat = one.list === "at" || one.list === "signal";
      const whole = Math.floor(to + 1e-6);
      const value = hasBeat ? { measure: whole, beat: Math.round(((to - whole) * beats + 1) * 64) / 64 } : to;
      return [{ do: drag.copy ? ("copy" as const) : ("move" as const), at: [one.list, one.number], value }];
    });
    await studio.doc.edits(drag.copy ? [...edits].sort((a, b) => Number(b.at[1]) - Number(a.at[1])) : edits);
    return;
  }
  const at = [box.list, box.number];
  const measure = Number(box.entry["measure"] ?? 1);
  if (drag.kind === "end") await studio.doc.edit({ do: "resize", at, value: box.length + drag.by });
  else await studio.doc.edit({ do: "change", at, value: { measure: measure + drag.by, measures: box.length - drag.by } });
}
