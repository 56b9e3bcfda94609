import { useSignal } from "@preact/signals";
import { colourOfHex, hexOf } from "../../model/form";
import { calling, choiceOf, choicesOf, found, valuesOf, wordsOfCall, type Choice } from "../../model/controls";
import { entries, text, type Entry } from "../../model/score";
import type { Studio } from "../../model/studio";
import type { Value } from "../../net/values";

const WHEN: [string, string][] = [["now", "at once"], ["beat", "at the next beat"], ["measure", "at the next measure"]];
const PLACE = ["to the right", "to the public"];

/** The control that an entry calls, chosen in words, and its values. */
export function CallField({ studio, entry, words, onCall }: { studio: Studio; entry: Entry; words: string; onCall: (call: string, values: Value[]) => void }) {
  const choices = choicesOf(studio.values.surface.value);
  const choice = choiceOf(choices, entry);
  return (
    <div class="call" role="group" aria-label={words}>
      <Chooser choices={choices} now={choice} words={wordsOfCall(choices, entry) || "choose"} onChoice={(one) => {
        const { call, values } = calling(one);
        onCall(call, values);
      }} />
      {choice && <CallValue choice={choice} values={valuesOf(entry)} onValues={(values) => onCall(choice.widget.address, values)} />}
    </div>
  );
}

function Chooser({ choices, now, words, onChoice }: { choices: Choice[]; now: Choice | undefined; words: string; onChoice: (choice: Choice) => void }) {
  const open = useSignal(false);
  const wanted = useSignal("");
  const fitting = open.value ? found(choices, wanted.value) : [];
  const pages = [...new Set(fitting.map((one) => one.page))];
  return (
    <details
      class="picker"
      open={open.value}
      onToggle={(event) => { open.value = event.currentTarget.open; }}
      onKeyDown={(event) => {
        if (event.key !== "Escape" || !open.value) return;
        event.stopPropagation();
        open.value = false;
        event.currentTarget.querySelector("summary")?.focus();
      }}
    >
      <summary title={now?.help ?? "What is called"}><span>{words}</span></summary>
      <div class="found">
        <input type="search" placeholder="Find a control" aria-label="Find a control" value={wanted.value} onInput={(event) => { wanted.value = event.currentTarget.value; }} />
        {pages.map((page) => (
          <div key={page} class="page" role="group" aria-label={page}>
            <h4>{page}</h4>
            {fitting.filter((one) => one.page === page).map((one) => (
              <button
                key={`${one.widget.address} ${one.words}`}
                aria-pressed={one === now}
                title={one.help}
                onClick={(event) => {
                  open.value = false;
                  event.currentTarget.closest("details")?.querySelector("summary")?.focus();
                  onChoice(one);
                }}
              >
                {one.words}
              </button>
            ))}
          </div>
        ))}
        {!fitting.length && <p class="hint">No control is called so.</p>}
        <button class="quiet" onClick={() => { open.value = false; }}>Close</button>
      </div>
    </details>
  );
}

function CallValue({ choice, values, onValues }: { choice: Choice; values: Value[]; onValues: (values: Value[]) => void }) {
  const { widget } = choice;
  const first = Number(values[0] ?? widget.start[0] ?? 0);
  switch (widget.kind) {
    case "fader": {
      const [low, high] = [widget.minimum[0] ?? 0, widget.maximum[0] ?? 1];
      return (
        <span class="range">
          <input type="range" min={low} max={high} step={(high - low) / 100} value={first} aria-label={`${choice.words}, value`} onChange={(event) => onValues([Number(event.currentTarget.value), ...values.slice(1)])} />
          <output>{Number(first.toFixed(2))}</output>
        </span>
      );
    }
    case "toggle":
      return <label class="pick"><input type="checkbox" checked={first > 0} onChange={(event) => onValues([event.currentTarget.checked ? 1 : 0, ...values.slice(1)])} /> on</label>;
    case "colour":
      return <input type="color" aria-label={`${choice.words}, colour`} value={hexOf(values)} onChange={(event) => onValues([...colourOfHex(event.currentTarget.value), ...values.slice(3)])} />;
    case "pad":
      return (
        <span class="range">
          {PLACE.map((words, index) => (
            <input key={words} type="number" step={0.1} aria-label={`${choice.words}, ${words}`} title={words} value={Number(values[index] ?? 0)} onChange={(event) => onValues([0, 1].map((each) => (each === index ? event.currentTarget.valueAsNumber || 0 : (values[each] ?? 0))).concat(values.slice(2) as number[]))} />
          ))}
        </span>
      );
    default:
      return null;
  }
}

/** What happens when a signal comes: the controls that are tied to it. */
export function Reactions({ studio, name }: { studio: Studio; name: string }) {
  const tied = entries(studio.score.value, "react").flatMap((entry, index) =>
    (text(entry, "on").toLowerCase() === name.toLowerCase() && entry["call"] !== undefined ? [{ entry, number: index + 1 }] : []));
  const [first] = choicesOf(studio.values.surface.value).filter((one) => one.widget.address === "/dance/spread");
  return (
    <section class="reactions" aria-label="When it comes">
      <h3>When it comes</h3>
      {!tied.length && <p class="hint">Nothing happens yet.</p>}
      {tied.map(({ entry, number }, index) => (
        <div key={number} class="reaction">
          <CallField studio={studio} entry={entry} words={`What happens, ${index + 1}`} onCall={(call, values) => void studio.doc.edit({ do: "change", at: ["react", number], value: { call, values } })} />
          <select aria-label={`When, ${index + 1}`} value={text(entry, "when", "measure")} onChange={(event) => void studio.doc.edit({ do: "set", at: ["react", number, "when"], value: event.currentTarget.value })}>
            {WHEN.map(([when, words]) => <option key={when} value={when}>{words}</option>)}
          </select>
          <button class="plain" aria-label={`Remove what happens, ${index + 1}`} title="Remove" onClick={() => void studio.doc.edit({ do: "delete", at: ["react", number] })}>×</button>
        </div>
      ))}
      <button disabled={!first} onClick={() => { if (first) void studio.doc.edit({ do: "insert", at: ["react"], value: { on: name, when: "beat", ...calling(first) } }); }}>Add what happens</button>
    </section>
  );
}
