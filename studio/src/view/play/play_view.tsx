import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import {
  columns, FOLLOWS, launchCall, launchOf, WHENS, awayInWords, measuresAway, measureOf, shareOf, countOf, dancedBeats, launchInWords, type Column, type Follow, type Pad, type Page, type When,
} from "../../model/pads";
import type { Studio } from "../../model/studio";
import { colourOf } from "../stage/paint";
import { StageView } from "../stage/stage_view";
import { CountIn } from "./count_in";
import { KeepPad, OwnSettings } from "./own_pads";
import { PadPicture } from "./pad_picture";
import { WhatNext } from "./what_next";
import "./play.css";

const PAGES: [Page, string, string][] = [
  ["own", "Mine", "Keep a pad of another page by its star: it gets a length and a follow action of its own."],
  ["step", "Steps", "This show has no steps yet."],
  ["phrase", "Phrases", "This show has no sequences yet: put some into the timeline, and give them names."],
  ["formation", "Formations", "This show has no formations yet."],
  ["element", "Elements", ""],
  ["look", "Looks and cues", "This show has no scenes and no cues yet."],
];
const LENGTHS = [1, 2, 4, 8, 16];

/** A grid for improvising: columns are dancers, pads are what they can do; beside it the stage. */
export function PlayView({ studio }: { studio: Studio }) {
  const page = useSignal<Page>("step");
  const when = useSignal<When>("measure");
  const measures = useSignal(4);
  const follow = useSignal<Follow>("stop");
  const structure = studio.doc.structure.value;
  const begun = useRef(false);
  const lists = studio.doc.pads.value;
  useEffect(() => {
    // who has kept pads begins with them
    if (lists && !begun.current && lists.own.length) page.value = "own";
    begun.current ||= lists !== null;
  }, [lists]);
  if (!structure) return <main class="play" />;
  const all = lists?.[page.value] ?? [];
  const columnsNow = page.value === "look" ? columns(structure, []).slice(0, 1) : columns(structure, studio.dancers.value);
  const start = (pad: Pad, who: string): void => studio.values.send(...launchCall(pad, who, when.value, measures.value, follow.value));
  const [, title, empty] = PAGES.find(([name]) => name === page.value) ?? PAGES[1]!;
  return (
    <main class="play">
      <section class="grid" aria-label="Pads">
        <header class="strip">
          <div class="choice" role="group" aria-label="What">
            {PAGES.map(([name, words]) => <button key={name} aria-pressed={page.value === name} onClick={() => { page.value = name; }}>{words}</button>)}
          </div>
        </header>
        <div class="strip how">
          <div class="choice" role="group" aria-label="When">
            {WHENS.map(([name, words, more]) => <button key={name} aria-pressed={when.value === name} title={more} onClick={() => { when.value = name; }}>{words}</button>)}
          </div>
          {page.value === "own" ? <span class="hint">For and then: as each pad says</span> : (
            <>
              <label class="field">
                For
                <select value={measures.value} aria-label="For how many measures" onChange={(event) => { measures.value = Number(event.currentTarget.value); }}>
                  {LENGTHS.map((one) => <option key={one} value={one}>{one === 1 ? "1 measure" : `${one} measures`}</option>)}
                </select>
              </label>
              <label class="field">
                then
                <select value={follow.value} aria-label="What follows" onChange={(event) => { follow.value = event.currentTarget.value as Follow; }}>
                  {FOLLOWS.map(([name, words]) => <option key={name} value={name}>{words}</option>)}
                </select>
              </label>
            </>
          )}
        </div>
        <div class="pads" role="grid" aria-label={title} onKeyDown={roam}>
          <div role="row" class="row heads">
            {columnsNow.map((column) => <Head key={column.who} studio={studio} column={column} releases={page.value === "formation" || page.value === "element"} />)}
          </div>
          {all.map((pad, row) => (
            <div key={pad.pad} role="row" class="row">
              {columnsNow.map((column, index) => (
                <div key={column.who} role="gridcell">
                  <PadButton studio={studio} pad={pad} column={column} first={row === 0 && index === 0} onLaunch={() => start(pad, column.who)} />
                  {index === 0 && (page.value === "own"
                    ? <OwnSettings studio={studio} number={row + 1} pad={pad} />
                    : <KeepPad studio={studio} pad={pad} measures={measures.value} follow={follow.value} />)}
                </div>
              ))}
            </div>
          ))}
          {lists && !all.length && <p class="hint">{empty}</p>}
        </div>
        <WhatNext studio={studio} when={when.value} />
        <footer class="strip">
          <button onClick={() => studio.values.send("/dance/undo")}>Undo what was launched</button>
          <button title="Everything ends, also what was put by hand" onClick={() => studio.values.send("/dance/clear")}>Clear</button>
          <Refused studio={studio} />
          <Keep studio={studio} />
        </footer>
      </section>
      <div class="seen">
        <StageView studio={studio} />
        <CountIn studio={studio} />
      </div>
    </main>
  );
}

/** The dancers of a column, and what stops them. */
function Head({ studio, column, releases }: { studio: Studio; column: Column; releases: boolean }) {
  const folded = column.who.toLowerCase();
  const busy = studio.doc.launches.value.launches.some((one) => one.state !== "refused" && (column.who === "*" || one.who.toLowerCase() === folded));
  return (
    <div role="columnheader" class="head">
      {column.group >= 0 && <i style={{ background: colourOf(studio.doc.structure.value?.groups[column.group]) }} />}
      <span title={column.label}>{column.label}</span>
      {releases && <button class="plain" title="They leave their formation; elements alone move them" onClick={() => studio.values.send("/dance/release", column.who)}>Release</button>}
      <button class="stop" disabled={!busy} aria-label={column.who === "*" ? "Stop all" : `Stop ${column.label}`} title={column.who === "*" ? "Stop all that was launched: back to the score" : `Stop what was launched for ${column.label}: back to the score`} onClick={() => studio.values.send("/dance/launch/stop", column.who)}>
        {column.who === "*" ? "■ all" : "■"}
      </button>
    </div>
  );
}

function PadButton({ studio, pad, column, first, onLaunch }: { studio: Studio; pad: Pad; column: Column; first: boolean; onLaunch: () => void }) {
  const told = studio.doc.launches.value;
  const launch = launchOf(told, pad, column.who);
  const clock = launch ? studio.doc.clock.value : null;
  const danced = clock ? dancedBeats(clock, told.beats) : 0;
  const away = measuresAway(told, pad, column.who);
  const state = launch?.state ?? "idle";
  const count = launch?.state === "waits" ? countOf(launch, danced) : null;
  const doing = state === "waits" ? (count === null ? "waits" : `in ${count} ${count === 1 ? "beat" : "beats"}`) : state === "runs" ? "runs" : state === "refused" ? "refused" : "";
  const reason = state === "refused" ? launch?.why : away ? awayInWords(away) : undefined;
  const wide = column.who === "*";
  return (
    <button
      class={`pad ${state} ${away && state === "idle" ? "away" : ""} ${wide ? "wide" : ""}`} tabIndex={first ? 0 : -1} title={reason}
      style={{ "--box": column.group >= 0 ? colourOf(studio.doc.structure.value?.groups[column.group]) : "var(--accent)", "--share": launch?.state === "runs" ? shareOf(launch, danced) : 0 }}
      onClick={onLaunch}
    >
      {wide && <span class="thumb"><PadPicture studio={studio} pad={pad} /></span>}
      <span class="words">
        <b>{pad.name}</b>
        <small aria-hidden="true">{state === "runs" && launch ? `▶ ${measureOf(launch, danced, told.beats)} ${followMark(launch.follow)}` : state === "refused" ? "refused" : away ? (away < 0 ? "no way" : `+${away} ${away === 1 ? "measure" : "measures"}`) : wide ? pad.words : ""}</small>
      </span>
      <span class="unseen">{[column.label, doing, away && state === "idle" ? "cannot follow at once" : ""].filter(Boolean).join(", ")}</span>
      {state === "waits" && <span class="count" aria-hidden="true">{count ?? "…"}</span>}
    </button>
  );
}

function followMark(follow: Follow | undefined): string {
  return follow && follow !== "stop" ? (FOLLOWS.find(([name]) => name === follow)?.[2] ?? "") : "";
}

/** Why the last launch was refused. */
function Refused({ studio }: { studio: Studio }) {
  const late = studio.doc.launches.value.launches.find((one) => one.state === "refused");
  const words = late ? `${launchInWords(late)}: ${late.why ?? "refused"}` : studio.values.refused.value;
  return <span class="hint refusal" role="status" title={words}>{words}</span>;
}

/** Arrow keys go from pad to pad; 1 to 9 launch the first pads of the column. */
function roam(event: KeyboardEvent): void {
  const step = { ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowUp: [-1, 0], ArrowDown: [1, 0] }[event.key];
  const number = /^[1-9]$/.test(event.key) && !event.repeat ? Number(event.key) : 0;
  const here = (event.target as HTMLElement).closest(".pad");
  if ((!step && !number) || !here) return;
  event.preventDefault();
  event.stopPropagation();
  const rows = [...(event.currentTarget as HTMLElement).querySelectorAll(".row")].map((row) => [...row.querySelectorAll<HTMLElement>(".pad")]).filter((row) => row.length);
  const row = rows.findIndex((one) => one.includes(here as HTMLElement));
  const column = rows[row]?.indexOf(here as HTMLElement) ?? 0;
  if (!step) rows[number - 1]?.[column]?.click();
  else rows[row + (step[0] ?? 0)]?.[column + (step[1] ?? 0)]?.focus();
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
