import { useSignal } from "@preact/signals";
import type { Studio } from "../../model/studio";
import { entries, text, type Entry } from "../../model/score";
import { common, fieldEdits, fieldsOf, hexOf, isRenamed, type Field } from "../../model/form";
import { CallField, Reactions } from "./calls";
import { FieldControl, scrub, type Scrubbed } from "./controls";
import { NextFormations } from "./next_formations";
import "./inspector.css";

const TITLES: Record<string, [string, string]> = {
  segment: ["Formation or way", "formations or ways"], sequence: ["Steps", "sequences of steps"], at: ["Call", "calls"], element: ["Element", "elements"],
  improvise: ["Improvisation", "improvisations"], section: ["Section", "sections"], signal: ["Signal", "signals"], curve: ["Curve", "curves"],
  regroup: ["New group", "changes of group"], cue: ["Cue", "cues"], group: ["Group", "groups"], gate: ["Gate", "gates"], obstacle: ["Obstacle", "obstacles"],
  item: ["Item", "items"], formation: ["Formation", "formations"], scene: ["Scene", "scenes"], view: ["Camera", "cameras"],
};

/** Controls that take the whole width. */
const WIDE = ["steps", "colour"];

/** What is selected, as a form; the show itself if nothing is. */
export function Inspector({ studio }: { studio: Studio }) {
  const chosen = studio.selected.value.filter((one) => studio.entry(one));
  const kinds = [...new Set(chosen.map((one) => one.list))];
  const [kind] = kinds;
  const [one, many] = TITLES[kind ?? ""] ?? ["Entry", "entries"];
  const title = !chosen.length ? "Show" : kinds.length > 1 ? `${chosen.length} selected` : chosen.length === 1 ? one : `${chosen.length} ${many}`;
  return (
    <section class="inspector" aria-label="Inspector">
      <header class="strip">
        <h2>{title}</h2>
        {chosen.length > 0 && <button class="quiet" onClick={() => void studio.removeSelected()}>Delete</button>}
      </header>
      <div class="fields">
        {!chosen.length && <ShowForm studio={studio} />}
        {kinds.length === 1 && kind && <Form key={`${kind} ${chosen.map((each) => each.number).join()}`} studio={studio} kind={kind} numbers={chosen.map((each) => each.number)} all={chosen.map((each) => studio.entry(each) as Entry)} />}
        {kinds.length > 1 && <p class="hint">They are of several kinds: move, copy or delete them together. Select those of one kind to change what they hold.</p>}
      </div>
      <Doubts studio={studio} />
    </section>
  );
}

/** Keys that only some kinds of element have. */
const FOR_KINDS: Record<string, string[]> = { to: ["cross"], flow: ["flow"], whom: [] };

function isForOther(key: string, all: Entry[]): boolean {
  const kinds = FOR_KINDS[key];
  return kinds !== undefined && all.every((one) => one[key] === undefined && !kinds.includes(text(one, "kind")));
}

/** The form of entries of one kind. */
function Form({ studio, kind, numbers, all }: { studio: Studio; kind: string; numbers: number[]; all: Entry[] }) {
  const fields = [...new Map(all.flatMap((entry) => fieldsOf(kind, entry)).map((field) => [field.key, field])).values()].filter((field) => numbers.length === 1 || !isRenamed(kind, field.key));
  const calls = kind === "at" && all.length === 1 && all[0]?.["signal"] === undefined && all[0]?.["scene"] === undefined;
  const isFolded = (field: Field): boolean => field.folded === true || (kind === "element" && isForOther(field.key, all)) || (calls && ["call", "values", "signal", "scene"].includes(field.key));
  const folded = fields.filter(isFolded);
  const row = (field: Field) => (
    <Row key={field.key} studio={studio} field={field} all={all} kind={kind} onValue={(value) => void studio.doc.edits(fieldEdits(kind, numbers, field.key, value))} />
  );
  return (
    <>
      {calls && <CallField studio={studio} entry={all[0] ?? {}} words="What is called" onCall={(call, values) => void studio.doc.edit({ do: "change", at: [kind, numbers[0] ?? 1], value: { call, values } })} />}
      {fields.filter((field) => !isFolded(field)).map(row)}
      {folded.length > 0 && (
        <details class="more" open={folded.some((field) => field.folded && common(all, field.key).written && field.key !== "section")}>
          <summary>More</summary>
          {folded.map(row)}
        </details>
      )}
      {kind === "element" && all.length === 1 && <NextFormations studio={studio} number={numbers[0] ?? 1} />}
      {kind === "signal" && all.length === 1 && <Reactions studio={studio} name={text(all[0] ?? {}, "name")} />}
    </>
  );
}

function Row({ studio, kind, field, all, onValue }: { studio: Studio; kind: string; field: Field; all: Entry[]; onValue: (value: unknown) => void }) {
  const { value, same, written } = common(all, field.key);
  const renaming = useSignal(false);
  const id = `field-${kind}-${field.key}`;
  const isName = isRenamed(kind, field.key);
  const held = useSignal<Scrubbed | null>(null);
  const scrubbed = same && (field.control === "number" || field.control === "integer") ? scrub(field, value, held, onValue) : null;
  return (
    <div class={`formrow${written ? "" : " unwritten"}${WIDE.includes(field.control) ? " wide" : ""}`} title={field.help}>
      <label for={id} id={`${id}-words`} class={scrubbed ? "scrub" : undefined} {...scrubbed}>{field.words}</label>
      <div class="fieldbox">
        {isName && !renaming.value ? (
          <button id={id} class="value" aria-label={`Rename ${String(value ?? "")}`} title="Rename: it is renamed wherever it is named" onClick={() => { renaming.value = true; }}>{String(value ?? "")}</button>
        ) : (
          <FieldControl
            studio={studio}
            id={id}
            field={field}
            value={held.value?.value ?? (same ? value : undefined)}
            several={!same}
            focus={renaming.value}
            onValue={(next) => {
              renaming.value = false;
              if (JSON.stringify(next) !== JSON.stringify(value) || !same) onValue(next);
            }}
          />
        )}
        {field.unit && <span class="unit">{field.unit}</span>}
        {written && !field.required && field.key !== "name" && <button class="plain reset" aria-label={`${field.words}: as if it were not given`} title={field.default === undefined ? "Remove it" : `Back to ${JSON.stringify(field.default)}`} onClick={() => onValue(undefined)}>×</button>}
      </div>
    </div>
  );
}

/** The show: its name, stage, clock and music; and its groups, each of which has a form of its own. */
function ShowForm({ studio }: { studio: Studio }) {
  const score = studio.score.value;
  const part = (kind: string): Entry => (kind ? ((score[kind] as Entry | undefined) ?? {}) : score);
  const row = (kind: string) => (field: Field) => (
    <Row
      key={`${kind}.${field.key}`}
      studio={studio}
      kind={kind || "show"}
      field={field}
      all={[part(kind)]}
      onValue={(value) => void studio.doc.edit({ do: "set", at: kind ? [kind, field.key] : [field.key], value: value ?? null })}
    />
  );
  const rows = (kind: string) => fieldsOf(kind, {}).map(row(kind));
  return (
    <>
      {rows("")}
      <h3>Groups</h3>
      <ul class="chooser">
        {entries(score, "group").map((group, index) => (
          <li key={index}>
            <button onClick={() => studio.select({ list: "group", number: index + 1 })}>
              <i style={{ background: hexOf(group["colour"]) }} />
              <span>{text(group, "name")}</span>
              <small>{String(group["dancers"] ?? "")}</small>
            </button>
          </li>
        ))}
      </ul>
      <h3>Stage</h3>
      {rows("stage")}
      <h3>Music</h3>
      {rows("music")}
      <h3>Clock</h3>
      {rows("clock")}
    </>
  );
}

function Doubts({ studio }: { studio: Studio }) {
  const doubts = studio.doc.doubts.value;
  if (!doubts.length) return null;
  return (
    <details class="doubts">
      <summary>{doubts.length} {doubts.length === 1 ? "doubt" : "doubts"} about this show</summary>
      <ul>
        {doubts.slice(0, 60).map((doubt, index) => (
          <li key={index}>
            {doubt.measure === null ? doubt.what : <button class="plain" onClick={() => { studio.cursor.value = (doubt.measure ?? 1) - 1; }}>{doubt.what}</button>}
          </li>
        ))}
      </ul>
    </details>
  );
}
