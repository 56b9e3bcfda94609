import { useEffect, useMemo, useRef } from "preact/hooks";
import { hasDancers, phrases, placeKeys, type Snap } from "../../model/arrange";
import { asLed, reached } from "../../model/danced";
import { divisionRows, type Branch } from "../../model/division";
import { sequenceLength, type Row } from "../../model/plan";
import type { Studio } from "../../model/studio";
import { addPoint } from "./curve_lane";
import { DenseBoxes } from "./dense";
import { listenToGestures } from "./gestures";
import { Overlay } from "./overlay";
import { addSection, Ruler } from "./ruler";
import { addHere, join, putAt, rowDancers, split } from "./shortcuts";
import { colourOf } from "../stage/paint";
import { heightOf, PHRASES, timelineOf, type TimelineState } from "./state";
import { Track } from "./track";
import "./timeline.css";

/** Width of a phrase's name [px]: a double click there names it anew. */
const PHRASE_LABEL_PX = 48;
const FLASH_MS = 1600;
const MOST_DIVIDED = 64;
/** A double click that a browser tells so soon after a double tap is the same one. */
const DOUBLE_TAP_REST_MS = 700;
let doubleTap = -Infinity;

/** Measures from left to right: sections, music, signals, and a row for each group, with boxes that can be moved. */
export function Timeline({ studio }: { studio: Studio }) {
  const scroller = useRef<HTMLDivElement>(null);
  const state = useMemo(() => timelineOf(studio), [studio]);

  useEffect(() => {
    const element = scroller.current as HTMLDivElement;
    const measureNames = (): void => {
      state.names.value = parseFloat(getComputedStyle(element).getPropertyValue("--name")) || 132;
      state.look();
    };
    measureNames();
    const onScroll = (): void => state.look();
    element.addEventListener("scroll", onScroll, { passive: true });
    const sizes = new ResizeObserver(measureNames);
    sizes.observe(element);
    const stop = listenToGestures(studio, state, element, (event) => {
      doubleTap = event.timeStamp;
      doubleClick(event, studio, state);
    });
    const onDragEnd = (): void => {
      dragging.now = null;
      if (state.gesture.peek()?.kind === "drop") void state.end(false);
    };
    document.addEventListener("dragend", onDragEnd);
    return () => {
      document.removeEventListener("dragend", onDragEnd);
      element.removeEventListener("scroll", onScroll);
      sizes.disconnect();
      stop();
    };
  }, [studio, state]);

  useEffect(() => studio.doc.lastChange.subscribe((change) => flash(studio, state, change)), [studio, state]);
  useEffect(() => studio.playhead.subscribe((at) => {
    const { element } = state;
    const isAway = state.gesture.peek() ?? studio.cursor.peek() ?? studio.selected.peek()[0] ?? null;
    if (!element || at === null || !state.follow.peek() || isAway !== null) return; // somebody looks at a place of their own
    const x = at * studio.scale.peek();
    const room = element.clientWidth - state.names.peek();
    if (x < element.scrollLeft || x > element.scrollLeft + 0.86 * room) element.scrollLeft = Math.max(0, x - 0.08 * room);
  }), [studio, state]);

  return (
    <section class="timeline" aria-label="Timeline">
      <Tools studio={studio} state={state} />
      <div
        class="tracks"
        ref={(element) => {
          scroller.current = element;
          state.element = element;
        }}
        style={{ "--px": `${studio.scale.value}px`, "--measures": studio.length.value, "--beats": studio.beats.value }}
        data-grid={studio.scale.value / studio.beats.value >= 14 ? "beats" : studio.scale.value >= 9 ? "measures" : "eights"}
        onDblClick={(event) => { if (event.timeStamp - doubleTap > DOUBLE_TAP_REST_MS) doubleClick(event, studio, state); }}
        onDragOver={(event) => dragOver(event, studio, state)}
        onDragLeave={(event) => { if (!scroller.current?.contains(event.relatedTarget as Node | null)) void state.end(false); }}
        onDrop={(event) => {
          event.preventDefault();
          const told = event.dataTransfer?.getData(DRAGGED);
          const gesture = state.gesture.value;
          void state.end(false);
          if (!told) return;
          const row = state.rows.value[gesture?.kind === "drop" ? gesture.row : state.place(event).row];
          if (row) void drop(studio, row, Math.floor(state.place(event).measure), JSON.parse(told));
        }}
      >
        <Ruler studio={studio} state={state} />
        {state.rows.value.map((row) => (
          <div key={row.id} class={`track ${row.kind}`} role="group" aria-label={row.label} style={{ height: `${heightOf(row)}px`, ...(row.group >= 0 ? { "--group": colourOf(studio.doc.structure.value?.groups[row.group]) } : {}) }}>
            <Track studio={studio} state={state} row={row} />
          </div>
        ))}
        <DenseBoxes studio={studio} state={state} />
        <Overlay studio={studio} state={state} />
      </div>
    </section>
  );
}

function Tools({ studio, state }: { studio: Studio; state: TimelineState }) {
  const count = studio.selected.value.length;
  const boxes = studio.chosenBoxes().length;
  const range = studio.range.value;
  return (
    <header class="strip">
      <h2>Timeline</h2>
      <div class="choice" role="group" aria-label="What the rows show">
        <button aria-pressed={studio.mode.value === "steps"} onClick={() => { studio.mode.value = "steps"; }}>Steps</button>
        <button aria-pressed={studio.mode.value === "motion"} onClick={() => { studio.mode.value = "motion"; }}>Group motion</button>
      </div>
      <label class="field">
        Snap
        <select value={studio.snap.value} onChange={(event) => { studio.snap.value = event.currentTarget.value as Snap; }}>
          <option value="measure">measure</option>
          <option value="beat">beat</option>
          <option value="none">off</option>
        </select>
      </label>
      <div class="choice" role="group" aria-label="Zoom">
        <button onClick={() => state.zoom(0.8)} aria-label="Zoom out" title="Zoom out (−)">−</button>
        <button onClick={() => state.zoom(1.25)} aria-label="Zoom in" title="Zoom in (+)">+</button>
        <button onClick={() => state.fit(0, studio.length.value)} title="All measures (0)">Whole show</button>
      </div>
      <label class="switch"><input type="checkbox" checked={state.follow.value} onChange={() => { state.follow.value = !state.follow.value; }} /> Follow</label>
      <button onClick={() => void addSection(studio)} title="A new section behind the selected one">Add section</button>
      {boxes > 0 && (
        <div class="choice" role="group" aria-label="Selected boxes">
          <button onClick={() => split(studio)} title="Split at the cursor (S)">Split</button>
          {boxes > 1 && <button onClick={() => join(studio)} title="One box from several (J)">Join</button>}
        </div>
      )}
      {range && (
        <div class="choice" role="group" aria-label="Chosen measures">
          <button onClick={() => state.fit(range[0], range[1] - range[0])}>Zoom to measures {Math.floor(range[0]) + 1}–{Math.ceil(range[1])}</button>
          <button aria-pressed={state.danced.value.length > 0} onClick={() => void showDivision(studio, state)} title="Who dances together in these measures, as it is danced">As danced</button>
        </div>
      )}
      <span class="hint" role="status">{count > 1 ? `${count} selected` : ""}</span>
    </header>
  );
}

/** Rename a section, or begin a box on a row. The pointer is captured: what lies there is asked for. */
function doubleClick(event: MouseEvent, studio: Studio, state: TimelineState): void {
  const target = document.elementFromPoint(event.clientX, event.clientY);
  const section = target?.closest<HTMLElement>("[data-section]")?.dataset["section"];
  if (section) state.naming.value = Number(section);
  const place = state.place(event);
  const down = event.clientY - (state.element?.getBoundingClientRect().top ?? 0);
  if (!section && place.row < 0 && down >= PHRASES[0] && down <= PHRASES[1]) {
    namePhrase(studio, state, place.measure);
    return;
  }
  const id = target?.closest(".knot, .box, .canon") ? undefined : target?.closest<HTMLElement>("[data-lane]")?.dataset["lane"];
  const row = state.rows.peek().find((one) => one.id === id);
  const [first] = row?.boxes ?? [];
  if (row?.kind === "curve" && first) addPoint(studio, state, first, event);
  else if (row && row.kind !== "danced" && !state.boxAt(place)) void addHere(studio, row, Math.floor(place.measure));
}

/** Name the phrase whose name is there, or a new one. */
function namePhrase(studio: Studio, state: TimelineState, measure: number): void {
  const all = phrases(studio.score.peek(), studio.length.peek());
  const under = all.find((one) => one.number && measure >= one.start && (measure - one.start) * studio.scale.peek() < PHRASE_LABEL_PX);
  state.phrase.value = under?.start ?? Math.floor(measure);
}

/** Show who dances together in the chosen measures, or hide it. */
async function showDivision(studio: Studio, state: TimelineState): Promise<void> {
  const range = studio.range.peek();
  if (state.danced.peek().length || !range) {
    state.danced.value = [];
    return;
  }
  const first = Math.floor(range[0]);
  const { from, to, led } = reached(studio.score.peek(), first, Math.min(Math.ceil(range[1]) - first, MOST_DIVIDED));
  const answer = await studio.preview.ask({ from, to, ...asLed(led), positions: "none", ways: false, notes: false, division: true }, "division");
  if (answer.refused) studio.doc.tell("refused", "Nothing to show", answer.refused);
  const found = (answer.texts["division"]?.["division"] ?? {}) as Record<string, Branch[]>;
  state.danced.value = divisionRows(found[studio.mode.peek() === "steps" ? "steps" : "motion"] ?? [], first, from);
}

/** Show for a moment what somebody else changed, with their name. */
function flash(studio: Studio, state: TimelineState, change: { by: string; entries: { at: [string] | [string, number] }[] | null } | null): void {
  if (!change?.entries || !change.by || change.by === studio.by) return;
  const keys = change.entries.flatMap(({ at }) => (at[1] === undefined ? [] : [`${at[0]} ${at[1]}`])).slice(0, 100);
  if (!keys.length) return;
  state.flashes.value = new Map([...state.flashes.peek(), ...keys.map((key): [string, string] => [key, change.by])]);
  setTimeout(() => {
    const left = new Map(state.flashes.peek());
    for (const key of keys) left.delete(key);
    state.flashes.value = left;
  }, FLASH_MS);
}

/** Type of what is dragged from the library: {"list", "value"} as JSON. */
export const DRAGGED = "application/x-live-entry";

interface Dragged {
  list: string;
  value: Record<string, unknown>;
}

/** What is dragged from the library now; browsers tell it only when it is dropped. */
export const dragging: { now: Dragged | null } = { now: null };

function dragOver(event: DragEvent, studio: Studio, state: TimelineState): void {
  if (!event.dataTransfer?.types.includes(DRAGGED)) return;
  event.preventDefault();
  const place = state.place(event);
  const row = Math.max(place.row, 0);
  const measure = Math.floor(place.measure);
  const { now } = dragging;
  const before = state.gesture.peek();
  if (before?.kind === "drop" && before.row === row && before.start === measure) return;
  const library = studio.ground.peek().library;
  const length = now?.list === "sequence" ? sequenceLength(now.value["steps"], library) : Number(now?.value["measures"] ?? 1);
  const target = state.rows.peek()[row];
  state.gesture.value = {
    kind: "drop", list: now?.list ?? "", value: now && target ? entryFor(studio, target, measure, now) : {}, start: measure, length, row,
  };
  if (now) state.ask();
}

function entryFor(studio: Studio, row: Row, measure: number, dragged: Dragged): Record<string, unknown> {
  const group = row.selection !== null && row.selection !== "*" && hasDancers(dragged.list) ? { group: row.selection } : {};
  return { ...dragged.value, ...placeKeys(dragged.list, measure, studio.ground.peek()), ...group };
}

/** Put an entry of the library where it was dropped. */
export async function drop(studio: Studio, row: Row, measure: number, dragged: Dragged): Promise<void> {
  await studio.insert(dragged.list, entryFor(studio, row, measure, dragged));
}

/** Put an entry at the cursor, for the selected row, or the dancers that are selected on the stage. */
export async function putEntry(studio: Studio, dragged: Dragged): Promise<boolean> {
  const who = studio.dancers.peek().length ? studio.whom.peek() : rowDancers(studio);
  const group = hasDancers(dragged.list) && who && who !== "*" ? { group: who } : {};
  return studio.insert(dragged.list, { ...dragged.value, ...placeKeys(dragged.list, putAt(studio), studio.ground.peek()), ...group });
}
