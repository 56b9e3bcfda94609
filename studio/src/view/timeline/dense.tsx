import { useEffect, useRef } from "preact/hooks";
import type { Studio } from "../../model/studio";
import { keyOf } from "../../model/studio";
import { colourOf } from "../stage/paint";
import { LANE, RULER, type TimelineState } from "./state";

const BOX_HEIGHT = 23;
const LABEL_PX = 34;
const LETTER_PX = 6.4;
const COLOURS: Record<string, string> = { segment: "--box-segment", element: "--good", regroup: "--box-regroup", signal: "--box-signal", at: "--box-call", cue: "--accent" };

/** All boxes at once, where they are too many to be elements: a picture of them, without those that are selected. */
export function DenseBoxes({ studio, state }: { studio: Studio; state: TimelineState }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const dense = state.dense.value;
  useEffect(() => {
    const { element } = state;
    const own = canvas.current;
    if (!dense || !element || !own) return;
    let asked = 0;
    const draw = (): void => {
      asked = 0;
      const width = Math.max(0, element.clientWidth - state.names.peek());
      const height = Math.max(0, element.clientHeight - RULER);
      const ratio = window.devicePixelRatio || 1;
      if (own.width !== Math.round(width * ratio) || own.height !== Math.round(height * ratio)) {
        own.width = Math.round(width * ratio);
        own.height = Math.round(height * ratio);
        own.style.width = `${width}px`;
        own.style.height = `${height}px`;
      }
      const context = own.getContext("2d");
      if (!context) return;
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      context.clearRect(0, 0, width, height);
      paint(context, studio, state, element, width, height, getComputedStyle(own));
    };
    const ask = (): void => {
      if (!asked) asked = requestAnimationFrame(draw);
    };
    const stops = [studio.scale.subscribe(ask), state.rows.subscribe(ask), studio.selectedKeys.subscribe(ask), state.gesture.subscribe(ask)];
    element.addEventListener("scroll", ask, { passive: true });
    const sizes = new ResizeObserver(ask);
    sizes.observe(element);
    return () => {
      cancelAnimationFrame(asked);
      for (const stop of stops) stop();
      element.removeEventListener("scroll", ask);
      sizes.disconnect();
    };
  }, [studio, state, dense]);
  return dense ? <div class="dense" style={{ height: `${state.tops.value.at(-1) ?? 0}px` }}><canvas ref={canvas} aria-hidden="true" /></div> : null;
}

function paint(context: CanvasRenderingContext2D, studio: Studio, state: TimelineState, element: HTMLElement, width: number, height: number, style: CSSStyleDeclaration): void {
  const colour = (name: string): string => style.getPropertyValue(name).trim();
  const ink = colour("--ink");
  const other = colour("--box-steps");
  const known = new Map(Object.entries(COLOURS).map(([list, name]) => [list, colour(name)]));
  const scale = studio.scale.peek();
  const chosen = studio.selectedKeys.peek();
  const from = element.scrollLeft / scale;
  const to = (element.scrollLeft + width) / scale;
  const tops = state.tops.peek();
  context.font = "12px system-ui, sans-serif";
  context.textBaseline = "middle";
  context.lineWidth = 1;
  state.rows.peek().forEach((row, index) => {
    const top = (tops[index] as number) - RULER - element.scrollTop;
    if (top > height || (tops[index + 1] as number) - RULER - element.scrollTop < 0 || row.kind === "curve") return;
    const own = row.group >= 0 ? colourOf(studio.doc.structure.peek()?.groups[row.group]) : other;
    for (const box of row.boxes) {
      if (box.start > to || box.start + Math.max(box.length, 4 / scale) < from || chosen.has(keyOf(box))) continue;
      const x = Math.max(box.start * scale - element.scrollLeft + 1, -20);
      const wide = Math.max(Math.min((box.start + box.length) * scale - element.scrollLeft - 1, width + 20) - x, box.length ? 2 : 3);
      const y = top + 3 + (row.lane.get(box) ?? 0) * LANE;
      const fill = known.get(box.list) ?? own;
      context.globalAlpha = 0.55;
      context.fillStyle = fill;
      context.fillRect(x, y, wide, BOX_HEIGHT);
      context.globalAlpha = 0.9;
      context.fillRect(x, y, 1.5, BOX_HEIGHT);
      if (wide > LABEL_PX) {
        context.globalAlpha = 1;
        context.fillStyle = ink;
        context.fillText(box.label.slice(0, Math.floor((wide - 10) / LETTER_PX)), x + 6, y + BOX_HEIGHT / 2 + 0.5);
      }
    }
  });
  context.globalAlpha = 1;
}
