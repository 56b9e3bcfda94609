import type { ComponentChildren } from "preact";
import { nearestTowards, type Place } from "../../model/geometry";
import type { StageState } from "../../model/stage_state";
import type { Studio } from "../../model/studio";
import { placeIn } from "./paint_marks";
import { isElementTool, type Drawing } from "./drawing";

const ARROWS: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const PEN_M = 0.25;

/** The floor for the keyboard: arrows go to the nearest dancer in their direction, or move the pen of a tool. */
export function DancerList({ studio, stage, drawing, children }: { studio: Studio; stage: StageState; drawing: Drawing; children?: ComponentChildren }) {
  const groups = studio.doc.structure.value?.groups ?? [];
  const chosen = new Set(studio.dancers.value);
  const rows = groups.flatMap((group) => Array.from({ length: group.dancers }, () => group.name));
  const focus = stage.focus.value;
  const still = stage.looked.value === null ? null : stage.momentPositions.value; // those who move are not read out
  const placeWords = (row: number): string => {
    if (!still?.present[row]) return "";
    const [x, z] = placeIn(still, row + 1);
    return `, at ${x.toFixed(1)}, ${z.toFixed(1)} m`;
  };
  return (
    <div
      class="dancers"
      role="listbox"
      tabIndex={0}
      aria-multiselectable="true"
      aria-label="Dancers on the stage: arrows go to the next one, Space selects, Ctrl+A all. With a tool: arrows move the pen, Enter puts a point"
      aria-activedescendant={focus ? `dancer-${focus}` : undefined}
      onBlur={() => { drawing.pen.value = null; }}
      onKeyDown={(event) => {
        if (onKey(studio, stage, drawing, event)) {
          event.preventDefault();
          event.stopPropagation();
        }
      }}
    >
      {rows.map((group, index) => (
        <div key={index} id={`dancer-${index + 1}`} class="unseen" role="option" aria-selected={chosen.has(index + 1)}>
          {group} {index + 1}{placeWords(index)}
        </div>
      ))}
      {children}
    </div>
  );
}

function onKey(studio: Studio, stage: StageState, drawing: Drawing, event: KeyboardEvent): boolean {
  const tool = stage.tool.value;
  const arrow = ARROWS[event.key];
  if (tool !== "select" && tool !== "lasso") return onPenKey(stage, drawing, event, arrow);
  if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === "a") {
    const positions = stage.shown.value;
    studio.dancers.value = Array.from({ length: positions?.count ?? 0 }, (_, row) => row + 1).filter((one) => positions?.present[one - 1]);
    return true;
  }
  if (event.ctrlKey || event.metaKey || event.altKey) return false;
  if (arrow) {
    const positions = stage.shown.value;
    if (!positions) return true;
    const places = Array.from({ length: positions.count }, (_, row): Place | null => (positions.present[row] ? placeIn(positions, row + 1) : null));
    const from = stage.focus.value ? placeIn(positions, stage.focus.value) : null;
    const found = from ? nearestTowards(places, from, arrow[0], arrow[1]) : places.findIndex((one) => one !== null);
    if (found >= 0) stage.focus.value = found + 1;
    if (event.shiftKey && found >= 0) studio.dancers.value = [...new Set([...studio.dancers.value, found + 1])].sort((a, b) => a - b);
    return true;
  }
  if ((event.key === " " || event.key === "Enter") && stage.focus.value) {
    drawing.toggle(stage.focus.value, event.key === " " || event.shiftKey);
    return true;
  }
  return false;
}

function onPenKey(stage: StageState, drawing: Drawing, event: KeyboardEvent, arrow: [number, number] | undefined): boolean {
  const pen = drawing.pen.value ?? [0, 0];
  if (arrow) {
    const far = event.shiftKey ? 4 * PEN_M : PEN_M;
    drawing.pen.value = drawing.pen.value ? [pen[0] + far * arrow[0], pen[1] + far * arrow[1]] : pen;
    return true;
  }
  switch (event.key) {
    case "Enter":
    case " ": {
      const tool = stage.tool.value;
      drawing.pen.value = pen;
      if (isElementTool(tool) && tool !== "cross") void drawing.put(tool, [pen]);
      else {
        const last = drawing.sketch.value?.points.at(-1);
        if (last && last[0] === pen[0] && last[1] === pen[1]) finish(stage, drawing);
        else drawing.addPoint(pen);
        if (tool === "cross" && (drawing.sketch.value?.points.length ?? 0) > 1) finish(stage, drawing);
      }
      return true;
    }
    case "Backspace":
      drawing.removePoint();
      return true;
    case "Escape":
      if (!drawing.sketch.value) stage.tool.value = "select";
      drawing.cancel();
      return true;
    default:
      return false;
  }
}

function finish(stage: StageState, drawing: Drawing): void {
  const points = drawing.sketch.value?.points ?? [];
  if (stage.tool.value !== "cross") drawing.finish();
  else {
    drawing.cancel();
    void drawing.put("cross", [points[0] as Place, points.at(-1) as Place]);
  }
}
