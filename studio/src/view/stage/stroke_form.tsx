import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { reached } from "../../model/danced";
import { chosenSegment, drawnFrom, hideDrawn, keyOfMaterial, showDrawn } from "../../model/drawn";
import { materials } from "../../model/material";
import { drawnEdits, liveCall, type Becomes, type Drawn } from "../../model/stage_edits";
import type { StageState, Stroke } from "../../model/stage_state";
import type { Studio } from "../../model/studio";

/** What a line can become. */
export const CHOICES: [Becomes, string][] = [["formation", "Formation"], ["way", "Way"], ["bend", "Bend a group to it"], ["path", "Lead along it"], ["flow", "Flow"], ["attract", "Gather on it"]];
const INSIDE = ["even", "grid", "diagonal", "concentric", "poisson"];
const KEEPS: Record<string, [Drawn["keep"], string][]> = {
  "left-right": [["left", "left half"], ["right", "right half"]], "front-back": [["back", "back half"], ["front", "front half"]],
};

/** Asks what becomes of a drawn line; the stage shows it meanwhile. */
export function StrokeForm({ studio, stage, stroke }: { studio: Studio; stage: StageState; stroke: Stroke }) {
  const form = useRef<HTMLFormElement>(null);
  const drawn = useSignal<Drawn>(drawnFrom(stage, stroke));
  const now = drawn.value;
  const set = (more: Partial<Drawn>): void => { drawn.value = { ...drawn.value, ...more }; };
  const isElement = !["formation", "way", "bend"].includes(now.becomes);
  const changesSegment = now.becomes === "bend" && Boolean(now.material?.segment);
  const close = (): void => {
    stage.stroke.value = null;
    hideDrawn(stage);
  };

  useEffect(() => form.current?.querySelector("input")?.focus(), []);
  useEffect(() => showDrawn(stage, now), [now]);

  const keep = async (): Promise<void> => {
    const edits = drawnEdits(studio.score.value, now);
    const { value: tool } = stage.tool;
    close();
    stage.tool.value = "select";
    if (!(await stage.send(edits))) {
      stage.tool.value = tool;
      stage.stroke.value = stroke; // it is not lost
      return;
    }
    if (isElement) await stage.play(reached(studio.score.value, now.start, now.measures));
  };

  return (
    <form
      ref={form}
      class="popover"
      aria-label="What becomes of the line"
      onSubmit={(event) => {
        event.preventDefault();
        void keep();
      }}
      onKeyDown={(event) => {
        if (event.key !== "Escape") return;
        event.stopPropagation();
        close();
      }}
    >
      <fieldset class="choice">
        <legend>It becomes</legend>
        {CHOICES.map(([becomes, words]) => (
          <label key={becomes} class="pick"><input type="radio" name="becomes" checked={now.becomes === becomes} onChange={() => { stage.becomes.value = becomes; set({ becomes }); }} /> {words}</label>
        ))}
      </fieldset>
      {now.becomes === "formation" && <FormationFields now={now} set={set} />}
      {now.becomes === "bend" && <BendField stage={stage} now={now} set={set} />}
      {now.becomes === "way" && (
        <label class="pick"><input type="checkbox" checked={now.singleFile} onChange={() => set({ singleFile: !now.singleFile })} /> one behind another</label>
      )}
      {isElement && <Number words="Strength" value={now.strength} least={0.1} step={0.1} set={(strength) => set({ strength })} />}
      {!changesSegment && (
        <>
          <label class="field">Who <input value={now.group === "*" ? "" : now.group} placeholder="everybody" maxLength={250} onChange={(event) => set({ group: event.currentTarget.value.trim() || "*" })} /></label>
          <div class="pair">
            <Number words="From measure" value={now.start + 1} least={1} step={1} set={(value) => set({ start: Math.round(value) - 1 })} />
            <Number words="for" value={now.measures} least={1} step={1} set={(measures) => set({ measures: Math.round(measures) })} />
          </div>
        </>
      )}
      <div class="buttons">
        <button class="primary">{stage.trying.value ? "Try it" : changesSegment ? "Bend it" : `Put it at measure ${now.start + 1}`}</button>
        {isElement && (
          <button
            type="button"
            onClick={() => {
              stage.call(...liveCall(now.becomes, now.points, now.strength, now.measures, now.group));
              close();
            }}
          >
            Now, live
          </button>
        )}
        <button type="button" onClick={close}>Cancel</button>
      </div>
    </form>
  );
}

/** Whose motion goes into a region, or along a line. */
function BendField({ stage, now, set }: { stage: StageState; now: Drawn; set: Setter }) {
  return <label class="field">{now.closed ? "Into it" : "Along it"} <BendSelect stage={stage} onChange={(material) => set({ material })} /></label>;
}

/** All that can be bent: the selected segment's motion, evolutions, formations, shapes. */
export function BendSelect({ stage, onChange }: { stage: StageState; onChange?: (material: Drawn["material"]) => void }) {
  const all = materials(stage.studio.score.value, chosenSegment(stage));
  const chosen = all.find((one) => keyOfMaterial(one) === stage.bent.value) ?? all[0];
  return (
    <select
      aria-label="What is bent" value={chosen ? keyOfMaterial(chosen) : ""}
      onChange={(event) => {
        stage.bent.value = event.currentTarget.value;
        onChange?.(all.find((one) => keyOfMaterial(one) === event.currentTarget.value) ?? null);
      }}
    >
      {all.map((one) => <option key={keyOfMaterial(one)} value={keyOfMaterial(one)}>{one.segment ? `${one.name}, selected` : one.list === "evolution" ? `${one.name} (ways)` : one.name}</option>)}
    </select>
  );
}

type Setter = (more: Partial<Drawn>) => void;

function FormationFields({ now, set }: { now: Drawn; set: Setter }) {
  return (
    <>
      <label class="field">Name <input value={now.name} maxLength={64} required onInput={(event) => set({ name: event.currentTarget.value })} /></label>
      {now.closed && (
        <fieldset class="choice">
          <legend>Dancers</legend>
          <label class="pick"><input type="radio" name="inside" checked={!now.inside} onChange={() => set({ inside: false, pattern: "", many: now.many === "density" ? "dancers" : now.many })} /> on the line</label>
          <label class="pick"><input type="radio" name="inside" checked={now.inside} onChange={() => set({ inside: true, pattern: "even" })} /> inside</label>
        </fieldset>
      )}
      {now.closed && now.inside && (
        <label class="field">
          Pattern
          <select value={now.pattern} onChange={(event) => set({ pattern: event.currentTarget.value })}>
            {INSIDE.map((one) => <option key={one} value={one}>{one === "poisson" ? "scattered" : one}</option>)}
          </select>
        </label>
      )}
      <label class="field">
        How many
        <select value={now.many} onChange={(event) => {
          const many = event.currentTarget.value as Drawn["many"];
          set({ many, amount: many === "count" ? 12 : 1 });
        }}>
          <option value="dancers">as many as there are</option>
          <option value="count">a number</option>
          {now.closed && now.inside && <option value="density">by density, per m²</option>}
          <option value="spacing">by spacing, in m</option>
        </select>
      </label>
      {now.many !== "dancers" && <Number words="" value={now.amount} least={now.many === "count" ? 1 : 0.1} step={now.many === "count" ? 1 : 0.1} set={(amount) => set({ amount })} />}
      <label class="field">
        Symmetry
        <select value={now.mirror} onChange={(event) => {
          const mirror = event.currentTarget.value as Drawn["mirror"];
          set({ mirror, keep: KEEPS[mirror]?.[0]?.[0] ?? "" });
        }}>
          <option value="">none</option>
          <option value="left-right">left and right</option>
          <option value="front-back">front and back</option>
        </select>
      </label>
      {now.mirror && (
        <label class="field">
          Reflect the
          <select value={now.keep} onChange={(event) => set({ keep: event.currentTarget.value as Drawn["keep"] })}>
            {(KEEPS[now.mirror] ?? []).map(([keep, words]) => <option key={keep} value={keep}>{words}</option>)}
          </select>
        </label>
      )}
    </>
  );
}

function Number({ words, value, least, step, set }: { words: string; value: number; least: number; step: number; set: (value: number) => void }) {
  return (
    <label class="field">
      {words || <span class="unseen">Amount</span>}
      <input type="number" min={least} step={step} value={value} onChange={(event) => set(Math.max(least, event.currentTarget.valueAsNumber || least))} />
    </label>
  );
}
