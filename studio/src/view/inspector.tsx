import type { Selected, Studio } from "../model/studio";
import type { Entry } from "../model/score";

/** The selected entry, key by key. */
export function Inspector({ studio }: { studio: Studio }) {
  const chosen = studio.selected.value;
  const one = chosen.length === 1 ? chosen[0] : undefined;
  const entry = one && studio.entry(one);
  return (
    <section class="inspector" aria-label="Inspector">
      <header class="strip"><h2>{one ? title(one) : "Inspector"}</h2></header>
      {one && entry ? <Fields studio={studio} one={one} entry={entry} /> : <p class="hint">{chosen.length ? `${chosen.length} entries are selected.` : "Select a box of the timeline."}</p>}
      <Doubts studio={studio} />
    </section>
  );
}

function title(one: Selected): string {
  return { segment: "Formation or way", sequence: "Steps", at: "Call", element: "Element", improvise: "Improvisation", section: "Section", signal: "Signal" }[one.list] ?? one.list;
}

function Fields({ studio, one, entry }: { studio: Studio; one: Selected; entry: Entry }) {
  return (
    <div class="fields">
      {Object.entries(entry).map(([key, value]) => (
        <label key={key} class="field">
          {key.replaceAll("_", " ")}
          <input
            value={typeof value === "string" ? value : JSON.stringify(value)}
            onChange={(event) => {
              const said = event.currentTarget.value;
              void studio.doc.edit({ do: "set", at: [one.list, one.number, key], value: typeof value === "string" ? said : parsed(said) });
            }}
          />
        </label>
      ))}
      <button onClick={() => void studio.removeSelected()}>Delete</button>
    </div>
  );
}

function parsed(said: string): unknown {
  try {
    return JSON.parse(said);
  } catch {
    return said;
  }
}

function Doubts({ studio }: { studio: Studio }) {
  const doubts = studio.doc.doubts.value;
  if (!doubts.length) return null;
  return (
    <details class="doubts">
      <summary>{doubts.length} {doubts.length === 1 ? "doubt" : "doubts"} about this show</summary>
      <ul>
        {doubts.slice(0, 60).map((doubt, index) => <li key={index}>{doubt.what}</li>)}
      </ul>
    </details>
  );
}
