import { useSignal } from "@preact/signals";
import type { Studio } from "../../model/studio";
import { call, columns, launched, pads, stateOf, type Kind, type Launch, type Launched, type Pad } from "../../model/pads";
import { colourOf } from "../stage/paint";
import { StageView } from "../stage/stage_view";
import "./play.css";

const KINDS: [Kind, string][] = [["steps", "Steps"], ["formations", "Formations"], ["elements", "Elements"], ["looks", "Looks and cues"]];
const LENGTHS = [1, 2, 4, 8, 16];
const KEPT = 200;

/** A grid for improvising: columns are dancers, pads are what they can do; beside it the stage. */
export function PlayView({ studio }: { studio: Studio }) {
  const kind = useSignal<Kind>("steps");
  const launch = useSignal<Launch>("measure");
  const measures = useSignal(4);
  const past = useSignal<Launched[]>([]);
  const structure = studio.doc.structure.value;
  if (!structure) return <main class="play" />;
  const clock = studio.doc.clock.value;
  const measure = clock?.measure ?? 0;
  const left = clock ? Math.max(1, Math.ceil(studio.beats.value - clock.beat + 1)) : 0;
  const all = pads(structure, kind.value);
  const columnsNow = kind.value === "looks" ? columns(structure, []).slice(0, 1) : columns(structure, studio.dancers.value);
  const start = (pad: Pad, who: string): void => {
    studio.values.send(...call(pad, who, launch.value, measures.value));
    past.value = [...past.value, launched(pad, who, launch.value, measures.value, measure)].slice(-KEPT);
  };
  return (
    <main class="play">
      <section class="grid" aria-label="Pads">
        <header class="strip">
          <div class="choice" role="group" aria-label="What">
            {KINDS.map(([name, words]) => <button key={name} aria-pressed={kind.value === name} onClick={() => { kind.value = name; }}>{words}</button>)}
          </div>
          <div class="choice" role="group" aria-label="When">
            <button aria-pressed={launch.value === "now"} onClick={() => { launch.value = "now"; }}>Now</button>
            <button aria-pressed={launch.value === "measure"} onClick={() => { launch.value = "measure"; }}>Next measure</button>
          </div>
          <label class="field">
            For
            <select value={measures.value} onChange={(event) => { measures.value = Number(event.currentTarget.value); }}>
              {LENGTHS.map((one) => <option key={one} value={one}>{one === 1 ? "1 measure" : `${one} measures`}</option>)}
            </select>
          </label>
          <Keep studio={studio} />
        </header>
        <div class="pads" role="grid" aria-label={KINDS.find(([name]) => name === kind.value)?.[1]} onKeyDown={roam}>
          <div role="row" class="row">
            {columnsNow.map((column) => (
              <div key={column.who} role="columnheader" class="head">
                {column.group >= 0 && <i style={{ background: colourOf(structure.groups[column.group]) }} />}
                <span>{column.label}</span>
                {kind.value !== "looks" && <button class="plain" title="They leave their formation; elements alone move them" onClick={() => studio.values.send("/dance/release", column.who)}>Release</button>}
              </div>
            ))}
          </div>
          {all.map((pad, row) => (
            <div key={`${pad.words} ${pad.name}`} role="row" class="row">
              {columnsNow.map((column, index) => {
                const state = stateOf(pad, column.who, past.value, measure);
                return (
                  <div key={column.who} role="gridcell">
                    <button
                      class={`pad ${state}`} tabIndex={row === 0 && index === 0 ? 0 : -1}
                      style={{ "--box": column.group >= 0 ? colourOf(structure.groups[column.group]) : "var(--accent)" }}
                      aria-label={`${pad.name}, ${column.label}${state === "idle" ? "" : state === "waits" ? `, in ${left} beats` : ", runs"}`}
                      onClick={() => start(pad, column.who)}
                    >
                      <b>{pad.name}</b>
                      <small>{state === "waits" ? left : pad.words}</small>
                    </button>
                  </div>
                );
              })}
            </div>
          ))}
          {!all.length && <p class="hint">This show has no scenes and no cues yet.</p>}
        </div>
        <footer class="strip">
          <button onClick={() => studio.values.send("/dance/undo")}>Undo what was launched</button>
          <button onClick={() => { studio.values.send("/dance/clear"); past.value = []; }}>Clear: back to the score</button>
          <span class="hint" role="status">{studio.values.refused.value}</span>
        </footer>
      </section>
      <StageView studio={studio} />
    </main>
  );
}

/** Arrow keys go from pad to pad. */
function roam(event: KeyboardEvent): void {
  const step = { ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowUp: [-1, 0], ArrowDown: [1, 0] }[event.key];
  const here = (event.target as HTMLElement).closest(".pad");
  if (!step || !here) return;
  event.preventDefault();
  event.stopPropagation();
  const rows = [...(event.currentTarget as HTMLElement).querySelectorAll(".row")].map((row) => [...row.querySelectorAll<HTMLElement>(".pad")]).filter((row) => row.length);
  const row = rows.findIndex((one) => one.includes(here as HTMLElement));
  const column = rows[row]?.indexOf(here as HTMLElement) ?? 0;
  rows[row + (step[0] ?? 0)]?.[column + (step[1] ?? 0)]?.focus();
}

/** The last measures become a section of the score. */
function Keep({ studio }: { studio: Studio }) {
  const measures = useSignal(16);
  return (
    <form
      class="keep"
      onSubmit={(event) => {
        event.preventDefault();
        const name = `take ${new Date().toTimeString().slice(0, 5).replace(":", ".")}`;
        studio.values.send("/dance/document/keep/measures", measures.value, name, studio.by);
        studio.doc.tell("told", `The last ${measures.value} measures become the section "${name}"`);
      }}
    >
      <label class="field">
        Keep the last
        <input type="number" min={1} max={1000} value={measures.value} onInput={(event) => { measures.value = Number(event.currentTarget.value); }} />
        measures
      </label>
      <button>Keep</button>
    </form>
  );
}
