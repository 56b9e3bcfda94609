import type { Studio } from "../../model/studio";
import { drag, onEnter, putAtCursor } from "./put";

const ELEMENTS: [string, string][] = [
  ["attract", "gathers them"], ["repel", "drives them away"], ["spread", "spreads them over the stage"], ["cross", "has them change sides"],
  ["flow", "carries them"], ["path", "leads them along a line"], ["wander", "lets them wander"], ["flock", "moves them as a flock"],
];
const EVERYWHERE = ["spread", "wander", "flock"];

/** What moves dancers without a formation: put somewhere on the stage for some measures. */
export function ElementsPanel({ studio, wanted }: { studio: Studio; wanted: string }) {
  const found = ELEMENTS.filter(([kind, words]) => `${kind} ${words}`.includes(wanted.toLowerCase()));
  return (
    <ul class="items" aria-label="Elements">
      {found.map(([kind, words]) => {
        const item = {
          list: "element",
          value: { kind, measures: 4, ...(EVERYWHERE.includes(kind) ? {} : { at: [0, 0] }), ...(kind === "cross" ? { to: [0, 2] } : {}) },
        };
        return (
          <li key={kind}>
            <button draggable class="plainrow" title="Drag it onto a row, or click: it is put at the cursor" onDragStart={(event) => drag(studio, event, item)} onKeyDown={onEnter(() => void putAtCursor(studio, item))} onClick={() => void putAtCursor(studio, item)}>
              <b>{kind}</b>
              <small>{words}</small>
            </button>
          </li>
        );
      })}
    </ul>
  );
}
