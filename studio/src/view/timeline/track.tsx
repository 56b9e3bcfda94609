import { useComputed } from "@preact/signals";
import { memo } from "./memo";
import { wordsOfDancers } from "../../model/form";
import type { Box, Row } from "../../model/plan";
import { keyOf, type Studio } from "../../model/studio";
import { colourOf } from "../stage/paint";
import { CurveLane } from "./curve_lane";
import { CHUNK, type TimelineState } from "./state";

const POINT_WORDS: Record<string, string> = { segment: "formation", sequence: "steps", at: "call", element: "element", improvise: "improvisation", regroup: "new group", cue: "cue", signal: "signal" };

export function wordsOf(box: Box): string {
  const who = box.group && box.group !== "*" ? `, ${wordsOfDancers(box.group)}` : "";
  const length = box.length ? `, ${short(box.length)} long` : "";
  return `${POINT_WORDS[box.list] ?? box.list} ${box.label}${who}, measure ${short(box.start + 1)}${length}`;
}

export function short(value: number): string {
  return String(Math.round(value * 100) / 100);
}

/** A row: its name, and its boxes in parts of which only those that are seen are made. */
export const Track = memo(({ studio, state, row }: { studio: Studio; state: TimelineState; row: Row }) => {
  const group = studio.doc.structure.value?.groups[row.group];
  const chosen = useComputed(() => studio.row.value === row.id);
  const colour = row.group >= 0 ? colourOf(group) : undefined;
  const chunks = chunksOf(row);
  const first = state.firstChunk.value;
  const last = state.lastChunk.value;
  return (
    <>
      <div class="name" style={{ paddingLeft: `${4 + 14 * row.depth}px` }}>
        <button
          class="plain"
          aria-pressed={chosen.value}
          title={row.selection === null ? row.label : `${row.label}: what is put or pasted goes here`}
          onClick={() => { studio.row.value = chosen.peek() ? null : row.id; }}
          data-row={row.id}
        >
          {row.group >= 0 && row.depth === 0 && <i style={{ background: colour }} />}
          {row.depth > 0 && <i class="branch" aria-hidden="true" />}
          <span>{row.depth > 0 ? shortPart(row.label, group?.name ?? "") : wordsOfDancers(row.label)}</span>
        </button>
      </div>
      <div class="lane" data-lane={row.id}>
        {row.apart.map(([from, to]) => <i key={from} class="apart" style={{ "--start": from, "--length": to - from }} />)}
        {row.kind === "curve" && row.boxes[0] ? (
          <CurveLane studio={studio} state={state} box={row.boxes[0]} />
        ) : (
          chunks.map((chunk) => (chunk.at <= last && chunk.end >= first ? <Chunk key={chunk.at} studio={studio} row={row} boxes={chunk.boxes} state={state} /> : null))
        )}
        {row.kind === "group" && <Follower studio={studio} row={row} />}
      </div>
    </>
  );
});

/** The words of a part without the group's name, which stands above it. */
function shortPart(words: string, group: string): string {
  const rest = words.toLowerCase().startsWith(group.toLowerCase()) ? words.slice(group.length).trim() : words;
  if (rest.startsWith("&")) return rest.slice(1).trim();
  return rest.startsWith("-") ? `without ${rest.slice(1).trim()}` : wordsOfDancers(rest || words);
}

interface Part {
  at: number;
  /** The last chunk into which one of its boxes reaches. */
  end: number;
  boxes: Box[];
}

const parts = new WeakMap<Row, Part[]>();

function chunksOf(row: Row): Part[] {
  let found = parts.get(row);
  if (!found) {
    const byChunk = new Map<number, Part>();
    for (const box of row.boxes) {
      const at = Math.floor(box.start / CHUNK);
      const part = byChunk.get(at) ?? { at, end: at, boxes: [] };
      part.end = Math.max(part.end, Math.floor((box.start + box.length) / CHUNK));
      part.boxes.push(box);
      byChunk.set(at, part);
    }
    parts.set(row, (found = [...byChunk.values()]));
  }
  return found;
}

const Chunk = memo(({ studio, state, row, boxes }: { studio: Studio; state: TimelineState; row: Row; boxes: Box[] }) => {
  const chosen = useComputed(() => boxes.filter((box) => studio.selectedKeys.value.has(keyOf(box))).map(keyOf).join());
  const others = useComputed(() => boxes.map((box) => studio.lookedAt.value.get(keyOf(box))?.colour ?? "").join());
  const flashes = useComputed(() => boxes.map((box) => state.flashes.value.get(keyOf(box)) ?? "").join("\n"));
  const keys = new Set(chosen.value.split(","));
  const colours = others.value.split(",");
  const by = flashes.value.split("\n");
  const dense = state.dense.value;
  return (
    <>
      {boxes.map((box, index) => (dense && !keys.has(keyOf(box)) && !colours[index] && !by[index] ? null : (
        <BoxView
          key={keyOf(box)}
          studio={studio}
          box={box}
          lane={row.lane.get(box) ?? 0}
          chosen={keys.has(keyOf(box))}
          other={colours[index] ?? ""}
          by={by[index] ?? ""}
          beats={studio.beats.value}
        />
      )))}
    </>
  );
});

/** A box. It has no listeners: those of the timeline find it by its key. */
const BoxView = memo(({ studio, box, lane, chosen, other, by, beats }: { studio: Studio; box: Box; lane: number; chosen: boolean; other: string; by: string; beats: number }) => {
  const isPoint = box.length === 0;
  const later = Number(box.entry["beats_later"] ?? 0);
  const words = wordsOf(box);
  return (
    <>
      <button
        class={`box ${box.list}${isPoint ? " point" : ""}${by ? " changed" : ""}${other ? " other" : ""}`}
        aria-pressed={chosen}
        aria-label={words}
        title={words}
        tabIndex={chosen ? 0 : -1}
        data-key={keyOf(box)}
        style={{ "--start": box.start, "--length": box.length, "--lane": lane, ...(other ? { "--other": `var(${other})` } : {}) }}
      >
        <span>{box.label}</span>
        {by ? <em>{by}</em> : null}
      </button>
      {chosen && box.list === "segment" && (
        <button
          class="canon"
          data-canon={keyOf(box)}
          style={{ "--start": box.start + later / beats, "--lane": lane }}
          role="slider"
          aria-label={`begins later from dancer to dancer: ${later} beats`}
          aria-valuenow={later}
          aria-valuemin={0}
          aria-valuemax={64}
            onKeyDown={(event) => changeLater(event, studio, [box.list, box.number], later)}
          title="Drag it to make a canon: this many beats later"
        />
      )}
    </>
  );
});

/** The arrow keys change by how many beats something comes later. */
function changeLater(event: KeyboardEvent, studio: Studio, at: [string, number], later: number): void {
  const by = { ArrowLeft: -1, ArrowRight: 1, ArrowDown: -1, ArrowUp: 1 }[event.key];
  if (!by) return;
  event.preventDefault();
  event.stopPropagation();
  if (later + by >= 0) void studio.doc.edit({ do: "set", at: [...at, "beats_later"], value: later + by || null });
}

/** A group that does what another one does, later: the handle changes by how many beats. */
function Follower({ studio, row }: { studio: Studio; row: Row }) {
  const entry = (studio.score.value["group"] as Record<string, unknown>[] | undefined)?.[row.group];
  const like = entry?.["like"];
  if (typeof like !== "string") return null;
  const later = Number(entry?.["beats_later"] ?? 0);
  return (
    <>
      <i class="follows" style={{ "--start": 0, "--length": later / studio.beats.value }} />
      <button
        class="canon"
        data-canon={`group ${row.group + 1}`}
        style={{ "--start": later / studio.beats.value, "--lane": 0 }}
        role="slider"
        aria-label={`${row.label} does what ${like} does, ${later} beats later`}
        aria-valuenow={later}
        aria-valuemin={0}
        aria-valuemax={1024}
        onKeyDown={(event) => changeLater(event, studio, ["group", row.group + 1], later)}
        title={`${row.label} does what ${like} does, ${later} beats later: drag it`}
      />
    </>
  );
}
