import type { Signal } from "@preact/signals";
import { chosenSegment } from "../../model/drawn";
import type { Place } from "../../model/geometry";
import { groundWords, materialOf, type Material } from "../../model/material";
import type { StageState } from "../../model/stage_state";
import type { Studio } from "../../model/studio";
import { dragging } from "../timeline/timeline";
import { toMetres, toPixels, type Camera2D } from "./camera2d";

/** The selected group's motion as a thing to take: dragged onto a region or a line it bends. By keyboard: arrows choose where, Enter keeps it. */
export function BendHandle({ studio, stage, camera }: { studio: Studio; stage: StageState; camera: Signal<Camera2D> }) {
  const { bending } = stage;
  const material = materialOf(studio.score.value, chosenSegment(stage));
  const middle = middleOf(stage);
  if (!material || !middle || stage.placing.value || stage.played.value) return null;
  const held = bending.held.value !== null;
  const target = bending.target.value;
  const [px, py] = toPixels(camera.value, middle[0], middle[1]);
  const placeOf = (event: PointerEvent & { currentTarget: HTMLElement }): Place => {
    const box = (event.currentTarget.parentElement as HTMLElement).getBoundingClientRect();
    return toMetres(camera.value, event.clientX - box.left, event.clientY - box.top);
  };
  return (
    <div class="handles">
      <button
        class="bend" style={{ left: `${px}px`, top: `${py}px` }} aria-pressed={held}
        aria-label={`Bend ${material.name}: drag it onto a region or a line; arrows choose one, Enter keeps it`} title="Drag it onto a region or a line: it bends"
        onPointerDown={(event) => {
          event.stopPropagation();
          event.currentTarget.setPointerCapture(event.pointerId);
          void bending.begin(material);
        }}
        onPointerMove={(event) => { if (bending.held.value && event.currentTarget.hasPointerCapture(event.pointerId)) bending.over(placeOf(event)); }}
        onPointerUp={() => void bending.drop()}
        onPointerCancel={() => bending.cancel()}
        onBlur={() => { if (held) bending.cancel(); }}
        onKeyDown={(event) => void onKey(event, stage, material)}
      >
        <svg viewBox="0 0 16 16" aria-hidden="true"><path d="M2 12c0-6 4-9 9-9M8.500 1L11.500 3 9.500 6M5 14c0-4 2.500-6.500 6.500-6.500M14 7.500h-1" /></svg>
      </button>
      <span class="unseen" role="status">{held ? (target ? groundWords(target) : bending.grounds.value.length ? "" : "There is no region and no line to bend it to") : ""}</span>
    </div>
  );
}

async function onKey(event: KeyboardEvent, stage: StageState, material: Material): Promise<void> {
  const { bending } = stage;
  const by = { ArrowLeft: -1, ArrowUp: -1, ArrowRight: 1, ArrowDown: 1 }[event.key];
  const isHeld = bending.held.value !== null;
  if (!by && !(isHeld && ["Enter", "Escape"].includes(event.key))) return;
  event.preventDefault();
  event.stopPropagation();
  if (event.key === "Enter") await bending.drop();
  else if (event.key === "Escape") bending.cancel();
  else {
    if (!isHeld) await bending.begin(material);
    bending.next(by as number);
  }
}

/** The middle of where those of the selected segment arrive. */
function middleOf(stage: StageState): Place | null {
  const told = stage.segmentAnswer.value?.texts["ways"] as unknown as { ways?: Place[][] } | undefined;
  const ends = (told?.ways ?? []).flatMap((way) => (way.length ? [way.at(-1) as Place] : []));
  if (!ends.length) return null;
  return [ends.reduce((sum, [x]) => sum + x, 0) / ends.length, ends.reduce((sum, [, z]) => sum + z, 0) / ends.length];
}

/** A formation or evolution that comes from the library over the floor. */
export function bendDrop(stage: StageState, placeAt: (event: DragEvent) => Place): Record<string, (event: DragEvent) => void> {
  const { bending } = stage;
  return {
    onDragOver: (event) => {
      const value = dragging.now?.list === "segment" ? dragging.now.value : null;
      const list = value?.["evolution"] ? "evolution" : "formation";
      const name = value?.[list];
      if (typeof name !== "string") return;
      event.preventDefault();
      const held = bending.held.value;
      if (held?.name !== name || held.list !== list) void bending.begin({ list, name, segment: 0 });
      bending.over(placeAt(event));
    },
    onDragLeave: (event) => {
      if (!(event.currentTarget as HTMLElement).contains(event.relatedTarget as Node | null)) bending.cancel();
    },
    onDrop: (event) => {
      if (!bending.held.value) return;
      event.preventDefault();
      if (!bending.target.value) stage.studio.doc.tell("told", "Nothing was put: drop it on a region or a line, or on a row of the timeline");
      void bending.drop();
    },
  };
}
