import { useSignal } from "@preact/signals";
import type { Panel, Studio } from "../../model/studio";
import { GapBar } from "../ways/gap_bar";
import { ElementsPanel } from "./elements_panel";
import { FormationsPanel } from "./formations_panel";
import { StepsPanel } from "./steps_panel";
import "./library.css";

const PANELS: [Panel, string][] = [["steps", "Steps"], ["formations", "Formations"], ["elements", "Elements"]];

/** What the show can be made of: dragged onto the timeline, or put at the cursor with Enter. */
export function Library({ studio }: { studio: Studio }) {
  const wanted = useSignal("");
  const panel = studio.panel.value;
  return (
    <section class="library" aria-label="Library">
      <header class="strip">
        <div class="choice" role="group" aria-label="Kind">
          {PANELS.map(([name, words]) => (
            <button key={name} aria-pressed={panel === name} onClick={() => { studio.panel.value = name; }}>{words}</button>
          ))}
        </div>
      </header>
      <input type="search" placeholder="Search" aria-label="Search the library" value={wanted.value} onInput={(event) => { wanted.value = event.currentTarget.value; }} />
      {panel === "steps" && <StepsPanel studio={studio} wanted={wanted.value} />}
      {panel === "formations" && <FormationsPanel studio={studio} wanted={wanted.value} />}
      {panel === "elements" && <ElementsPanel studio={studio} wanted={wanted.value} />}
      <GapBar studio={studio} />
    </section>
  );
}
