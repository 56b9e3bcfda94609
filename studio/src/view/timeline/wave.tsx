import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { peaksOf } from "../../model/wave";
import type { Studio } from "../../model/studio";
import type { Waveform } from "../../net/frames";
import type { TimelineState } from "./state";

const HEIGHT = 34;
const kept = new Map<string, Waveform>();

/** The waveform of the music: a canvas of the visible measures. */
export function Wave({ studio, state }: { studio: Studio; state: TimelineState }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const wave = useSignal<Waveform | null>(null);
  const music = (studio.score.value["music"] ?? {}) as Record<string, unknown>;
  const file = typeof music["file"] === "string" ? music["file"] : "";
  useEffect(() => {
    wave.value = kept.get(file) ?? null;
    if (!file || wave.value) return;
    let wanted = true;
    void studio.preview.ask({ waveform: true }, "waveform").then((answer) => {
      if (!answer.waveform) return;
      kept.set(file, answer.waveform);
      if (wanted) wave.value = answer.waveform;
    });
    return () => { wanted = false; };
  }, [file]);
  useEffect(() => {
    const { element } = state;
    const own = canvas.current;
    if (!element || !own) return;
    let asked = 0;
    const values = new Float32Array(8192);
    const draw = (): void => {
      asked = 0;
      const found = wave.peek();
      const width = Math.max(0, element.clientWidth - state.names.peek());
      const ratio = window.devicePixelRatio || 1;
      if (own.width !== Math.round(width * ratio) || own.height !== HEIGHT * ratio) {
        own.width = Math.round(width * ratio);
        own.height = HEIGHT * ratio;
        own.style.width = `${width}px`;
      }
      const context = own.getContext("2d");
      if (!context) return;
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      context.clearRect(0, 0, width, HEIGHT);
      if (!found) return;
      const count = peaksOf(found, studio.score.peek(), element.scrollLeft, width, studio.scale.peek(), values);
      context.fillStyle = getComputedStyle(own).color;
      context.beginPath();
      for (let pixel = 0; pixel < count; pixel++) {
        const half = Math.max(0.5, (values[pixel] as number) * 0.5 * (HEIGHT - 2));
        context.rect(pixel, HEIGHT / 2 - half, 1, 2 * half);
      }
      context.fill();
    };
    const ask = (): void => {
      if (!asked) asked = requestAnimationFrame(draw);
    };
    const stops = [studio.scale.subscribe(ask), wave.subscribe(ask), studio.score.subscribe(ask)];
    element.addEventListener("scroll", ask, { passive: true });
    const sizes = new ResizeObserver(ask);
    sizes.observe(element);
    const scheme = matchMedia("(prefers-color-scheme: dark)");
    scheme.addEventListener("change", ask);
    return () => {
      cancelAnimationFrame(asked);
      for (const stop of stops) stop();
      element.removeEventListener("scroll", ask);
      sizes.disconnect();
      scheme.removeEventListener("change", ask);
    };
  }, [studio, state]);
  return (
    <div class="wave">
      <canvas ref={canvas} height={HEIGHT} aria-hidden="true" />
      {!file && <span class="hint">No music yet</span>}
    </div>
  );
}
