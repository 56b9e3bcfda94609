import { useSignal, type Signal } from "@preact/signals";
import type { Studio } from "../../model/studio";
import { entries } from "../../model/score";
import { rounded, toMetres, toPixels, type Camera2D } from "./camera2d";

interface Handle {
  list: string;
  number: number;
  /** Key of the place within the entry: `at`, `to`, or the index of a point of its line. */
  key: "at" | "to" | number;
  place: [number, number];
  label: string;
}

const NUDGE_M = 0.1;

/** Points that can be dragged: of the selected element, path, obstacle or gate. By keyboard: Tab, then arrows. */
export function Handles({ studio, camera }: { studio: Studio; camera: Signal<Camera2D> }) {
  const dragged = useSignal<{ handle: Handle; place: [number, number] } | null>(null);
  const drop = (handle: Handle, place: [number, number]): void => {
    const value: [number, number] = [rounded(place[0]), rounded(place[1])];
    if (value[0] === handle.place[0] && value[1] === handle.place[1]) return;
    if (typeof handle.key === "number") {
      const name = handle.list === "segment" ? "path" : "points";
      void studio.doc.edit({ do: "set", at: [handle.list, handle.number, name, handle.key + 1], value });
    } else void studio.doc.edit({ do: "move", at: [handle.list, handle.number], value: { [handle.key]: value } });
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
            key={`${handle.list} ${handle.number} ${handle.key}`}
            class={`handle ${handle.list}`}
            style={{ left: `${px}px`, top: `${py}px` }}
            aria-label={`${handle.label} at ${place[0].toFixed(1)}, ${place[1].toFixed(1)} m; arrows move it`}
            onPointerDown={(event) => {
              (event.currentTarget as HTMLElement).setPointerCapture(event.pointerId);
              dragged.value = { handle, place };
              event.stopPropagation();
            }}
            onPointerMove={(event) => {
              if (!mine) return;
              const box = (event.currentTarget as HTMLElement).parentElement?.getBoundingClientRect();
              if (box) dragged.value = { handle, place: toMetres(camera.value, event.clientX - box.left, event.clientY - box.top) };
            }}
            onPointerUp={() => {
              if (mine && dragged.value) drop(handle, dragged.value.place);
              dragged.value = null;
            }}
            onPointerCancel={() => { dragged.value = null; }}
            onKeyDown={(event) => {
              const by = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
              if (!by) return;
              event.preventDefault();
              event.stopPropagation();
              const far = event.shiftKey ? 10 * NUDGE_M : NUDGE_M;
              drop(handle, [place[0] + far * (by[0] ?? 0), place[1] + far * (by[1] ?? 0)]);
            }}
          />
        );
      })}
    </div>
  );
}

function handlesOf(studio: Studio): Handle[] {
  const found: Handle[] = [];
  const add = (list: string, number: number, words: string): void => {
    const entry = entries(studio.score.value, list)[number - 1];
    if (!entry) return;
    const line = (entry["points"] ?? (list === "segment" ? entry["path"] : undefined)) as [number, number][] | undefined;
    if (Array.isArray(line) && line.every((point) => Array.isArray(point) && typeof point[0] === "number")) {
      line.slice(0, 64).forEach((place, index) => found.push({ list, number, key: index, place, label: `${words}, point ${index + 1}` }));
      return;
    }
    const at = (entry["at"] ?? (list === "element" ? [0, 0] : undefined)) as [number, number] | undefined;
    if (Array.isArray(at)) found.push({ list, number, key: "at", place: at, label: words });
    const to = entry["to"] as [number, number] | undefined;
    if (Array.isArray(to)) found.push({ list, number, key: "to", place: to, label: `${words}, other end` });
  };
  for (const one of studio.selected.value) {
    if (["element", "segment", "obstacle", "gate"].includes(one.list)) add(one.list, one.number, studio.box(one)?.label ?? one.list);
  }
  return found;
}
