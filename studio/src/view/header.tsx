import { Dialog } from "../ui/dialog";
import { KEY_PAGES } from "../ui/keys";
import type { Clock } from "../model/document";
import { personColour, type Studio, type View } from "../model/studio";

/** From this share on the other measure line is shown, as on the overlay. */
const SHOWN_SHARE = 0.3;
const VIEWS: [View, string][] = [["make", "Make"], ["play", "Play"], ["show", "Show"], ["storyboard", "Storyboard"]];

export function Header({ studio }: { studio: Studio }) {
  const { doc } = studio;
  const clock = doc.clock.value;
  const state = doc.link.state.value;
  return (
    <>
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
        {clock && (clock.asks || clock.runner_up[1] >= SHOWN_SHARE) && <OtherLine clock={clock} take={() => studio.values.send("/dance/clock/take")} />}
      </div>
      <div class="tools">
        <button onClick={() => void doc.undo()} title="Undo (Ctrl+Z)">Undo</button>
        <button onClick={() => void doc.redo()} title="Redo (Ctrl+Shift+Z)">Redo</button>
        <button class="go" onClick={() => studio.values.send("/dance/go")} title="The next cue (G)">GO</button>
        <button class="help" aria-label="Keys" title="What the keys do (?)" onClick={() => { studio.helping.value = true; }}>?</button>
      </div>
      <ul class="people" aria-label="Who is here">
        {doc.people.value.map((person, index) => (
          <li key={index} title={person.name} style={{ boxShadow: `inset 0 0 0 2px var(${personColour(person.name)})` }}>{initials(person.name)}</li>
        ))}
      </ul>
      {state !== "open" && <p class="link" role="status">{state === "connecting" ? "Connecting …" : "No connection: trying again"}</p>}
    </header>
    {studio.helping.value && <Keys onClose={() => { studio.helping.value = false; }} />}
    </>
  );
}

/** The measure line that the music suggests beside the one that is danced; one press takes it. */
function OtherLine({ clock, take }: { clock: Clock; take: () => void }) {
  const [later, share] = clock.runner_up;
  const words = `${clock.asks ? "Is the one" : "or the one"} ${later} ${later === 1 ? "beat" : "beats"} later${clock.asks ? "?" : ""} ${Math.round(100 * share)} %`;
  return <button class={clock.asks ? "asks" : ""} title="Move the measure line there (-)" onClick={take}>{words}</button>;
}

function Keys({ onClose }: { onClose: () => void }) {
  return (
    <Dialog title="Keys" wide onClose={onClose}>
      <div class="body keys" tabIndex={0} role="group" aria-label="What the keys do">
        {KEY_PAGES.map(([title, keys]) => (
          <section key={title} aria-label={title}>
            <h3>{title}</h3>
            <dl>{keys.map((one) => [<dt key={`k ${one.keys}`}>{inWords(one.keys)}</dt>, <dd key={`w ${one.keys}`}>{one.words}</dd>])}</dl>
          </section>
        ))}
      </div>
    </Dialog>
  );
}

function inWords(keys: string): string {
  return keys.replace("ArrowLeft", "←").replace("ArrowRight", "→").replace("ArrowUp", "↑").replace("ArrowDown", "↓").replace("PageUp", "Page up").replace("PageDown", "Page down").replaceAll("+", " + ").replace(/^ \+ $/, "+");
}

function initials(name: string): string {
  return name.split(/\s+/).map((part) => part[0] ?? "").join("").slice(0, 2).toUpperCase() || "?";
}
