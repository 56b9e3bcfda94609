import { useSignal } from "@preact/signals";
import type { Panel, Studio } from "../model/studio";
import { entries, text } from "../model/score";
import { DRAGGED, placeOf } from "./timeline/timeline";

const PANELS: [Panel, string][] = [["steps", "Steps"], ["formations", "Formations"], ["elements", "Elements"]];
const SHAPES = ["line", "circle", "grid", "triangle", "star", "spiral", "diagonal", "semicircle"];
const ELEMENTS: [string, string][] = [
  ["attract", "gathers them"], ["repel", "drives them away"], ["spread", "spreads them over the stage"], ["cross", "has them change sides"],
  ["flow", "carries them"], ["path", "leads them along a line"], ["wander", "lets them wander"], ["flock", "moves them as a flock"],
];

interface Item {
  name: string;
  more: string;
  list: string;
  value: Record<string, unknown>;
}

/** What the show can be made of: dragged onto the timeline, or put at the cursor with Enter. */
export function Library({ studio }: { studio: Studio }) {
  const wanted = useSignal("");
  const items = itemsOf(studio).filter((item) => item.name.toLowerCase().includes(wanted.value.toLowerCase()));
  return (
    <section class="library" aria-label="Library">
      <header class="strip">
        <div class="choice" role="group" aria-label="Kind">
          {PANELS.map(([panel, words]) => (
            <button key={panel} aria-pressed={studio.panel.value === panel} onClick={() => { studio.panel.value = panel; }}>{words}</button>
          ))}
        </div>
      </header>
      <input type="search" placeholder="Search" aria-label="Search the library" value={wanted.value} onInput={(event) => { wanted.value = event.currentTarget.value; }} />
      <ul>
        {items.map((item) => (
          <li key={item.name}>
            <button
              draggable
              onDragStart={(event) => event.dataTransfer?.setData(DRAGGED, JSON.stringify({ list: item.list, value: item.value }))}
              onClick={() => void put(studio, item)}
              title="Drag it onto a row, or click: it is put at the cursor"
            >
              <b>{item.name}</b>
              <small>{item.more}</small>
            </button>
          </li>
        ))}
      </ul>
    </section>
  );
}

function itemsOf(studio: Studio): Item[] {
  switch (studio.panel.value) {
    case "steps":
      return (studio.doc.structure.value?.library ?? []).map((step) => ({
        name: step.name, more: step.measures === 1 ? "1 measure" : `${step.measures} measures`, list: "sequence", value: { steps: [step.name] },
      }));
    case "formations": {
      const own = entries(studio.score.value, "formation").map((entry) => ({ name: text(entry, "name"), more: "of this show" }));
      const shapes = SHAPES.map((name) => ({ name, more: "" }));
      return [...own, ...shapes].map((one) => ({ ...one, list: "segment", value: { formation: one.name, measures: 4 } }));
    }
    default:
      return ELEMENTS.map(([kind, words]) => ({ name: kind, more: words, list: "element", value: { kind, measures: 4, ...(["spread", "wander", "flock"].includes(kind) ? {} : { at: [0, 0] }), ...(kind === "cross" ? { to: [0, 2] } : {}) } }));
  }
}

async function put(studio: Studio, item: Item): Promise<void> {
  const measure = studio.cursor.value ?? Math.floor(studio.playhead.value ?? 0);
  studio.mode.value = item.list === "sequence" ? "steps" : "motion";
  await studio.insert(item.list, { ...item.value, ...placeOf(studio, measure), ...(studio.dancers.value.length ? { group: studio.dancers.value.join(" + ") } : {}) });
}
