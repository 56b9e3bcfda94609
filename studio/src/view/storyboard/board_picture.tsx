import type { Studio } from "../../model/studio";
import type { Taken } from "../../model/storyboard";
import { stageSize } from "../../model/plan";
import { colourOf } from "../stage/paint";

const BODY = 0.24;

/** A picture of the stage as a drawing that prints sharp: everybody, and the ways they came. */
export function BoardPicture({ studio, taken, before, groupOf, dancer }: { studio: Studio; taken: Taken; before: Taken | null; groupOf: Int16Array; dancer: number | null }) {
  const { width, depth } = stageSize(studio.score.value);
  const groups = studio.doc.structure.value?.groups ?? [];
  const rows = [...taken.present.keys()].filter((row) => taken.present[row]);
  const at = (from: Taken, row: number): [number, number] => [from.rows[3 * row] ?? 0, from.rows[3 * row + 1] ?? 0];
  return (
    <svg class="board" viewBox={`${-width / 2 - 0.3} ${-depth / 2 - 0.3} ${width + 0.6} ${depth + 0.6}`} role="img" aria-label={`${rows.length} dancers`}>
      <rect class="floor" x={-width / 2} y={-depth / 2} width={width} height={depth} />
      <line class="axis" x1={0} y1={-depth / 2} x2={0} y2={depth / 2} />
      {before && rows.map((row) => {
        if (!before.present[row]) return null;
        const [x, z] = at(taken, row);
        const [fromX, fromZ] = at(before, row);
        if (Math.hypot(x - fromX, z - fromZ) < 0.15) return null;
        return <line key={row} class={dancer === row + 1 ? "way own" : "way"} x1={fromX} y1={fromZ} x2={x} y2={z} stroke={colourOf(groups[groupOf[row] ?? 0])} />;
      })}
      {rows.map((row) => {
        const [x, z] = at(taken, row);
        const turn = taken.rows[3 * row + 2] ?? 0;
        const other = dancer !== null && dancer !== row + 1;
        return (
          <g key={row} class={other ? "other" : ""} transform={`translate(${x} ${z}) rotate(${(-turn * 180) / Math.PI})`}>
            <circle r={BODY} fill={colourOf(groups[groupOf[row] ?? 0])} />
            <path d={`M0 ${BODY * 0.86} L${BODY * 0.55} ${-BODY * 0.45} L${-BODY * 0.55} ${-BODY * 0.45} Z`} class="facing" />
          </g>
        );
      })}
      {dancer !== null && rows.includes(dancer - 1) && <circle class="mine" cx={at(taken, dancer - 1)[0]} cy={at(taken, dancer - 1)[1]} r={BODY * 1.6} />}
    </svg>
  );
}
