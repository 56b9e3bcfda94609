import { useSignal } from "@preact/signals";
import { curvePoints } from "../../model/arrange";
import type { Box } from "../../model/plan";
import type { Studio } from "../../model/studio";
import type { TimelineState } from "./state";

const HEIGHT = 40;
const MOST_HANDLES = 120;
const TOP = 3;

type Point = [number, number];

/** Put a point into a curve where the pointer is. */
export function addPoint(studio: Studio, state: TimelineState, box: Box, event: MouseEvent): void {
  const at = state.place(event);
  const grid = gridOf(studio);
  const value = 1 - (at.y - (state.tops.peek()[at.row] ?? 0) - TOP) / (HEIGHT - 2 * TOP);
  const point: Point = [Math.max(0, Math.round((at.measure - box.start) / grid) * grid), Math.round(Math.min(1, Math.max(0, value)) * 100) / 100];
  const others = curvePoints(box.entry).filter((one) => one[0] !== point[0]);
  void studio.doc.edit({ do: "set", at: ["curve", box.number, "points"], value: [...others, point].sort((a, b) => a[0] - b[0]) });
}

function gridOf(studio: Studio): number {
  const snap = studio.snap.peek();
  return snap === "measure" ? 1 : snap === "beat" ? 1 / studio.beats.peek() : 1 / 64;
}

/** A curve of a signal: its points are dragged; a double click adds one, Delete removes one. */
export function CurveLane({ studio, state, box }: { studio: Studio; state: TimelineState; box: Box }) {
  const held = useSignal<{ index: number; point: Point } | null>(null);
  const written = curvePoints(box.entry);
  const points = written.map((point, index) => (held.value?.index === index ? held.value.point : point));
  const scale = studio.scale.value;
  const { left, width } = state.seen.value;
  const x = (measures: number): number => (box.start + measures) * scale;
  const y = (value: number): number => TOP + (1 - value) * (HEIGHT - 2 * TOP);
  const line = points.map(([at, value], index) => `${index ? "L" : "M"}${x(at).toFixed(1)} ${y(value).toFixed(1)}`).join("");
  const visible = points.map((_, index) => index).filter((index) => {
    const at = x(points[index]?.[0] ?? 0);
    return at >= left - 40 && at <= left + 1.5 * width;
  });
  const grid = (): number => gridOf(studio);
  const send = (next: Point[]): void => {
    void studio.doc.edit({ do: "set", at: ["curve", box.number, "points"], value: next });
  };
  const fitted = (index: number, at: number, value: number): Point => {
    const low = index > 0 ? (written[index - 1]?.[0] ?? 0) + 1 / 64 : 0;
    const high = index < written.length - 1 ? (written[index + 1]?.[0] ?? 1e5) - 1 / 64 : 1e5;
    return [Math.min(high, Math.max(low, Math.round(at / grid()) * grid())), Math.round(Math.min(1, Math.max(0, value)) * 100) / 100];
  };
  const placed = (index: number, event: PointerEvent): Point => {
    const at = state.place(event);
    const top = state.tops.value[state.rows.value.findIndex((row) => row.boxes[0] === box)] ?? 0;
    return fitted(index, at.measure - box.start, 1 - (at.y - top - TOP) / (HEIGHT - 2 * TOP));
  };
  return (
    <>
      <svg class="graph" aria-hidden="true">
        <path class="fill" d={points.length ? `${line}L${x(points.at(-1)?.[0] ?? 0).toFixed(1)} ${HEIGHT}L${x(points[0]?.[0] ?? 0).toFixed(1)} ${HEIGHT}Z` : ""} />
        <path d={line} />
      </svg>
      {visible.length <= MOST_HANDLES && visible.map((index) => {
        const [at, value] = points[index] as Point;
        return (
          <button
            key={index}
            class="knot"
            role="slider"
            aria-label={`${box.label}, point ${index + 1} at measure ${Math.round((box.start + at + 1) * 100) / 100}`}
            aria-valuemin={0}
            aria-valuemax={100}
            aria-valuenow={Math.round(value * 100)}
            style={{ left: `${x(at)}px`, top: `${y(value)}px` }}
            onPointerDown={(event) => {
              event.stopPropagation();
              event.currentTarget.setPointerCapture(event.pointerId);
              held.value = { index, point: [at, value] };
              studio.select(box);
            }}
            onPointerMove={(event) => {
              if (held.value?.index === index) held.value = { index, point: placed(index, event) };
            }}
            onPointerUp={() => {
              const now = held.value;
              held.value = null;
              const before = written[index];
              if (now && before && (now.point[0] !== before[0] || now.point[1] !== before[1])) send(written.map((one, each) => (each === index ? now.point : one)));
            }}
            onPointerCancel={() => { held.value = null; }}
            onKeyDown={(event) => {
              const by = { ArrowLeft: [-grid(), 0], ArrowRight: [grid(), 0], ArrowUp: [0, 0.05], ArrowDown: [0, -0.05] }[event.key];
              if (by) send(written.map((one, each) => (each === index ? fitted(index, one[0] + (by[0] ?? 0), one[1] + (by[1] ?? 0)) : one)));
              else if ((event.key === "Delete" || event.key === "Backspace") && written.length > 1) send(written.filter((_, each) => each !== index));
              else if (event.key === "Enter") {
                const next = written[index + 1];
                const middle: Point = next ? [(at + next[0]) / 2, (value + next[1]) / 2] : [at + 1, value];
                send([...written.slice(0, index + 1), middle, ...written.slice(index + 1)]);
              } else return;
              event.preventDefault();
              event.stopPropagation();
            }}
          />
        );
      })}
    </>
  );
}
