import { useSignal } from "@preact/signals";
import type { Studio } from "../../model/studio";

const KINDS = ["step", "scene", "look", "cue"] as const;
type Kind = (typeof KINDS)[number];
/** Most choices of a vote. */
const MOST = 4;
/** A name that returns to the beginning, which nobody votes for. */
const START = "start";

/** What the audience votes on next: a kind, and two to four of its names. */
export function VoteForm({ studio }: { studio: Studio }) {
  const { values } = studio;
  const kind = useSignal<Kind>("step");
  const chosen = useSignal<string[]>([]);
  const widgets = values.surface.value?.pages.flatMap((page) => page.widgets) ?? [];
  const namesOf = (of: Kind): string[] => widgets
    .filter((widget) => widget.address === `/dance/${of}` && widget.kind === "button" && widget.values.length === 1)
    .map((widget) => String(widget.values[0]))
    .filter((name) => name !== START);
  const names = namesOf(kind.value);
  const pick = (name: string): void => {
    chosen.value = chosen.value.includes(name) ? chosen.value.filter((one) => one !== name) : [...chosen.value, name].slice(-MOST);
  };
  return (
    <section class="vote" aria-label="Vote">
      <h2>Vote</h2>
      <div class="choice" role="group" aria-label="What the vote is on">
        {KINDS.filter((one) => namesOf(one).length >= 2).map((one) => (
          <button key={one} aria-pressed={kind.value === one} onClick={() => { kind.value = one; chosen.value = []; }}>{one}</button>
        ))}
      </div>
      <div class="names" role="group" aria-label={`Choices, ${MOST} at most`}>
        {names.map((name) => <button key={name} role="switch" aria-checked={chosen.value.includes(name)} onClick={() => pick(name)}>{name}</button>)}
      </div>
      <div class="names">
        <button class="go" disabled={chosen.value.length < 2} onClick={() => values.send("/dance/audience/vote", kind.value, ...chosen.value)}>Let them vote</button>
        <button onClick={() => values.send("/dance/audience/vote/drop")}>Drop the vote</button>
      </div>
    </section>
  );
}
