import { effect, useSignal } from "@preact/signals";
import { useEffect, useMemo, useRef } from "preact/hooks";
import { StageState } from "../../model/stage_state";
import type { Studio } from "../../model/studio";
import { stageSize } from "../../model/plan";
import { fit, toMetres, type Camera2D } from "./camera2d";
import { BendHandle, bendDrop } from "./bend_handle";
import { DancerList } from "./dancer_list";
import { Drawing } from "./drawing";
import { Faults } from "./faults";
import { Handles } from "./handles";
import { MomentBar } from "./moment_bar";
import { paint, type Scene, type Theme } from "./paint";
import { beginPlacing, PlaceHandles, PlacingBar } from "./placing";
import type { Written } from "./paint_marks";
import { SolidStage } from "./solid_stage";
import { StrokeForm } from "./stroke_form";
import { LineOptions, ToolBar, ToolOptions } from "./tool_bar";
import "./stage.css";

/** The stage from above, with everybody on it; and in 3D. */
export function StageView({ studio }: { studio: Studio }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const camera = useSignal<Camera2D>({ width: 1, height: 1, scale: 1 });
  const stage = useMemo(() => new StageState(studio), [studio]);
  const drawing = useMemo(() => new Drawing(studio, stage), [stage]);

  useEffect(() => stage.watch(), [stage]);
  useEffect(() => {
    const element = canvas.current as HTMLCanvasElement;
    const context = element.getContext("2d") as CanvasRenderingContext2D;
    const dark = matchMedia("(prefers-color-scheme: dark)");
    const theme = { value: themeOf(element) };
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
      const scene = sceneOf(studio, stage, drawing, camera.value);
      cancelAnimationFrame(asked);
      asked = requestAnimationFrame(() => {
        paint(context, { ...scene, theme: theme.value });
      });
    });
    const stopSize = effect(() => {
      void studio.score.value["stage"];
      resize();
    });
    const recolour = (): void => {
      theme.value = themeOf(element);
      camera.value = { ...camera.value };
    };
    dark.addEventListener("change", recolour);
    return () => {
      stop();
      stopSize();
      watch.disconnect();
      dark.removeEventListener("change", recolour);
    };
  }, [studio]);

  const placeAt = (event: PointerEvent | MouseEvent): [number, number] => {
    const box = (canvas.current as HTMLElement).getBoundingClientRect();
    return toMetres(camera.value, event.clientX - box.left, event.clientY - box.top);
  };
  const solid = stage.solid.value;
  return (
    <section class="stage" aria-label="Stage">
      <header class="strip">
        <h2>Stage</h2>
        <ToolBar studio={studio} stage={stage} onPlace={() => beginPlacing(studio, stage)} />
      </header>
      <MomentBar studio={studio} stage={stage} />
      <ToolOptions stage={stage} />
      <LineOptions stage={stage} drawing={drawing} />
      <PlacingBar studio={studio} stage={stage} />
      <div class={`floor tool-${stage.tool.value}${stage.stroke.value ? " with-form" : ""}`} {...(solid ? {} : bendDrop(stage, placeAt))}>
        <DancerList studio={studio} stage={stage} drawing={drawing}>
          <canvas
            ref={canvas}
            aria-hidden="true"
            onPointerDown={(event) => {
              if (event.button !== 0 || stage.placing.value) return;
              event.currentTarget.setPointerCapture(event.pointerId);
              drawing.down(placeAt(event), event.shiftKey, event.altKey);
            }}
            onPointerMove={(event) => {
              for (const each of event.getCoalescedEvents?.() ?? [event]) drawing.move(placeAt(each));
            }}
            onPointerUp={(event) => drawing.up(placeAt(event))}
            onPointerCancel={() => drawing.cancel()}
            onDblClick={() => {
              if (stage.tool.value === "line") drawing.finish();
            }}
          />
        </DancerList>
        {!solid && <Handles studio={studio} stage={stage} camera={camera} />}
        {!solid && <BendHandle studio={studio} stage={stage} camera={camera} />}
        {!solid && <PlaceHandles studio={studio} stage={stage} camera={camera} />}
        {solid && <SolidStage studio={studio} stage={stage} />}
        {stage.stroke.value && <StrokeForm studio={studio} stage={stage} stroke={stage.stroke.value} />}
        <Faults stage={stage} />
      </div>
    </section>
  );
}

export function groupOf(studio: Studio, count: number): Int16Array {
  const found = new Int16Array(count).fill(-1);
  let at = 0;
  studio.doc.structure.value?.groups.forEach((group, index) => {
    found.fill(index, at, at + group.dancers);
    at += group.dancers;
  });
  return found;
}

function sceneOf(studio: Studio, stage: StageState, drawing: Drawing, camera: Camera2D): Omit<Scene, "theme"> {
  const positions = stage.shown.value;
  const placing = stage.placing.value;
  const faults = stage.faults.value;
  return {
    camera, positions,
    ghost: placing ? null : stage.ghost.value,
    compared: stage.compared.value,
    stage: stageSize(studio.score.value),
    score: studio.score.value,
    groups: studio.doc.structure.value?.groups ?? [],
    groupOf: groupOf(studio, Math.max(positions?.count ?? 0, studio.doc.positions.peek()?.count ?? 0)),
    ways: stage.ways.value,
    own: stage.own.value,
    grounds: stage.bending.grounds.value,
    target: stage.bending.target.value,
    elements: stage.looked.value === null && !stage.played.value ? (studio.doc.clock.value?.elements ?? []) : [],
    written: writtenHere(studio, stage),
    chosen: new Set(studio.dancers.value),
    others: new Map([...studio.lookedAt.value].flatMap(([key, { colour }]) => (key.startsWith("dancer ") ? [[Number(key.slice(7)), colour] as const] : []))),
    alarmed: stage.alarmed.value,
    meetings: faults.meetings.map((one) => one.dancers),
    focus: stage.focus.value,
    labels: stage.labels.value,
    distances: stage.distances.value,
    held: stage.held.value,
    places: placing ? placing.places : stage.studio.dragAnswer.value ? [] : stage.thought.value,
    sketch: drawing.sketch.value ?? (stage.stroke.value ? { points: stage.stroke.value.points, closed: stage.stroke.value.closed, kind: "line" } : null),
    pen: drawing.pen.value,
  };
}

/** Elements and ways of the score that are selected, and elements that act in the measure that is looked at. */
function writtenHere(studio: Studio, stage: StageState): Written[] {
  const cursor = studio.cursor.value;
  const acting = stage.looked.value === null || cursor === null ? [] : studio.boxes.value.filter((box) => box.list === "element" && box.start <= cursor && cursor < box.start + box.length);
  const chosen = studio.selected.value.filter((one) => one.list === "element" || one.list === "segment");
  const found = chosen.flatMap((one) => {
    const entry = studio.entry(one);
    return entry ? [{ kind: one.list === "segment" ? "formation" : String(entry["kind"] ?? ""), entry, selected: true }] : [];
  });
  const others = acting.filter((box) => !studio.isSelected(box)).map((box) => ({ kind: box.label, entry: box.entry, selected: false }));
  return [...others, ...found];
}

function themeOf(element: HTMLElement): Theme {
  const style = getComputedStyle(element);
  const read = (name: string): string => style.getPropertyValue(name).trim();
  return { floor: read("--floor"), line: read("--line"), ink: read("--ink"), dim: read("--dim"), accent: read("--accent"), alarm: read("--alarm"), named: read };
}
