import { effect, useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { Studio } from "../../model/studio";
import { stageSize } from "../../model/plan";
import { fit, toMetres, toPixels, type Camera2D } from "./camera2d";
import { paint, type Scene, type Theme } from "./paint";
import { Handles } from "./handles";

const GRAB_M = 0.4;

/** The stage from above, with everybody on it; and in 3D. */
export function StageView({ studio }: { studio: Studio }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const camera = useSignal<Camera2D>({ width: 1, height: 1, scale: 1 });
  const names = useSignal(false);
  const solid = useSignal(false);

  useEffect(() => {
    const element = canvas.current as HTMLCanvasElement;
    const context = element.getContext("2d") as CanvasRenderingContext2D;
    let asked = 0;
    const resize = (): void => {
      const box = element.getBoundingClientRect();
      const ratio = window.devicePixelRatio || 1;
      element.width = Math.round(box.width * ratio);
      element.height = Math.round(box.height * ratio);
      context.setTransform(ratio, 0, 0, ratio, 0, 0);
      camera.value = fit(box.width, box.height, stageSize(studio.score.value));
    };
    const watch = new ResizeObserver(resize);
    watch.observe(element);
    const stop = effect(() => {
      const scene = sceneOf(studio, camera.value, names.value);
      cancelAnimationFrame(asked);
      asked = requestAnimationFrame(() => paint(context, { ...scene, theme: themeOf(element) }));
    });
    const stopSize = effect(() => {
      void studio.score.value["stage"];
      resize();
    });
    return () => {
      stop();
      stopSize();
      watch.disconnect();
    };
  }, [studio]);

  return (
    <section class="stage" aria-label="Stage">
      <header class="strip">
        <h2>Stage</h2>
        <label class="switch"><input type="checkbox" checked={names.value} onChange={() => { names.value = !names.value; }} /> numbers</label>
        <label class="switch"><input type="checkbox" checked={solid.value} onChange={() => { solid.value = !solid.value; }} /> 3D</label>
        <span class="hint">{hint(studio)}</span>
      </header>
      <div class="floor">
        <canvas
          ref={canvas}
          role="img"
          aria-label={`The stage from above with ${present(studio)} dancers`}
          onPointerDown={(event) => {
            const box = (event.currentTarget as HTMLElement).getBoundingClientRect();
            choose(studio, toMetres(camera.value, event.clientX - box.left, event.clientY - box.top), event.shiftKey);
          }}
        />
        <Handles studio={studio} camera={camera} />
      </div>
    </section>
  );
}

function hint(studio: Studio): string {
  const count = studio.dancers.value.length;
  return count ? `${count} selected: ${studio.dancers.value.slice(0, 12).join(", ")}${count > 12 ? " …" : ""}` : "";
}

function present(studio: Studio): number {
  return studio.doc.positions.value?.present.reduce((sum, one) => sum + one, 0) ?? 0;
}

function choose(studio: Studio, [x, z]: [number, number], more: boolean): void {
  const positions = studio.doc.positions.value;
  let nearest = 0;
  let distance = GRAB_M;
  for (let row = 0; row < (positions?.count ?? 0); row++) {
    if (!positions?.present[row]) continue;
    const away = Math.hypot((positions.rows[3 * row] ?? 0) - x, (positions.rows[3 * row + 1] ?? 0) - z);
    if (away < distance) [nearest, distance] = [row + 1, away];
  }
  const known = studio.dancers.value;
  if (!nearest) studio.dancers.value = more ? known : [];
  else if (!more) studio.dancers.value = [nearest];
  else studio.dancers.value = known.includes(nearest) ? known.filter((one) => one !== nearest) : [...known, nearest].sort((a, b) => a - b);
}

export function groupOf(studio: Studio, count: number): Int16Array {
  const found = new Int16Array(count);
  let at = 0;
  studio.doc.structure.value?.groups.forEach((group, index) => {
    found.fill(index, at, at + group.dancers);
    at += group.dancers;
  });
  return found;
}

function sceneOf(studio: Studio, camera: Camera2D, names: boolean): Omit<Scene, "theme"> {
  const positions = studio.doc.positions.value;
  return {
    camera, names, positions, ghost: null,
    stage: stageSize(studio.score.value),
    score: studio.score.value,
    groups: studio.doc.structure.value?.groups ?? [],
    groupOf: groupOf(studio, positions?.count ?? 0),
    ways: studio.doc.ways.value,
    elements: studio.doc.clock.value?.elements ?? [],
    chosen: new Set(studio.dancers.value),
    alarmed: new Set(),
  };
}

function themeOf(element: HTMLElement): Theme {
  const style = getComputedStyle(element);
  const read = (name: string): string => style.getPropertyValue(name).trim();
  return { floor: read("--floor"), line: read("--line"), ink: read("--ink"), dim: read("--dim"), accent: read("--accent"), alarm: read("--alarm") };
}

export { toPixels };
