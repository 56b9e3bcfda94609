import type { Signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { Studio } from "../../model/studio";
import { entries } from "../../model/score";
import { choiceInWords } from "../../model/gap";
import { colourOfHex, dancerWords, dragged, hexOf, namesOf, readNumber, readNumbers, toggled, type Field } from "../../model/form";
import { StepsControl } from "./steps_control";

const SWATCHES = ["#eb5c24", "#1f84b8", "#e0b85c", "#58b368", "#a06bb0", "#e05c7f", "#4fb9b3", "#f0f0f4", "#7d8db0", "#31313b"];
const MOST_POINTS = 24;
const MOST_DANCERS = 16;

interface Props {
  studio: Studio;
  id: string;
  field: Field;
  value: unknown;
  /** The entries hold different values. */
  several: boolean;
  focus?: boolean;
  onValue: (value: unknown) => void;
}

/** The control of a field. What is typed counts when it is left, or with Enter; Escape takes it back. */
export function FieldControl(props: Props) {
  const { field, id, value, several, onValue, studio } = props;
  switch (field.control) {
    case "integer":
    case "number":
      return <NumberControl {...props} />;
    case "switch":
      return <input id={id} type="checkbox" checked={(value ?? field.default) === true} ref={(box) => { if (box) box.indeterminate = several; }} onChange={(event) => onValue(event.currentTarget.checked)} />;
    case "choice":
      return (
        <select id={id} value={several ? "" : String(value ?? field.default ?? "")} onChange={(event) => {
          const found = field.choices?.find((one) => String(one) === event.currentTarget.value);
          if (found !== undefined) onValue(found);
        }}>
          {(several || (value === undefined && field.default === undefined)) && <option value="">{several ? "several" : "–"}</option>}
          {field.choices?.map((one) => <option key={one} value={String(one)}>{choiceInWords(field.key, String(one))}</option>)}
        </select>
      );
    case "colour":
      return <ColourControl {...props} />;
    case "pair":
      return <PairControl {...props} />;
    case "line":
      return <LineControl {...props} />;
    case "numbers":
      return <TextControl {...props} shown={Array.isArray(value) ? value.join(", ") : ""} read={(said) => (said.trim() ? (readNumbers(said) ?? undefined) : undefined)} />;
    case "texts":
      return <TextControl {...props} shown={Array.isArray(value) ? value.join(", ") : ""} read={(said) => said.split(",").map((part) => part.trim()).filter(Boolean)} />;
    case "steps":
      return <StepsControl studio={studio} id={id} value={value} several={several} onValue={onValue} />;
    case "dancers":
      return <DancersControl {...props} />;
    case "text":
      return <TextControl {...props} shown={typeof value === "string" ? value : ""} read={(said) => said || undefined} />;
    case "json":
      return <TextControl {...props} shown={value === undefined ? "" : JSON.stringify(value)} read={parsed} />;
    default:
      return <NameControl {...props} />;
  }
}

const SCRUB_PX = 4;

/** A number whose label is dragged: where it was pressed [px], and what it would be. */
export interface Scrubbed {
  from: number;
  value: number | null;
}

/** Listeners for the label of a number: dragged to the right it is more, to the left less, with Shift ten times as fast. */
export function scrub(field: Field, value: unknown, held: Signal<Scrubbed | null>, onValue: (value: number) => void) {
  return {
    title: "Drag it to the right for more, to the left for less; with Shift faster",
    onPointerDown: (event: PointerEvent): void => {
      if (event.button !== 0) return;
      held.value = { from: event.clientX, value: null };
      (event.currentTarget as HTMLElement).setPointerCapture(event.pointerId);
    },
    onPointerMove: (event: PointerEvent): void => {
      const now = held.peek();
      if (!now) return;
      const steps = Math.trunc((event.clientX - now.from) / SCRUB_PX) * (event.shiftKey ? 10 : 1);
      if (steps || now.value !== null) held.value = { ...now, value: dragged(field, value, steps) };
    },
    onPointerUp: (event: PointerEvent): void => {
      const last = held.peek()?.value ?? null;
      held.value = null;
      if (last === null) return;
      event.currentTarget?.addEventListener("click", (click) => click.preventDefault(), { once: true }); // or the field gets the focus
      if (last !== value) onValue(last);
    },
    onPointerCancel: (): void => { held.value = null; },
  };
}

function parsed(said: string): unknown {
  if (!said.trim()) return undefined;
  try {
    return JSON.parse(said);
  } catch {
    return said;
  }
}

function shownDefault(field: Field): string {
  if (Array.isArray(field.default)) return field.default.join(", ");
  if (field.control === "dancers" && field.default === "*") return "everybody";
  return field.default === undefined || typeof field.default === "object" ? "" : String(field.default);
}

function TextControl({ id, field, several, shown, read, onValue, focus, list }: Props & { shown: string; read: (said: string) => unknown; list?: string }) {
  const input = useRef<HTMLInputElement>(null);
  useEffect(() => { if (focus) input.current?.select(); }, [focus]);
  return (
    <input
      id={id}
      ref={input}
      list={list}
      value={shown}
      spellcheck={false}
      placeholder={several ? "several" : shownDefault(field)}
      onKeyDown={(event) => {
        if (event.key === "Enter") event.currentTarget.blur();
        else if (event.key === "Escape") {
          event.currentTarget.value = shown;
          event.currentTarget.blur();
        }
      }}
      onBlur={(event) => {
        const said = event.currentTarget.value;
        if (focus || said !== shown) onValue(said === shown ? read(shown) : read(said));
      }}
    />
  );
}

function NumberControl({ id, field, value, several, onValue }: Props) {
  const number = typeof value === "number" ? value : undefined;
  const fraction = field.least === 0 && field.most === 1;
  const send = (said: string): void => {
    if (!said.trim()) {
      if (!field.required) onValue(undefined);
      return;
    }
    const found = readNumber(field, said);
    if (found !== null) onValue(found);
  };
  return (
    <>
      {fraction && <input type="range" min={0} max={1} step={0.01} aria-label={field.words} value={number ?? Number(field.default ?? 0)} onChange={(event) => send(event.currentTarget.value)} />}
      <input
        id={id}
        type="number"
        min={field.least}
        max={field.most}
        step={field.control === "integer" ? 1 : "any"}
        value={number ?? ""}
        placeholder={several ? "several" : field.default === undefined ? "" : String(field.default)}
        onChange={(event) => send(event.currentTarget.value)}
      />
    </>
  );
}

function ColourControl({ studio, id, field, value, onValue }: Props) {
  const used = entries(studio.score.value, "group").map((group) => hexOf(group["colour"]));
  return (
    <div class="colours">
      <input id={id} type="color" value={hexOf(value)} onChange={(event) => onValue(colourOfHex(event.currentTarget.value))} />
      {[...new Set([...used, ...SWATCHES])].slice(0, 11).map((hex) => (
        <button key={hex} class="swatch" aria-label={`${field.words} ${hex}`} aria-pressed={hex === hexOf(value)} style={{ background: hex }} onClick={() => onValue(colourOfHex(hex))} />
      ))}
    </div>
  );
}

function PairControl({ id, field, value, several, onValue }: Props) {
  const pair = Array.isArray(value) ? (value as number[]) : [undefined, undefined];
  const fallback = Array.isArray(field.default) ? (field.default as number[]) : [0, 0];
  const labels = field.key === "size" ? ["width", "depth"] : field.key === "tempo_range" ? ["lowest", "highest"] : ["to the right", "to the public"];
  const send = (index: number, said: string): void => {
    const found = Number(said);
    if (!said.trim() || !Number.isFinite(found)) return;
    onValue([0, 1].map((each) => (each === index ? found : (pair[each] ?? fallback[each] ?? 0))));
  };
  return (
    <>
      {[0, 1].map((index) => (
        <input key={index} id={index ? undefined : id} type="number" step="any" aria-label={`${field.words}, ${labels[index]}`} title={labels[index]} value={pair[index] ?? ""} placeholder={several ? "several" : String(fallback[index] ?? "")} onChange={(event) => send(index, event.currentTarget.value)} />
      ))}
    </>
  );
}

/** The points of a line or a curve, each as two numbers; long ones are edited on the stage. */
function LineControl({ id, field, value, onValue }: Props) {
  const points = Array.isArray(value) && value.every((one) => Array.isArray(one) && typeof one[0] === "number") ? (value as [number, number][]) : null;
  if (!points || points.length > MOST_POINTS) {
    return <output id={id} class="hint">{points ? `${points.length} points: drag them where you see them` : value === undefined ? "none: draw it on the stage" : "several lines: draw them on the stage"}</output>;
  }
  const send = (index: number, part: number, said: string): void => {
    const found = Number(said);
    if (said.trim() && Number.isFinite(found)) onValue(points.map((point, each) => (each === index ? point.map((one, other) => (other === part ? found : one)) : point)));
  };
  return (
    <ol class="points" id={id}>
      {points.map((point, index) => (
        <li key={index}>
          {[0, 1].map((part) => <input key={part} type="number" step="any" aria-label={`${field.words}, point ${index + 1}, ${part ? "second" : "first"} number`} value={point[part]} onChange={(event) => send(index, part, event.currentTarget.value)} />)}
          {points.length > 2 && <button class="plain" aria-label={`Remove point ${index + 1}`} onClick={() => onValue(points.filter((_, each) => each !== index))}>×</button>}
        </li>
      ))}
    </ol>
  );
}

/** The name of an entry of a list: typed, or one of those that are there. */
function NameControl(props: Props) {
  const { studio, field, value, id } = props;
  const names = field.control === "step" ? (studio.doc.structure.value?.library ?? []).map((step) => step.name) : namesOf(studio.score.value, field.control);
  return (
    <>
      <TextControl {...props} shown={typeof value === "string" ? value : ""} read={(said) => said.trim() || undefined} list={`${id}-names`} />
      <datalist id={`${id}-names`}>{names.map((name) => <option key={name} value={name} />)}</datalist>
    </>
  );
}

/** Dancers as a selection: typed, or put together from groups, places and those who are selected on the stage. */
function DancersControl(props: Props) {
  const { studio, value, several, onValue, field } = props;
  const selection = typeof value === "string" ? value : "*";
  const parts = selection.split("+").map((part) => part.trim().toLowerCase());
  const dancers = studio.dancers.value;
  return (
    <div class="dancers-field">
      <TextControl {...props} shown={several ? "" : typeof value === "string" ? value : ""} read={(said) => said.trim() || undefined} />
      <details>
        <summary>Choose</summary>
        <div class="chips">
          <button aria-pressed={!several && selection === "*"} onClick={() => onValue(field.default === "*" ? undefined : "*")}>everybody</button>
          {dancerWords(studio.score.value).map((word) => (
            <button key={word} aria-pressed={!several && parts.includes(word.toLowerCase())} onClick={() => onValue(toggled(selection, word))}>{word}</button>
          ))}
          {dancers.length > 0 && (
            <button onClick={() => onValue(studio.whom.peek())}>{dancers.length === 1 ? `dancer ${dancers[0]}` : dancers.length <= MOST_DANCERS ? `dancers ${dancers.join(", ")}` : `the ${dancers.length} of the stage`}</button>
          )}
        </div>
        <p class="hint">Also “tide &amp; left”, “ember - soloist”, or numbers: “1 + 4”.</p>
      </details>
    </div>
  );
}

