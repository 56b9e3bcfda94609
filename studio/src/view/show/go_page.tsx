import type { Studio } from "../../model/studio";
import { Projected } from "./projected";
import { entries, number, text, type Entry } from "../../model/score";

/** The cue list: what is on standby, what counts in, and GO. */
export function GoPage({ studio }: { studio: Studio }) {
  const { values, score } = studio;
  const cues = entries(score.value, "cue");
  const standby = String(values.of("/dance/status/cue").value?.[0] ?? "");
  const left = Number(values.of("/dance/status/count_in").value?.[0] ?? 0);
  const next = cues.find((cue) => text(cue, "name") === standby);
  const toggle = (address: string, words: string, tone = "") => {
    const on = Boolean(values.of(address).value?.[0]);
    return <button class={tone} role="switch" aria-checked={on} onClick={() => values.send(address, on ? 0 : 1)}>{words}</button>;
  };
  return (
    <div class="go-page">
      <section class="standby" aria-label="Standby">
        <p class="count" aria-live="off">{left > 0 ? left : ""}</p>
        <h2>{standby || (cues.length ? "The cue list has ended" : "This show has no cues")}</h2>
        <p>{next ? text(next, "text") : ""}</p>
        <button class="go huge" onClick={() => values.send("/dance/go")} disabled={!standby}>GO</button>
        <div class="tools">
          <button onClick={() => values.send("/dance/back")}>Back</button>
          {toggle("/dance/hold", "Hold")}
          {toggle("/dance/blackout", "Blackout")}
          <button class="stop" onClick={() => values.send("/dance/panic")}>Panic</button>
        </div>
        <Projected studio={studio} />
      </section>
      <section class="cue-list" aria-label="Cues">
        <h2>Cues</h2>
        <ol>
          {cues.map((cue, index) => {
            const name = text(cue, "name");
            return (
              <li key={index} aria-current={name === standby ? "true" : undefined}>
                <button class="plain" onClick={() => values.send("/dance/standby", name)} onDblClick={() => values.send("/dance/cue", name)} title="Click: on standby. Double click: now">
                  <b>{name}</b>
                  <span>{text(cue, "text") || does(cue)}</span>
                  <small>{when(cue)}</small>
                </button>
              </li>
            );
          })}
        </ol>
      </section>
      <section class="sections" aria-label="Sections">
        <h2>Sections</h2>
        {studio.spans.value.map((span) => (
          <button key={span.number} aria-pressed={studio.doc.clock.value?.section === span.name} onClick={() => values.send("/dance/section", span.name)}>
            {span.name} <small>{span.measures} measures</small>
          </button>
        ))}
        {studio.spans.value.length > 0 && <button onClick={() => values.send("/dance/advance")}>Leave the section at its end</button>}
      </section>
    </div>
  );
}

function does(cue: Entry): string {
  const parts = [text(cue, "scene") && `scene ${text(cue, "scene")}`, text(cue, "section") && `section ${text(cue, "section")}`];
  const calls = cue["calls"];
  if (Array.isArray(calls)) parts.push(...calls.map((call) => String((call as unknown[])[0]).replace("/dance/", "")));
  return parts.filter(Boolean).join(", ");
}

function when(cue: Entry): string {
  const words = { now: "at once", beat: "on the beat", measure: "on the measure", section: "when a section begins" } as Record<string, string>;
  const countIn = number(cue, "count_in", 0);
  const fade = cue["measures"];
  return [words[text(cue, "when", "measure")], countIn ? `count-in ${countIn}` : "", typeof fade === "number" ? `fade ${fade}` : "", text(cue, "then") === "auto" ? "goes on by itself" : ""].filter(Boolean).join(" · ");
}
