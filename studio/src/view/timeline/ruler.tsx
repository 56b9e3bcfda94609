import { firstSectionEdits, freeName, phraseEdit, phrases } from "../../model/arrange";
import type { SectionSpan } from "../../model/plan";
import type { Studio } from "../../model/studio";
import type { TimelineState } from "./state";
import { Wave } from "./wave";

const NUMBER_PX = 40;
const BEAT_PX = 26;

/** Sections, phrases, numbers of measures and beats, and the music below them. Drag the numbers to choose measures. */
export function Ruler({ studio, state }: { studio: Studio; state: TimelineState }) {
  return (
    <div class="ruler">
      <div class="name"><span>Measures</span></div>
      <div class="lane">
        <Numbers studio={studio} state={state} />
        {studio.spans.value.map((span) => <SectionBlock key={span.number} studio={studio} state={state} span={span} />)}
        <Range studio={studio} />
        <PhraseName studio={studio} state={state} />
      </div>
      <Wave studio={studio} state={state} />
    </div>
  );
}

function Numbers({ studio, state }: { studio: Studio; state: TimelineState }) {
  const scale = studio.scale.value;
  const { left, width } = state.seen.value;
  const every = [1, 2, 4, 8, 16, 32, 64].find((count) => count * scale >= NUMBER_PX) ?? 128;
  const first = Math.max(0, Math.floor((left - 0.5 * width) / scale / every));
  const last = Math.min(Math.ceil(studio.length.value / every), Math.ceil((left + 1.5 * width) / scale / every));
  const numbers = Array.from({ length: Math.max(0, last - first) }, (_, index) => (first + index) * every);
  const { value: beats } = studio.beats;
  const showBeats = scale / beats >= BEAT_PX;
  const eights = phrases(studio.score.value, studio.length.value).filter((one) => (one.start + one.measures) * scale >= left - width && one.start * scale <= left + 2 * width);
  return (
    <>
      {eights.map((one) => <i key={`p${one.start}`} class="phrase" title={`${one.name || "phrase"}: a double click, or P at the cursor, names the phrase that begins here; without a name it is taken away`} style={{ "--start": one.start, "--length": one.measures }}>{one.name}</i>)}
      {numbers.map((measure) => <i key={measure} class="measure" style={{ "--start": measure }}>{measure + 1}</i>)}
      {showBeats && numbers.flatMap((measure) =>
        Array.from({ length: beats - 1 }, (_, beat) => <i key={`${measure}.${beat}`} class="beat" style={{ "--start": measure + (beat + 1) / beats }}>{beat + 2}</i>))}
    </>
  );
}

function SectionBlock({ studio, state, span }: { studio: Studio; state: TimelineState; span: SectionSpan }) {
  const gesture = state.gesture.value;
  const held = gesture?.kind === "section" && gesture.number === span.number ? gesture : null;
  const other = studio.lookedAt.value.get(`section ${span.number}`);
  const style = { "--start": held ? held.start : span.first, "--length": held ? held.measures : span.measures, ...(other ? { "--other": `var(${other.colour})` } : {}) };
  if (state.naming.value === span.number) {
    const done = (value: string): void => {
      state.naming.value = null;
      if (value.trim() && value !== span.name) void studio.doc.edit({ do: "rename", at: ["section", span.number], value: value.trim() });
    };
    return (
      <input
        class="section"
        style={style}
        aria-label={`New name of ${span.name}`}
        value={span.name}
        ref={(field) => field?.focus()}
        onBlur={(event) => done(event.currentTarget.value)}
        onKeyDown={(event) => {
          if (event.key === "Enter") event.currentTarget.blur();
          else if (event.key === "Escape") state.naming.value = null;
          event.stopPropagation();
        }}
      />
    );
  }
  const more = [span.repeat > 1 ? `×${span.repeat}` : "", span.wait || span.repeat === 0 ? "waits" : "", span.then ? `→ ${span.then}` : ""].filter(Boolean).join(" · ");
  return (
    <button
      class={`section${other ? " other" : ""}${held ? " held" : ""}${span.wait ? " waits" : ""}`}
      aria-pressed={studio.isSelected({ list: "section", number: span.number })}
      aria-label={`Section ${span.name}, measures ${span.first + 1} to ${span.first + span.measures}${more ? `, ${more}` : ""}`}
      title={`${span.name}: drag it to its place, its end to make it longer; F2 or a double click renames it`}
      style={style}
      data-section={span.number}
      onKeyDown={(event) => {
        const sign = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
        if (event.key === "F2") state.naming.value = span.number;
        else if (event.shiftKey && sign) studio.doc.inTurn(() => resizeSection(studio, span.number, sign));
        else if (event.altKey && sign) studio.doc.inTurn(() => moveSection(studio, span.number, sign));
        else return;
        event.preventDefault();
        event.stopPropagation();
      }}
      onClick={(event) => { if (event.detail === 0) studio.select({ list: "section", number: span.number }); }}
    >
      <span>{span.name}{more ? <small> {more}</small> : null}</span>
    </button>
  );
}

/** The name of a phrase that is being written. */
function PhraseName({ studio, state }: { studio: Studio; state: TimelineState }) {
  const start = state.phrase.value;
  if (start === null) return null;
  const known = phrases(studio.score.value, studio.length.value).find((one) => one.number && one.start === start);
  const done = (name: string): void => {
    if (state.phrase.peek() === null) return; // by Escape
    state.phrase.value = null;
    const edit = phraseEdit(studio.score.peek(), start, name.trim());
    if (edit) void studio.doc.edit(edit);
  };
  return (
    <input
      class="phrase"
      style={{ "--start": start }}
      aria-label={`Name of the phrase that begins in measure ${start + 1}`}
      value={known?.name ?? ""}
      maxLength={64}
      ref={(field) => field?.focus()}
      onBlur={(event) => done(event.currentTarget.value)}
      onKeyDown={(event) => {
        if (event.key === "Enter") event.currentTarget.blur();
        else if (event.key === "Escape") state.phrase.value = null;
        event.stopPropagation();
      }}
    />
  );
}

function resizeSection(studio: Studio, number: number, by: number): void {
  const measures = (studio.spans.peek()[number - 1]?.measures ?? 0) + by;
  if (measures >= 1) void studio.doc.edit({ do: "resize", at: ["section", number], value: measures });
}

function moveSection(studio: Studio, number: number, by: number): void {
  const to = number + by;
  if (to >= 1 && to <= studio.spans.peek().length) void studio.doc.edit({ do: "move", at: ["section", number], value: { number: to } });
}

function Range({ studio }: { studio: Studio }) {
  const range = studio.range.value;
  if (!range) return null;
  return <i class="extent" style={{ "--start": range[0], "--length": range[1] - range[0] }} />;
}

/** Add a section behind the selected one, or at the end; the first one takes the whole score. */
export async function addSection(studio: Studio): Promise<void> {
  const score = studio.score.peek();
  const spans = studio.spans.peek();
  const name = freeName(score, "section", "part");
  if (!spans.length) {
    await studio.doc.edits(firstSectionEdits(score, name, studio.length.peek()));
    return;
  }
  const chosen = studio.selected.peek().find((one) => one.list === "section");
  const number = chosen ? chosen.number + 1 : spans.length + 1;
  const answer = await studio.doc.edit({ do: "insert", at: number > spans.length ? ["section"] : ["section", number], value: { name, measures: 8 } });
  if (!answer.refused) studio.select({ list: "section", number });
}
