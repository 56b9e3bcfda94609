import { FOLLOWS, freePadName, type Follow, type Pad } from "../../model/pads";
import { entries, text } from "../../model/score";
import type { Studio } from "../../model/studio";

/** Keeps a pad in the show's file, with the length and the follow action that are chosen now. */
export function KeepPad({ studio, pad, measures, follow }: { studio: Studio; pad: Pad; measures: number; follow: Follow }) {
  const kept = entries(studio.score.value, "pad");
  const known = kept.some((one) => text(one, "does").toLowerCase() === pad.pad.toLowerCase());
  const keep = (): void => {
    const name = freePadName(pad, kept.map((one) => text(one, "name")));
    void studio.doc.edit({ do: "insert", at: ["pad"], value: { name, does: pad.pad, measures, ...(follow === "stop" ? {} : { follow }) } });
  };
  return (
    <button class="plain star" aria-label={`Keep ${pad.name} among mine`} aria-pressed={known} title={known ? "Among mine already; a click adds it once more" : "Keep it among mine, for so many measures, and with what follows"} onClick={keep}>
      {known ? "★" : "☆"}
    </button>
  );
}

/** The settings of a kept pad: for how many measures, what follows, and its place among the others. */
export function OwnSettings({ studio, number, pad }: { studio: Studio; number: number; pad: Pad }) {
  const set = (key: string, value: unknown): void => void studio.doc.edit({ do: "set", at: ["pad", number, key], value });
  return (
    <div class="settings">
      <input
        type="number" min={1} max={1024} value={pad.measures} aria-label={`Measures of ${pad.name}`} title="Measures"
        onChange={(event) => { if (event.currentTarget.checkValidity()) set("measures", Number(event.currentTarget.value)); }}
      />
      <select value={pad.follow} aria-label={`What follows ${pad.name}`} onChange={(event) => set("follow", event.currentTarget.value)}>
        {FOLLOWS.map(([name, , mark]) => <option key={name} value={name}>{mark}</option>)}
      </select>
      <button class="plain" disabled={number === 1} aria-label={`Move ${pad.name} up`} title="Up" onClick={() => void studio.doc.edit({ do: "move", at: ["pad", number], value: { number: number - 1 } })}>↑</button>
      <button class="plain" aria-label={`Remove ${pad.name} from mine`} title="Remove it from mine" onClick={() => void studio.doc.edit({ do: "delete", at: ["pad", number] })}>×</button>
    </div>
  );
}
