import { useSignal } from "@preact/signals";
import { useRef } from "preact/hooks";
import { isDrawn, linesOf, simplified, withShape, type Places } from "../../model/formations";
import { stageSize } from "../../model/plan";
import type { Entry } from "../../model/score";
import type { Studio } from "../../model/studio";

type Tool = "move" | "draw" | "points";
type Point = [number, number];

const MARGIN_M = 0.8;
const NUDGE_M = 0.1;
const TOOLS: [Tool, string, string][] = [
  ["move", "Move", "Drag the formation, or its points"], ["draw", "Draw", "Draw lines by hand"], ["points", "Points", "Each click adds a point to the last line"],
];

/** A small stage on which a formation is drawn and moved, with its places. Points are handles, by keyboard too. */
export function DrawingBoard({ studio, table, places, onChange }: { studio: Studio; table: Entry; places: Places | null; onChange: (table: Entry) => void }) {
  const board = useRef<SVGSVGElement>(null);
  const tool = useSignal<Tool>("move");
  const stroke = useSignal<Point[]>([]);
  const held = useSignal<{ from: Point; centre: Point } | { line: number; point: number } | null>(null);
  const stage = stageSize(studio.score.value);
  const drawn = isDrawn(table);
  const lines = drawn ? linesOf(table) : [];
  const centre = (table["centre"] as Point | undefined) ?? [0, 0];
  const fitted = drawn && (table["size"] !== undefined || Boolean(table["rotation_deg"])); // its points are not metres of the stage
  const handles = drawn && !fitted ? lines.flatMap((line, index) => line.slice(0, 80).map((place, point) => ({ line: index, point, place }))) : [];

  const at = (event: PointerEvent): Point => {
    const box = (board.current as SVGSVGElement).getBoundingClientRect();
    const scale = Math.max((stage.width + 2 * MARGIN_M) / box.width, (stage.depth + 2 * MARGIN_M) / box.height);
    return [round((event.clientX - box.left - box.width / 2) * scale), round((event.clientY - box.top - box.height / 2) * scale)];
  };
  const setLines = (made: Point[][]): void => {
    const kept = made.filter((line) => line.length);
    const points = table["shape"] === "places" ? kept.flat() : kept;
    const base = drawn ? table : withShape(table, "polyline");
    const turned = table["shape"] === "places" ? (table["headings_deg"] as number[] | undefined) : undefined;
    const headings = turned ? { headings_deg: points.map((_, index) => turned[index] ?? 0) } : {};
    onChange({ ...base, ...headings, ...(drawn && !fitted ? {} : { size: undefined, centre: undefined, rotation_deg: undefined }), points });
  };
  const movePoint = (line: number, point: number, place: Point): void => {
    setLines(lines.map((one, index) => (index === line ? one.map((each, number) => (number === point ? place : each)) : one)));
  };

  return (
    <div class="board">
      <div class="tools" role="group" aria-label="Tool">
        {TOOLS.filter(([name]) => name === "move" || table["like"] === undefined).map(([name, words, more]) => <button key={name} aria-pressed={tool.value === name} title={more} onClick={() => { tool.value = name; }}>{words}</button>)}
        {drawn && <button onClick={() => setLines([...lines, ...(table["shape"] === "places" ? [[[0, 0] as Point]] : [[[-1, 0], [1, 0]] as Point[]])])}>{table["shape"] === "places" ? "Add a place" : "Add a line"}</button>}
        {lines.length > 1 && table["shape"] !== "places" && <button onClick={() => setLines(lines.slice(0, -1))}>Take the last line away</button>}
      </div>
      <svg
        ref={board}
        class={`plan ${tool.value}`}
        viewBox={`${-stage.width / 2 - MARGIN_M} ${-stage.depth / 2 - MARGIN_M} ${stage.width + 2 * MARGIN_M} ${stage.depth + 2 * MARGIN_M}`}
        role="group"
        aria-label="Drawing board: the stage from above, the public below. Arrow keys move the formation"
        tabIndex={0}
        onKeyDown={(event) => {
          const by = ARROWS[event.key];
          if (!by || event.target !== event.currentTarget) return;
          event.preventDefault();
          const far = event.shiftKey ? 10 * NUDGE_M : NUDGE_M;
          onChange({ ...table, centre: [round(centre[0] + far * by[0]), round(centre[1] + far * by[1])] });
        }}
        onPointerDown={(event) => {
          if (event.button !== 0 || (event.target as Element).closest("[data-point]")) return;
          (event.currentTarget as SVGSVGElement).setPointerCapture(event.pointerId);
          const place = at(event);
          if (tool.value === "draw") stroke.value = [place];
          else if (tool.value === "points") {
            const moved: Point = drawn && !fitted ? [round(place[0] - centre[0]), round(place[1] - centre[1])] : place;
            setLines(drawn && !fitted && lines.length ? [...lines.slice(0, -1), [...(lines.at(-1) as Point[]), moved]] : [[moved, [round(moved[0] + 0.5), moved[1]]]]);
          } else held.value = { from: place, centre };
        }}
        onPointerMove={(event) => {
          const place = at(event);
          if (stroke.value.length) stroke.value = [...stroke.value, place];
          else if (held.value && "from" in held.value) {
            const { from, centre: before } = held.value;
            onChange({ ...table, centre: [round(before[0] + place[0] - from[0]), round(before[1] + place[1] - from[1])] });
          } else if (held.value) movePoint(held.value.line, held.value.point, [round(place[0] - centre[0]), round(place[1] - centre[1])]);
        }}
        onPointerUp={() => {
          const line = simplified(stroke.value).map(([x, z]): Point => (drawn && !fitted ? [round(x - centre[0]), round(z - centre[1])] : [x, z]));
          if (line.length > 1) {
            const [first, last] = [line[0] as Point, line.at(-1) as Point];
            if (line.length > 3 && Math.hypot(first[0] - last[0], first[1] - last[1]) < 0.35) line[line.length - 1] = first; // closed
            setLines(drawn && !fitted ? [...lines, line] : [line]);
          }
          stroke.value = [];
          held.value = null;
        }}
        onPointerCancel={() => { stroke.value = []; held.value = null; }}
      >
        <rect class="floorplan" x={-stage.width / 2} y={-stage.depth / 2} width={stage.width} height={stage.depth} />
        <line class="middle" x1="0" x2="0" y1={-stage.depth / 2} y2={stage.depth / 2} vector-effect="non-scaling-stroke" />
        <text x="0" y={stage.depth / 2 + 0.42} text-anchor="middle" font-size="0.19">public</text>
        {places?.lines.map((line, index) => <polyline key={index} points={line.map(([x, z]) => `${x},${z}`).join(" ")} vector-effect="non-scaling-stroke" />)}
        {stroke.value.length > 1 && <polyline class="stroke" points={stroke.value.map(([x, z]) => `${x},${z}`).join(" ")} vector-effect="non-scaling-stroke" />}
        {places?.slots.map(([x, z], index) => (
          <g key={index} class={places.outside.includes(index + 1) ? "outside" : index < places.soloists ? "soloist" : ""}>
            <circle cx={x} cy={z} r="0.22" />
            <path d="M 0 0.19 L -0.12 -0.1 L 0.12 -0.1 Z" transform={`translate(${x} ${z}) rotate(${(-(places.heading[index] ?? 0) * 180) / Math.PI})`} />
          </g>
        ))}
        {handles.map(({ line, point, place }) => (
          <circle
            key={`${line} ${point}`}
            data-point=""
            class="point"
            role="button"
            tabIndex={0}
            aria-label={`Point ${point + 1} of line ${line + 1} at ${place[0].toFixed(1)}, ${place[1].toFixed(1)} m; arrows move it, Delete takes it away`}
            cx={place[0] + centre[0]}
            cy={place[1] + centre[1]}
            r="0.14"
            onPointerDown={(event) => {
              (board.current as SVGSVGElement).setPointerCapture(event.pointerId);
              held.value = { line, point };
            }}
            onKeyDown={(event) => {
              const by = ARROWS[event.key];
              if (event.key === "Delete" || event.key === "Backspace") {
                event.preventDefault();
                setLines(lines.map((one, index) => (index === line ? one.filter((_, at) => at !== point) : one)).filter((one) => one.length > 1 || table["shape"] === "places"));
              }
              if (!by) return;
              event.preventDefault();
              event.stopPropagation();
              const far = event.shiftKey ? 10 * NUDGE_M : NUDGE_M;
              movePoint(line, point, [round(place[0] + far * by[0]), round(place[1] + far * by[1])]);
            }}
          />
        ))}
      </svg>
    </div>
  );
}

const ARROWS: Record<string, Point> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

function round(value: number): number {
  return Math.round(value * 100) / 100;
}
