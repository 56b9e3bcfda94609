import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { Fault } from "../../model/document";
import {
  cleanName, firstOf, labelled, labelOf, LABEL_KEYS, moved, progressOf, renamed, slotAt, slotsOf, suggestionOf,
  type LabelFacts, type Pattern, type Slot, type Suggestion, type Take,
} from "../../model/labels";
import { Link } from "../../net/link";
import { CoupleView, type CoupleMotion } from "./couple_view";
import "./label.css";

const SLOW = 0.5;
const MOST_UNDONE = 200;

interface State {
  labels: string[];
  patterns: Pattern[];
  firsts: Record<string, number>;
}

/** Recorded couples dance, and a person labels the pattern that is danced by a key. Each change is saved at once. */
export function LabelPage({ secret, facts }: { secret: string; facts: LabelFacts }) {
  const taken = useSignal(facts.takes[0]?.name ?? "");
  const motion = useSignal<CoupleMotion | null>(null);
  const time = useSignal(0);
  const playing = useSignal(false);
  const slow = useSignal(false);
  const looped = useSignal(true);
  const state = useSignal<State>({
    labels: facts.labels, patterns: facts.pattern,
    firsts: Object.fromEntries(facts.takes.map((take) => [take.name, firstOf(take, facts.pattern, facts.pattern_beats)])),
  });
  const undone = useRef<State[]>([]);
  const saved = useSignal<"saved" | "saving" | "waiting">("saved");
  const faults = useSignal<Fault[]>([]);
  const added = useSignal("");
  const suggested = useSignal<Record<string, Suggestion[]>>({});
  const link = useRef<Link | null>(null);
  const revision = useRef(facts.revision);
  const sent = useRef<State | null>(null);
  const coming = useRef<{ take: string; samples: number; dancers: number; width: number; depth: number } | null>(null);

  // Keys and frames come between two renderings: what acts reads the signals when it acts.
  const takeNow = (): Take | undefined => facts.takes.find((one) => one.name === taken.value) ?? facts.takes[0];
  const firstNow = (): number => state.value.firsts[taken.value] ?? 0;
  const slotsNow = (): Slot[] => {
    const take = takeNow();
    return take ? slotsOf(take, firstNow(), facts.pattern_beats) : [];
  };

  const save = (): void => {
    if (sent.current) {
      saved.value = "waiting"; // the answer sends the latest
      return;
    }
    const { labels, patterns } = state.value;
    saved.value = link.current?.send({ save: { labels, pattern: patterns }, revision: revision.current }) ? "saving" : "waiting";
    if (saved.value === "saving") sent.current = state.value;
  };
  const change = (next: State): void => {
    undone.current = [...undone.current.slice(1 - MOST_UNDONE), state.value];
    state.value = next;
    faults.value = [];
    save();
  };
  const undo = (): void => {
    const before = undone.current.pop();
    if (!before) return;
    state.value = before;
    save();
  };
  const open = (name: string): void => {
    taken.value = name;
    motion.value = null;
    time.value = 0;
    link.current?.send({ take: name });
  };
  const setLabel = (label: string | null): void => {
    const slots = slotsNow();
    const slot = slots[slotAt(slots, time.value)];
    if (slot) change({ ...state.value, patterns: labelled(state.value.patterns, taken.value, slot, label) });
  };
  const suggest = (): void => {
    link.current?.send({ suggest: taken.value });
  };
  const accept = (): void => {
    const slots = slotsNow();
    const slot = slots[slotAt(slots, time.value)];
    const label = slot && suggestionOf(suggested.value[taken.value] ?? [], slot);
    if (label) setLabel(label);
  };
  const shift = (by: number): void => {
    const take = takeNow();
    if (!take) return;
    const other = (firstNow() + by + facts.pattern_beats) % facts.pattern_beats;
    const patterns = moved(state.value.patterns, take, slotsNow(), slotsOf(take, other, facts.pattern_beats));
    change({ ...state.value, patterns, firsts: { ...state.value.firsts, [take.name]: other } });
  };
  const toSlot = (by: number): void => {
    const slots = slotsNow();
    const here = slotAt(slots, time.value);
    const next = here < 0 ? (by > 0 ? slots.findIndex((one) => one.from > time.value) : -1) : here + by;
    const slot = slots[Math.min(Math.max(next, 0), slots.length - 1)];
    if (slot) time.value = slot.from;
  };
  const toTake = (by: number): void => {
    const next = facts.takes[facts.takes.findIndex((one) => one.name === taken.value) + by];
    if (next) open(next.name);
  };
  const add = (event: Event): void => {
    event.preventDefault();
    const name = cleanName(added.value);
    if (!name) faults.value = [{ what: "A label begins with a letter or a number, and is 40 letters long at most" }];
    else if (state.value.labels.length >= LABEL_KEYS.length - 3) faults.value = [{ what: "There is no key left for another label" }];
    else if (!state.value.labels.includes(name)) change({ ...state.value, labels: [...state.value.labels, name] });
    if (name) added.value = "";
  };
  const rename = (label: string): void => {
    const name = cleanName(prompt(`Another name for ${label}`, label) ?? label);
    if (name && name !== label) {
      const { labels, patterns } = renamed(state.value.labels, state.value.patterns, label, name);
      change({ ...state.value, labels, patterns });
    }
  };

  useEffect(() => {
    const made = new Link("/studio/label", secret);
    made.onOpen = () => {
      sent.current = null;
      made.send({ take: taken.value });
      if (saved.value !== "saved") save();
    };
    made.onText = (told) => {
      if (told["kind"] === "motion") {
        coming.current = told as unknown as typeof coming.current;
        return;
      }
      if (told["kind"] === "suggested") {
        suggested.value = { ...suggested.value, [told["take"] as string]: told["spans"] as Suggestion[] };
        return;
      }
      if (told["kind"] === "refused" && !sent.current) {
        faults.value = told["refused"] as Fault[];
        return;
      }
      const asked = sent.current;
      sent.current = null;
      if (told["kind"] === "saved") {
        revision.current = told["revision"] as number;
        if (asked === state.value) saved.value = "saved";
        else save();
        return;
      }
      faults.value = (told["refused"] as Fault[] | undefined) ?? [];
      if (told["kind"] === "changed") {
        revision.current = told["revision"] as number;
        state.value = { ...state.value, labels: told["labels"] as string[], patterns: told["pattern"] as Pattern[] };
        undone.current = [];
        saved.value = "saved";
      } else saved.value = "waiting";
    };
    made.onBinary = (data) => {
      const known = coming.current;
      if (!known || known.take !== taken.value) return;
      motion.value = { ...known, rate: facts.rate, joints: new Int16Array(data.buffer, data.byteOffset, data.byteLength / 2) };
    };
    made.open();
    link.current = made;
    return () => made.close();
  }, [secret]);

  useEffect(() => {
    let asked = 0;
    let before = performance.now();
    const step = (now: number): void => {
      const passed = (now - before) / 1000;
      before = now;
      const take = takeNow();
      if (playing.value && take && motion.value) {
        const slots = slotsNow();
        const known = slots[slotAt(slots, time.value)];
        let next = time.value + Math.min(passed, 0.2) * (slow.value ? SLOW : 1);
        if (looped.value && known && next >= known.to) next = known.from;
        if (next >= take.seconds) {
          next = take.seconds;
          playing.value = false;
        }
        time.value = next;
      }
      asked = requestAnimationFrame(step);
    };
    asked = requestAnimationFrame(step);
    return () => cancelAnimationFrame(asked);
  }, []);

  useEffect(() => {
    const listen = (event: KeyboardEvent): void => {
      const on = event.target as HTMLElement;
      if (on.matches("input, select, textarea") || event.altKey) return;
      if (event.key === "Enter") {
        if (on.matches("button")) return; // that is pressed
        event.preventDefault();
        accept();
        return;
      }
      if (event.ctrlKey || event.metaKey) {
        if (event.key.toLowerCase() !== "z") return;
        event.preventDefault();
        undo();
        return;
      }
      const act = KEYS[event.key] ?? KEYS[event.key.toLowerCase()];
      const label = state.value.labels[LABEL_KEYS.indexOf(event.key.toLowerCase())];
      if (act) act();
      else if (event.key.length === 1 && label !== undefined) setLabel(label);
      else return;
      event.preventDefault();
    };
    const KEYS: Record<string, () => void> = {
      " ": () => { playing.value = !playing.value; }, ArrowLeft: () => toSlot(-1), ArrowRight: () => toSlot(1),
      ArrowUp: () => toTake(-1), ArrowDown: () => toTake(1), Delete: () => setLabel(null), Backspace: () => setLabel(null),
      l: () => { looped.value = !looped.value; }, s: () => { slow.value = !slow.value; }, "[": () => shift(-1), "]": () => shift(1), "?": suggest,
    };
    addEventListener("keydown", listen);
    return () => removeEventListener("keydown", listen);
  }, []);

  const take = takeNow();
  const first = firstNow();
  const slots = slotsNow();
  const here = slotAt(slots, time.value);
  const progress = progressOf(facts, state.value.patterns, state.value.firsts);
  const beat = take ? take.beats.findLastIndex((at) => at <= time.value) : -1;
  const current = slots[here] && take ? labelOf(state.value.patterns, take.name, slots[here]) : null;
  const spans = suggested.value[taken.value] ?? [];
  const guess = slots[here] && current === null ? suggestionOf(spans, slots[here]) : null;
  return (
    <main class="label">
      <header class="bar">
        <h1>Patterns of {facts.pairs}</h1>
        <label class="field">Take
          <select value={taken.value} onChange={(event) => open(event.currentTarget.value)}>
            {facts.takes.map((one) => <option key={one.name} value={one.name}>{one.name}{one.style ? ` (${one.style})` : ""}</option>)}
          </select>
        </label>
        <div class="now"><b class="count">{beat < 0 ? "–" : ((beat - first + 8 * facts.pattern_beats) % facts.pattern_beats) + 1}</b><span>{time.value.toFixed(1)} s</span></div>
        <p class="hint" role="status">{progress.done} of {progress.of} patterns have a label – {WORDS[saved.value]}</p>
      </header>
      <div class="couple">
        <CoupleView motion={motion} time={time} />
        <p class="current">{here < 0 ? "between the patterns" : (current ?? (guess ? `${guess}? Enter takes it` : "no label"))}</p>
      </div>
      <aside>
        <h2>Label of this pattern</h2>
        <ul>
          {state.value.labels.map((label, index) => (
            <li key={label}>
              <button aria-pressed={label === current} disabled={here < 0} onClick={() => setLabel(label)}><kbd>{LABEL_KEYS[index]}</kbd> {label}</button>
              <button class="plain" aria-label={`Rename ${label}`} onClick={() => rename(label)}>✎</button>
            </li>
          ))}
          <li><button disabled={current === null} onClick={() => setLabel(null)}><kbd>Delete</kbd> no label</button></li>
        </ul>
        <form onSubmit={add}>
          <label class="field">New label
            <input value={added.value} maxLength={40} onInput={(event) => { added.value = event.currentTarget.value; }} />
          </label>
          <button>Add</button>
        </form>
        {faults.value.map((fault, index) => <p key={index} role="alert">{fault.what}{fault.remedy ? ` – ${fault.remedy}` : ""}</p>)}
        <dl class="hint">
          <dt>Space</dt><dd>play, stop</dd><dt>← →</dt><dd>pattern</dd><dt>↑ ↓</dt><dd>take</dd><dt>L</dt><dd>repeat the pattern</dd><dt>S</dt><dd>slowly</dd>
          <dt>?</dt><dd>suggest labels from the other takes</dd><dt>Enter</dt><dd>take what is suggested</dd><dt>[ ]</dt><dd>patterns begin a beat earlier, later</dd><dt>Ctrl+Z</dt><dd>undo</dd>
        </dl>
        <p class="hint">Saved in {facts.file}</p>
      </aside>
      <footer>
        <div class="tools">
          <button aria-pressed={playing.value} onClick={() => { playing.value = !playing.value; }}>{playing.value ? "Stop" : "Play"}</button>
          <button aria-pressed={looped.value} onClick={() => { looped.value = !looped.value; }}>Repeat</button>
          <button aria-pressed={slow.value} onClick={() => { slow.value = !slow.value; }}>Slowly</button>
          <button onClick={suggest}>Suggest</button>
          <button onClick={() => shift(-1)} aria-label="Patterns begin a beat earlier">[</button>
          <button onClick={() => shift(1)} aria-label="Patterns begin a beat later">]</button>
        </div>
        <div class="patterns" role="group" aria-label="Patterns of the take">
          {slots.map((slot, index) => {
            const name = take ? labelOf(state.value.patterns, take.name, slot) : null;
            const told = name === null ? suggestionOf(spans, slot) : null;
            const done = Math.min(Math.max((time.value - slot.from) / (slot.to - slot.from), 0), 1);
            return (
              <button
                key={index} aria-current={index === here ? "true" : undefined} style={{ flexGrow: slot.to - slot.from }}
                title={`${slot.from.toFixed(1)} to ${slot.to.toFixed(1)} s`} class={name === null ? "none" : `l${state.value.labels.indexOf(name) % 8}`}
                onClick={() => { time.value = slot.from; }}
              >
                {name ?? (told ? `${told}?` : index + 1)}{index === here && <i style={{ width: `${100 * done}%` }} />}
              </button>
            );
          })}
        </div>
      </footer>
    </main>
  );
}

const WORDS = { saved: "saved", saving: "saving …", waiting: "not saved yet" };
