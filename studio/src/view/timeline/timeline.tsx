import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { Studio } from "../../model/studio";
import type { Row } from "../../model/plan";
import { colourOf } from "../stage/paint";
import { BoxView, LANE } from "./box_view";
import { Ruler } from "./ruler";

/** Measures from left to right: sections, music, signals, and a row for each group, with boxes that can be moved. */
export function Timeline({ studio }: { studio: Studio }) {
  const scroller = useRef<HTMLDivElement>(null);
  const follow = useSignal(true);
  const length = studio.length.value;

  useEffect(() => {
    const element = scroller.current as HTMLDivElement;
    const onWheel = (event: WheelEvent): void => {
      if (!event.ctrlKey && !event.metaKey) {
        follow.value = false;
        return;
      }
      event.preventDefault();
      zoom(studio, element, event.clientX, Math.exp(-event.deltaY / 300));
    };
    element.addEventListener("wheel", onWheel, { passive: false });
    return () => element.removeEventListener("wheel", onWheel);
  }, [studio]);

  const playhead = studio.playhead.value;
  useEffect(() => {
    const element = scroller.current;
    if (!element || playhead === null || !follow.value) return;
    const at = playhead * studio.scale.value;
    if (at < element.scrollLeft || at > element.scrollLeft + element.clientWidth - 220) element.scrollLeft = Math.max(0, at - 80);
  }, [playhead]);

  return (
    <section class="timeline" aria-label="Timeline">
      <header class="strip">
        <h2>Timeline</h2>
        <div class="choice" role="group" aria-label="What the rows show">
          <button aria-pressed={studio.mode.value === "steps"} onClick={() => { studio.mode.value = "steps"; }}>Steps</button>
          <button aria-pressed={studio.mode.value === "motion"} onClick={() => { studio.mode.value = "motion"; }}>Group motion</button>
        </div>
        <label class="field">
          Snap
          <select value={studio.snap.value} onChange={(event) => { studio.snap.value = event.currentTarget.value as "measure" | "beat" | "none"; }}>
            <option value="measure">measure</option>
            <option value="beat">beat</option>
            <option value="none">off</option>
          </select>
        </label>
        <button onClick={() => zoom(studio, scroller.current, null, 0.8)} aria-label="Zoom out">−</button>
        <button onClick={() => zoom(studio, scroller.current, null, 1.25)} aria-label="Zoom in">+</button>
        <button onClick={() => { studio.scale.value = Math.max(3, ((scroller.current?.clientWidth ?? 800) - 160) / length); }}>Whole show</button>
        <label class="switch"><input type="checkbox" checked={follow.value} onChange={() => { follow.value = !follow.value; }} /> follow</label>
        <span class="hint">{studio.selected.value.length > 1 ? `${studio.selected.value.length} selected` : ""}</span>
      </header>
      <div class="tracks" ref={scroller} style={{ "--px": `${studio.scale.value}px`, "--measures": length, "--beats": studio.beats.value }}>
        <Ruler studio={studio} />
        {studio.rows.value.map((row) => <Track key={row.id} studio={studio} row={row} />)}
        {playhead !== null && <i class="playhead" style={{ "--at": playhead }} aria-hidden="true" />}
        {studio.cursor.value !== null && <i class="playhead cursor" style={{ "--at": studio.cursor.value }} aria-hidden="true" />}
      </div>
    </section>
  );
}

function Track({ studio, row }: { studio: Studio; row: Row }) {
  const group = studio.doc.structure.value?.groups[row.group];
  return (
    <div class={`track ${row.kind}`} role="group" aria-label={row.label}>
      <div class="name" style={{ paddingLeft: `${10 + 14 * row.depth}px` }} title={row.label}>
        {row.group >= 0 && <i style={{ background: colourOf(group) }} />}
        <span>{row.label}</span>
      </div>
      <div
        class="lane"
        style={{ height: `${row.lanes * LANE + 6}px` }}
        onPointerDown={(event) => {
          if (event.target === event.currentTarget) studio.select(null);
        }}
        onDblClick={(event) => {
          if (event.target !== event.currentTarget) return;
          const measure = Math.floor(event.offsetX / studio.scale.value);
          void addHere(studio, row, measure);
        }}
        onDragOver={(event) => {
          if (event.dataTransfer?.types.includes(DRAGGED)) event.preventDefault();
        }}
        onDrop={(event) => {
          const told = event.dataTransfer?.getData(DRAGGED);
          if (!told) return;
          event.preventDefault();
          const left = (event.currentTarget as HTMLElement).getBoundingClientRect().left;
          void drop(studio, row, Math.floor((event.clientX - left) / studio.scale.value), JSON.parse(told));
        }}
      >
        {row.boxes.map((box) => (
          <BoxView key={`${box.list} ${box.number}`} studio={studio} box={box} lane={row.lane.get(box) ?? 0} colour={colourOf(group ?? undefined)} group={row.group} />
        ))}
      </div>
    </div>
  );
}

/** Type of what is dragged from the library: {"list", "value"} as JSON. */
export const DRAGGED = "application/x-live-entry";

/** Put an entry of the library where it was dropped. */
export async function drop(studio: Studio, row: Row, measure: number, dragged: { list: string; value: Record<string, unknown> }): Promise<void> {
  const group = row.kind === "group" || row.kind === "part" ? row.label : "";
  const value = { ...dragged.value, ...placeOf(studio, measure), ...(group && group !== "all" && dragged.list !== "at" && dragged.list !== "signal" ? { group } : {}) };
  await studio.insert(dragged.list, value);
}

/** Where a measure of the written score (from 0) lies: in its section, if there are sections. */
export function placeOf(studio: Studio, measure: number): { measure: number; section?: string } {
  const span = studio.spans.value.find((one) => measure >= one.first && measure < one.first + one.measures);
  return span ? { measure: measure - span.first + 1, section: span.name } : { measure: measure + 1 };
}

async function addHere(studio: Studio, row: Row, measure: number): Promise<void> {
  const place = placeOf(studio, measure);
  const group = row.kind === "group" || row.kind === "part" ? { group: row.label === "all" ? "*" : row.label } : {};
  if (row.kind === "signals") await studio.insert("signal", { ...place, name: `signal ${measure + 1}` });
  else if (row.kind === "calls") await studio.insert("at", { ...place, call: "/dance/light/level", values: [1.0] });
  else if (studio.mode.value === "motion") await studio.insert("segment", { ...place, ...group, measures: 4, formation: "circle" });
  else {
    const step = studio.doc.structure.value?.library[0]?.name ?? "walk";
    await studio.insert("sequence", { ...place, ...group, steps: [step] });
  }
}

function zoom(studio: Studio, element: HTMLElement | null, clientX: number | null, factor: number): void {
  const before = studio.scale.value;
  const after = Math.min(480, Math.max(3, before * factor));
  studio.scale.value = after;
  if (!element) return;
  const left = element.getBoundingClientRect().left + 132;
  const at = clientX === null ? element.clientWidth / 2 : clientX - left;
  const measure = (element.scrollLeft + at) / before;
  requestAnimationFrame(() => { element.scrollLeft = measure * after - at; });
}
