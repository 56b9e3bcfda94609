import type { Signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { reached } from "../../model/danced";
import { distance, nearestOf, type Place } from "../../model/geometry";
import { entries, number, text } from "../../model/score";
import { freeName, placedEdits } from "../../model/stage_edits";
import type { Placing, StageState } from "../../model/stage_state";
import type { Studio } from "../../model/studio";
import { placeIn } from "./paint_marks";
import { toMetres, toPixels, type Camera2D } from "./camera2d";

const NUDGE_M = 0.1;
const TURN_DEG = 15;
const TIP_PX = 24;

/** Begin to place dancers by hand: from where they stand now, or where a formation has them. */
export function beginPlacing(studio: Studio, stage: StageState): void {
  const positions = stage.shown.value ?? studio.doc.positions.value;
  if (!positions) return;
  const segment = studio.selected.value.length === 1 && studio.selected.value[0]?.list === "segment" ? studio.entry(studio.selected.value[0]) : undefined;
  const name = segment ? text(segment, "formation") : "";
  const index = name ? entries(studio.score.value, "formation").findIndex((one) => text(one, "name").toLowerCase() === name.toLowerCase()) : -1;
  const written = entries(studio.score.value, "formation")[index];
  if (written?.["shape"] === "places") {
    const places = (written["points"] as Place[]).map(([x, z]): Place => [x, z]);
    const headings = (written["headings_deg"] as number[] | undefined) ?? places.map(() => number(written, "heading_deg", 0));
    stage.placing.value = { name: text(written, "name"), number: index + 1, dancers: places.map((_, at) => at + 1), places, headings: [...headings] };
    return;
  }
  const from = name ? (stage.ghost.value ?? positions) : positions;
  const chosen = studio.dancers.value.length ? studio.dancers.value : Array.from({ length: from.count }, (_, row) => row + 1);
  const dancers = chosen.filter((one) => from.present[one - 1]);
  stage.placing.value = {
    name: freeName(studio.score.value, "placed"), number: 0, dancers,
    places: dancers.map((one) => placeIn(from, one)),
    headings: dancers.map((one) => Math.round(((from.rows[3 * (one - 1) + 2] ?? 0) * 180) / Math.PI)),
  };
}

function editsOf(studio: Studio, stage: StageState, now: Placing): ReturnType<typeof placedEdits> {
  return placedEdits(studio.score.value, now.name, now.number, now.places, now.headings, { start: stage.here(), measures: stage.measures.value, group: studio.whom.value });
}

function show(studio: Studio, stage: StageState): void {
  const now = stage.placing.value;
  if (!now) return;
  const used = studio.selected.value.find((one) => one.list === "segment");
  const measures = now.number ? used && stage.measuresOf(used.list, used.number) : reached(studio.score.value, stage.here(), stage.measures.value);
  if (measures) stage.drag(editsOf(studio, stage, now), measures);
}

/** Circles and triangles of a formation that are dragged by hand. By keyboard: Tab, arrows, and < > to turn. */
export function PlaceHandles({ studio, stage, camera }: { studio: Studio; stage: StageState; camera: Signal<Camera2D> }) {
  const now = stage.placing.value;
  if (!now) return null;
  const change = (index: number, place: Place | null, heading: number | null): void => {
    const before = stage.placing.value;
    if (!before) return;
    stage.placing.value = {
      ...before,
      places: place ? before.places.map((one, at) => (at === index ? place : one)) : before.places,
      headings: heading !== null ? before.headings.map((one, at) => (at === index ? heading : one)) : before.headings,
    };
    show(studio, stage);
  };
  return (
    <div class="handles">
      {now.places.map((place, index) => {
        const dancer = now.dancers[index] ?? index + 1;
        const heading = now.headings[index] ?? 0;
        const [px, py] = toPixels(camera.value, place[0], place[1]);
        const radians = (heading * Math.PI) / 180;
        const nearest = nearestOf(now.places, index, 1)[0];
        return [
          <button
            key={`place ${dancer}`}
            class="place"
            style={{ left: `${px}px`, top: `${py}px` }}
            aria-label={`Dancer ${dancer} at ${place[0].toFixed(1)}, ${place[1].toFixed(1)} m, facing ${heading} degrees${nearest === undefined ? "" : `, ${distance(place, now.places[nearest] as Place).toFixed(2)} m from dancer ${now.dancers[nearest]}`}`}
            onPointerDown={(event) => {
              event.currentTarget.setPointerCapture(event.pointerId);
              stage.held.value = place;
            }}
            onPointerMove={(event) => {
              if (!event.currentTarget.hasPointerCapture(event.pointerId)) return;
              const box = event.currentTarget.parentElement?.getBoundingClientRect();
              if (!box) return;
              const there = toMetres(camera.value, event.clientX - box.left, event.clientY - box.top);
              stage.held.value = there;
              change(index, there, null);
            }}
            onPointerUp={() => { stage.held.value = null; }}
            onPointerCancel={() => { stage.held.value = null; }}
            onBlur={() => { stage.held.value = null; }}
            onKeyDown={(event) => {
              const by = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
              const turn = { "<": -TURN_DEG, ">": TURN_DEG, ",": -TURN_DEG, ".": TURN_DEG }[event.key];
              if (!by && !turn) return;
              event.preventDefault();
              event.stopPropagation();
              if (turn) change(index, null, wrapped(heading + turn));
              else if (by) {
                const far = event.shiftKey ? 5 * NUDGE_M : NUDGE_M;
                const there: Place = [place[0] + far * (by[0] ?? 0), place[1] + far * (by[1] ?? 0)];
                stage.held.value = there;
                change(index, there, null);
              }
            }}
          >
            {dancer}
          </button>,
          <button
            key={`heading ${dancer}`}
            class="tip"
            tabIndex={-1}
            aria-label={`Turn dancer ${dancer}`}
            style={{ left: `${px + TIP_PX * Math.sin(radians)}px`, top: `${py + TIP_PX * Math.cos(radians)}px` }}
            onPointerDown={(event) => event.currentTarget.setPointerCapture(event.pointerId)}
            onPointerMove={(event) => {
              if (!event.currentTarget.hasPointerCapture(event.pointerId)) return;
              const box = event.currentTarget.parentElement?.getBoundingClientRect();
              if (box) change(index, null, Math.round((Math.atan2(event.clientX - box.left - px, event.clientY - box.top - py) * 180) / Math.PI));
            }}
          />,
        ];
      })}
    </div>
  );
}

function wrapped(degrees: number): number {
  return ((((degrees + 180) % 360) + 360) % 360) - 180;
}

/** The name of the formation, and where it comes. */
export function PlacingBar({ studio, stage }: { studio: Studio; stage: StageState }) {
  const now = stage.placing.value;
  const field = useRef<HTMLInputElement>(null);
  const isOpen = now !== null;
  useEffect(() => {
    if (!isOpen) return;
    field.current?.focus();
    show(studio, stage);
  }, [isOpen]);
  if (!now) return null;
  const close = (): void => {
    stage.placing.value = null;
    stage.held.value = null;
    stage.endDrag();
  };
  return (
    <form
      class="strip options placing"
      aria-label="Formation placed by hand"
      onKeyDown={(event) => {
        if (event.key !== "Escape") return;
        event.stopPropagation();
        close();
      }}
      onSubmit={(event) => {
        event.preventDefault();
        const kept = now;
        const edits = editsOf(studio, stage, now);
        close();
        void stage.send(edits).then((taken) => { if (!taken) stage.placing.value = kept; });
      }}
    >
      {now.number ? <strong>{now.name}</strong> : <label class="field">Name <input ref={field} value={now.name} maxLength={64} required onInput={(event) => { stage.placing.value = { ...now, name: event.currentTarget.value }; }} /></label>}
      <span class="hint">Drag circles to place, dots to turn{now.number ? "; every use changes" : `; from measure ${stage.here() + 1}`}</span>
      <button class="primary">{stage.trying.value ? "Try it" : "Keep"}</button>
      <button type="button" onClick={close}>Cancel</button>
    </form>
  );
}
