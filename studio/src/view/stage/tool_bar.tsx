import type { Signal } from "@preact/signals";
import type { Labels, StageState, Tool } from "../../model/stage_state";
import type { Studio } from "../../model/studio";
import { colourOf } from "./paint";
import { wordsOfDancers } from "../../model/form";
import type { Becomes } from "../../model/stage_edits";
import { isDrawingTool, isElementTool, type Drawing } from "./drawing";
import { BendSelect, CHOICES } from "./stroke_form";

/** Name, title and the path of the icon, in a square of 16. */
const TOOLS: [Tool, string, string][] = [
  ["select", "Select: click dancers, or draw a box around them", "M3 2l9 6.5-4 .7 2.4 4.3-1.8 1L6.2 10 3.4 13z"],
  ["lasso", "Lasso: draw around dancers; a click adds one", "M8 3c3.3 0 6 1.7 6 3.8S11.300 10.500 8 10.500 2 9 2 6.800 4.700 3 8 3zM5 10c-1 1.500-.5 3 1 3.500"],
  ["line", "Line: click its points; Enter or a double click ends it", "M2.500 13L7 5l6.500 3.500"],
  ["curve", "Curve: draw freehand", "M2 12c2-9 5-9 6-4s4 4 6-4"],
  ["shape", "Closed shape: draw its outline", "M8 2.500c4 0 6 2 5.500 5.500S10 13 7 13.500 2 11 2.500 7.500 5 2.500 8 2.500z"],
  ["attract", "Gather: click where dancers gather", "M8 1v4M6 3.500L8 5.500l2-2M8 15v-4M6 12.500l2-2 2 2M1 8h4M3.500 6l2 2-2 2M15 8h-4M12.500 6l-2 2 2 2"],
  ["repel", "Drive away: click what dancers leave", "M8 6V1M6 3l2-2 2 2M8 10v5M6 13l2 2 2-2M6 8H1M3 6L1 8l2 2M10 8h5M13 6l2 2-2 2"],
  ["spread", "Spread over the stage: click", "M3 3h.1M8 3h.1M13 3h.1M3 8h.1M8 8h.1M13 8h.1M3 13h.1M8 13h.1M13 13h.1"],
  ["cross", "Change sides: draw the bar that they cross", "M8 1v14M2 5h4M4 3.500L6 5 4 6.500M14 11h-4M12 9.500L10 11l2 1.500"],
];

/** Tools, and what is shown. */
export function ToolBar({ studio, stage, onPlace }: { studio: Studio; stage: StageState; onPlace: () => void }) {
  return (
    <>
      <div class="choice toolbox" role="radiogroup" aria-label="Tool">
        {TOOLS.map(([tool, words, path]) => (
          <button
            key={tool}
            role="radio"
            aria-checked={stage.tool.value === tool}
            aria-label={words}
            title={words}
            onClick={() => { stage.tool.value = tool; }}
          >
            <svg viewBox="0 0 16 16" aria-hidden="true"><path d={path} /></svg>
          </button>
        ))}
      </div>
      <div class="toolbox">
        <button
          aria-pressed={stage.placing.value !== null} aria-label="Place by hand" disabled={stage.placing.value !== null}
          title="Place by hand: a formation from where they stand" onClick={onPlace}
        >
          <svg viewBox="0 0 16 16" aria-hidden="true"><path d="M5 2.500a2.500 2.500 0 1 1 0 5 2.500 2.500 0 1 1 0-5zM12 9a2.500 2.500 0 1 1 0 5 2.500 2.500 0 1 1 0-5zM9 4h5M12 2l2 2-2 2" /></svg>
        </button>
      </div>
      <select aria-label="Above each dancer" value={stage.labels.value} onChange={(event) => { stage.labels.value = event.currentTarget.value as Labels; }}>
        <option value="none">No labels</option>
        <option value="numbers">Numbers</option>
        <option value="names">Names</option>
      </select>
      <Switch value={stage.distances} words="Distances" />
      <Switch value={stage.solid} words="3D" />
      <div class="groups" role="group" aria-label="Select a group">
        {groupSpans(studio).map(({ name, colour, members }) => (
          <button
            key={name}
            aria-pressed={members.length > 0 && members.every((one) => studio.dancers.value.includes(one))}
            title={`Select ${name}; with Shift in addition`}
            onClick={(event) => {
              studio.dancers.value = event.shiftKey ? [...new Set([...studio.dancers.value, ...members])].sort((a, b) => a - b) : members;
            }}
          >
            <i style={{ background: colour }} />
            <span>{name}</span>
          </button>
        ))}
      </div>
    </>
  );
}

export function Switch({ value, words }: { value: Signal<boolean>; words: string }) {
  return <button aria-pressed={value.value} onClick={() => { value.value = !value.value; }}>{words}</button>;
}

function groupSpans(studio: Studio): { name: string; colour: string; members: number[] }[] {
  let at = 0;
  return (studio.doc.structure.value?.groups ?? []).map((group) => {
    const members = Array.from({ length: group.dancers }, (_, index) => at + index + 1);
    at += group.dancers;
    return { name: group.name, colour: colourOf(group), members };
  });
}

/** What the chosen tool does, and to whom. */
export function ToolOptions({ stage }: { stage: StageState }) {
  const tool = stage.tool.value;
  if (!isElementTool(tool)) return isDrawingTool(tool) && !stage.stroke.value ? <DrawnOptions stage={stage} /> : null;
  return (
    <div class="strip options" role="group" aria-label="The element">
      <span class="hint">{stage.studio.whom.value === "*" ? "everybody" : wordsOfDancers(stage.studio.whom.value)}</span>
      <NumberField words="strength" value={stage.strength} least={0.1} most={10} step={0.1} />
      <NumberField words="measures" value={stage.measures} least={1} most={64} step={1} />
      <Switch value={stage.live} words="Live" />
      <span class="hint">{stage.live.value ? "acts at once in the show" : `from measure ${stage.here() + 1} of the score`}</span>
    </div>
  );
}

/** What a line becomes that is drawn, and whose ways are planned together with those that it makes. */
function DrawnOptions({ stage }: { stage: StageState }) {
  const { becomes } = stage;
  const together = stage.together.value;
  const { meetings } = stage.faults.value;
  return (
    <div class="strip options" role="group" aria-label="What is drawn">
      <label class="field">
        becomes
        <select value={becomes.value} onChange={(event) => { becomes.value = event.currentTarget.value as Becomes; }}>
          {CHOICES.map(([value, words]) => <option key={value} value={value}>{words.toLowerCase()}</option>)}
        </select>
      </label>
      {becomes.value === "bend" ? <BendSelect stage={stage} /> : <span class="hint">{stage.studio.whom.value === "*" ? "everybody" : wordsOfDancers(stage.studio.whom.value)}</span>}
      <span class="hint" role="status">{together.length ? `planned together with ${together.join(", ")}${meetings.length ? `: ${meetings.length} ${meetings.length === 1 ? "pair meets" : "pairs meet"}` : ""}` : `from measure ${stage.here() + 1} of the score`}</span>
    </div>
  );
}

/** A line that is drawn by clicks or taps: how it ends. */
export function LineOptions({ stage, drawing }: { stage: StageState; drawing: Drawing }) {
  const points = drawing.sketch.value?.kind === "line" && stage.tool.value === "line" ? drawing.sketch.value.points.length : 0;
  if (!points) return null;
  return (
    <div class="strip options" role="group" aria-label="The line">
      <span class="hint">{points} {points === 1 ? "point" : "points"}</span>
      <button class="primary" disabled={points < 2} onClick={() => drawing.finish()}>Finish</button>
      <button onClick={() => drawing.removePoint()}>One point back</button>
      <button onClick={() => drawing.cancel()}>Cancel</button>
    </div>
  );
}

export function NumberField({ words, value, least, most, step }: { words: string; value: Signal<number>; least: number; most: number; step: number }) {
  return (
    <label class="field">
      {words}
      <input
        type="number" min={least} max={most} step={step} value={value.value}
        onChange={(event) => {
          const said = Number(event.currentTarget.value);
          if (Number.isFinite(said)) value.value = Math.min(most, Math.max(least, said));
        }}
      />
    </label>
  );
}
