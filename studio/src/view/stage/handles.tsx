import { useSignal, type Signal } from "@preact/signals";
import type { SingleEdit } from "../../model/document";
import type { Place } from "../../model/geometry";
import { entries, text } from "../../model/score";
import type { StageState } from "../../model/stage_state";
import type { Studio } from "../../model/studio";
import { rounded, toMetres, toPixels, type Camera2D } from "./camera2d";

interface Handle {
  list: string;
  number: number;
  /** Key of the place within the entry: `at`, `to`, `wall_to`, or the index of a point of its line. */
  key: "at" | "to" | "wall_to" | number;
  place: Place;
  label: string;
}

const NUDGE_M = 0.1;
const MOST_POINTS = 64;
const SET_LISTS = ["obstacle", "gate", "item"];

/** Points that can be dragged: of the selected element or path, and of obstacles, gates and items. By keyboard: Tab, then arrows. */
export function Handles({ studio, stage, camera }: { studio: Studio; stage: StageState; camera: Signal<Camera2D> }) {
  const dragged = useSignal<{ handle: Handle; place: Place } | null>(null);
  const edit = (handle: Handle, place: Place): SingleEdit => {
    const value: Place = [rounded(place[0]), rounded(place[1])];
    if (typeof handle.key === "number") return { do: "set", at: [handle.list, handle.number, handle.list === "segment" ? "path" : "points", handle.key + 1], value };
    if (handle.key === "at") return { do: "move", at: [handle.list, handle.number], value: { at: value } };
    return { do: "set", at: [handle.list, handle.number, handle.key], value };
  };
  const drop = (handle: Handle, place: Place): void => {
    if (rounded(place[0]) !== handle.place[0] || rounded(place[1]) !== handle.place[1]) void stage.send([edit(handle, place)]);
  };
  const show = (handle: Handle, place: Place): void => {
    const measures = ["segment", "element"].includes(handle.list) ? stage.measuresOf(handle.list, handle.number) : null;
    if (measures) stage.drag([edit(handle, place)], measures, handle.list === "element");
  };
  return (
    <div class="handles">
      {handlesOf(studio).map((handle) => {
        const held = dragged.value?.handle;
        const mine = held?.list === handle.list && held.number === handle.number && held.key === handle.key;
        const place = mine ? (dragged.value?.place ?? handle.place) : handle.place;
        const [px, py] = toPixels(camera.value, place[0], place[1]);
        return (
          <button
            key={keyOf(handle)}
            class={`handle ${handle.list}`}
            style={{ left: `${px}px`, top: `${py}px` }}
            title={handle.label}
            aria-label={`${handle.label} at ${place[0].toFixed(1)}, ${place[1].toFixed(1)} m; arrows move it`}
            onPointerDown={(event) => {
              event.currentTarget.setPointerCapture(event.pointerId);
              dragged.value = { handle, place };
              if (SET_LISTS.includes(handle.list)) studio.select(handle);
              event.stopPropagation();
            }}
            onPointerMove={(event) => {
              if (!mine) return;
              const box = event.currentTarget.parentElement?.getBoundingClientRect();
              if (!box) return;
              const there = toMetres(camera.value, event.clientX - box.left, event.clientY - box.top);
              dragged.value = { handle, place: there };
              stage.held.value = there;
              show(handle, there);
            }}
            onPointerUp={() => {
              if (mine && dragged.value) drop(handle, dragged.value.place);
              dragged.value = null;
              stage.held.value = null;
            }}
            onPointerCancel={() => {
              dragged.value = null;
              stage.held.value = null;
              stage.endDrag();
            }}
            onKeyDown={(event) => {
              const by = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
              if (!by) return;
              event.preventDefault();
              event.stopPropagation();
              const far = event.shiftKey ? 10 * NUDGE_M : NUDGE_M;
              studio.doc.inTurn(() => {
                const now = handlesOf(studio).find((one) => keyOf(one) === keyOf(handle));
                if (now) drop(now, [now.place[0] + far * (by[0] ?? 0), now.place[1] + far * (by[1] ?? 0)]);
              });
            }}
          />
        );
      })}
    </div>
  );
}

function keyOf(handle: Handle): string {
  return `${handle.list} ${handle.number} ${handle.key}`;
}

function isPlace(value: unknown): value is Place {
  return Array.isArray(value) && value.length === 2 && value.every((one) => typeof one === "number");
}

function handlesOf(studio: Studio): Handle[] {
  const found: Handle[] = [];
  const score = studio.score.value;
  const add = (list: string, number: number, words: string): void => {
    const entry = entries(score, list)[number - 1];
    if (!entry) return;
    const line = entry["points"] ?? (list === "segment" ? entry["path"] : undefined);
    if (Array.isArray(line) && line.every(isPlace)) {
      line.slice(0, MOST_POINTS).forEach((place: Place, index) => found.push({ list, number, key: index, place, label: `${words}, point ${index + 1}` }));
      return;
    }
    const standsStill = ["spread", "wander", "flock", "follow", "pursue", "evade"].includes(text(entry, "kind"));
    const at = entry["at"] ?? (list === "element" && !standsStill ? [0, 0] : undefined);
    if (isPlace(at)) found.push({ list, number, key: "at", place: at, label: words });
    for (const key of ["to", "wall_to"] as const) {
      const other = entry[key];
      if (isPlace(other)) found.push({ list, number, key, place: other, label: `${words}, other end` });
    }
  };
  for (const one of studio.selected.value) {
    if (["element", "segment"].includes(one.list)) add(one.list, one.number, studio.box(one)?.label ?? one.list);
  }
  for (const list of SET_LISTS) {
    entries(score, list).forEach((entry, index) => add(list, index + 1, `${list} ${text(entry, "name")}`.trim()));
  }
  return found;
}
