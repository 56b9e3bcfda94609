import { useSignal } from "@preact/signals";
import { fromHex, SWATCHES, toHex } from "../model/colour";
import { nameOf } from "../model/controls";
import type { Values, Widget } from "../net/values";
import { LearnMenu } from "./learn_menu";

/** One control of the engine; a right click, or the menu key, learns a fader, pad or key for it. */
export function Control({ values, widget }: { values: Values; widget: Widget }) {
  const menu = useSignal<{ x: number; y: number } | null>(null);
  const kinds = { fader: Fader, colour: ColourField, button: Press, toggle: Toggle, pad: Pad };
  const Kind = kinds[widget.kind];
  const named = { ...widget, label: nameOf(widget) };
  return (
    <div
      class={`control ${widget.kind}`}
      title={widget.words}
      onContextMenu={(event) => {
        event.preventDefault();
        menu.value = { x: event.clientX, y: event.clientY };
      }}
    >
      <Kind values={values} widget={named} />
      {menu.value && <LearnMenu values={values} widget={widget} at={menu.value} onClose={() => { menu.value = null; }} />}
    </div>
  );
}

interface Props {
  values: Values;
  widget: Widget;
}

function show(value: number): string {
  return Math.abs(value) >= 100 ? value.toFixed(0) : Math.abs(value) >= 10 ? value.toFixed(1) : value.toFixed(2);
}

function Fader({ values, widget }: Props) {
  const held = useSignal<number | null>(null);
  const known = held.value ?? values.of(widget.address).value?.[0] ?? widget.start[0];
  const now = Number(known ?? 0);
  const low = widget.minimum[0] ?? 0;
  const high = widget.maximum[0] ?? 1;
  return (
    <label>
      <span>{widget.label}<small aria-hidden="true">{known === undefined ? "–" : show(now)}</small></span>
      <input
        type="range" min={low} max={high} step={(high - low) / 1000} value={now}
        onInput={(event) => {
          held.value = Number(event.currentTarget.value);
          values.stream(widget.address, held.value);
        }}
        onChange={() => { held.value = null; }}
        onDblClick={() => values.send(widget.address, widget.start[0] ?? 0)}
      />
    </label>
  );
}

function ColourField({ values, widget }: Props) {
  const now = (values.of(widget.address).value ?? widget.start) as number[];
  const hex = toHex(now);
  const set = (wanted: string): void => values.stream(widget.address, ...fromHex(wanted));
  return (
    <details>
      <summary><span>{widget.label}</span><i class="chip" style={{ background: hex }} /></summary>
      <div class="swatches" role="group" aria-label={widget.label}>
        {SWATCHES.map(([swatch, name]) => (
          <button key={swatch} class="swatch" style={{ background: swatch }} aria-label={`${widget.label}: ${name}`} aria-pressed={swatch === hex} onClick={() => set(swatch)} />
        ))}
        <input type="color" aria-label={`${widget.label}: any colour`} value={hex} onInput={(event) => set(event.currentTarget.value)} />
      </div>
    </details>
  );
}

function Press({ values, widget }: Props) {
  return <button onClick={() => values.send(widget.address, ...widget.values)}>{widget.label}</button>;
}

function Toggle({ values, widget }: Props) {
  const on = Boolean(values.of(widget.address).value?.[0] ?? widget.start[0]);
  return <button role="switch" aria-checked={on} onClick={() => values.send(widget.address, on ? 0 : 1)}>{widget.label}</button>;
}

const STEP = 0.25;

/** A place on the stage: dragged, or with arrows and Enter. */
function Pad({ values, widget }: Props) {
  const place = useSignal<[number, number]>([0, 0]);
  const [left = -1, back = -1] = widget.minimum;
  const [right = 1, front = 1] = widget.maximum;
  const clip = (value: number, low: number, high: number): number => Math.min(Math.max(value, low), high);
  const put = (x: number, z: number, end: boolean): void => {
    place.value = [clip(x, left, right), clip(z, back, front)];
    if (end || !widget.once) values.stream(widget.address, ...place.value);
  };
  const touch = (event: PointerEvent, end: boolean): void => {
    const box = (event.currentTarget as HTMLElement).getBoundingClientRect();
    put(left + ((right - left) * (event.clientX - box.left)) / box.width, back + ((front - back) * (event.clientY - box.top)) / box.height, end);
  };
  return (
    <div class="whole">
      <span>{widget.label}</span>
      <div
        class="area" tabIndex={0} role="application" aria-label={`${widget.label}: arrow keys move it, Enter sets it`}
        style={{ aspectRatio: `${right - left} / ${front - back}` }}
        onPointerDown={(event) => {
          (event.currentTarget as HTMLElement).setPointerCapture(event.pointerId);
          touch(event, false);
        }}
        onPointerMove={(event) => {
          if ((event.currentTarget as HTMLElement).hasPointerCapture(event.pointerId)) touch(event, false);
        }}
        onPointerUp={(event) => touch(event, true)}
        onKeyDown={(event) => {
          const by = { ArrowLeft: [-STEP, 0], ArrowRight: [STEP, 0], ArrowUp: [0, -STEP], ArrowDown: [0, STEP], Enter: [0, 0] }[event.key];
          if (!by) return;
          event.preventDefault();
          event.stopPropagation();
          put(place.value[0] + (by[0] ?? 0), place.value[1] + (by[1] ?? 0), event.key === "Enter");
        }}
      >
        <i style={{ left: `${(100 * (place.value[0] - left)) / (right - left)}%`, top: `${(100 * (place.value[1] - back)) / (front - back)}%` }} />
      </div>
      <small>public</small>
    </div>
  );
}
