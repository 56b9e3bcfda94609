import { personColour, type Studio, type View } from "../model/studio";

const VIEWS: [View, string][] = [["make", "Make"], ["play", "Play"], ["show", "Show"], ["storyboard", "Storyboard"]];

export function Header({ studio }: { studio: Studio }) {
  const { doc } = studio;
  const clock = doc.clock.value;
  const state = doc.link.state.value;
  return (
    <header class="bar">
      <h1 title={String(studio.score.value["name"] ?? "")}>{String(studio.score.value["name"] ?? "…")}</h1>
      <nav class="tabs" aria-label="Views">
        {VIEWS.map(([view, words]) => (
          <button key={view} aria-current={studio.view.value === view ? "page" : undefined} onClick={() => { studio.view.value = view; }}>
            {words}
          </button>
        ))}
      </nav>
      <div class="now" role="status" aria-live="off" aria-label="Now">
        <b>{clock && clock.measure > 0 ? `${clock.score_measure}.${Math.max(1, Math.floor(clock.beat))}` : "–"}</b>
        <span>{clock ? `${clock.bpm.toFixed(1)} bpm` : ""}</span>
        <span>{clock?.section ?? ""}</span>
      </div>
      <div class="tools">
        <button onClick={() => void doc.undo()} title="Undo (Ctrl+Z)">Undo</button>
        <button onClick={() => void doc.redo()} title="Redo (Ctrl+Shift+Z)">Redo</button>
        <button class="go" onClick={() => studio.values.send("/dance/go")} title="The next cue (G)">GO</button>
      </div>
      <ul class="people" aria-label="Who is here">
        {doc.people.value.map((person, index) => (
          <li key={index} title={person.name} style={{ boxShadow: `inset 0 0 0 2px var(${personColour(person.name)})` }}>{initials(person.name)}</li>
        ))}
      </ul>
      {state !== "open" && <p class="link" role="status">{state === "connecting" ? "Connecting …" : "No connection: trying again"}</p>}
    </header>
  );
}

function initials(name: string): string {
  return name.split(/\s+/).map((part) => part[0] ?? "").join("").slice(0, 2).toUpperCase() || "?";
}
