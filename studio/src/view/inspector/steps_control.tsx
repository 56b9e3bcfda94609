import type { Studio } from "../../model/studio";
import { readSteps, writeSteps, type WrittenStep } from "../../model/form";

/** Steps one after the other: name with completion, how often, and their order. */
export function StepsControl({ studio, id, value, several, onValue }: { studio: Studio; id: string; value: unknown; several: boolean; onValue: (value: unknown) => void }) {
  const steps = readSteps(value);
  const library = studio.doc.structure.value?.library ?? [];
  const known = new Map(library.map((step) => [step.name.toLowerCase(), step.measures]));
  const send = (next: WrittenStep[]): void => {
    const written = writeSteps(next);
    if (written.length) onValue(written);
  };
  const put = (index: number, step: WrittenStep): void => send(steps.map((one, each) => (each === index ? step : one)));
  const move = (index: number, by: number): void => {
    const next = [...steps];
    const [one] = next.splice(index, 1);
    if (one) next.splice(index + by, 0, one);
    send(next);
  };
  return (
    <div class="steps-field">
      {several && <p class="hint">They dance different steps.</p>}
      <ol id={id}>
        {steps.map((step, index) => (
          <li key={index}>
            <input list={`${id}-library`} aria-label={`Step ${index + 1}`} aria-invalid={step.name !== "*" && !known.has(step.name.toLowerCase())} value={step.name} onChange={(event) => put(index, { ...step, name: event.currentTarget.value })} />
            <input type="number" min={1} max={999} aria-label={`How often step ${index + 1} is danced`} title="how often" value={step.times} onChange={(event) => put(index, { ...step, times: Math.max(1, Math.round(Number(event.currentTarget.value) || 1)) })} />
            <button class="plain" disabled={index === 0} aria-label={`Step ${index + 1} earlier`} onClick={() => move(index, -1)}>↑</button>
            <button class="plain" disabled={index === steps.length - 1} aria-label={`Step ${index + 1} later`} onClick={() => move(index, 1)}>↓</button>
            <button class="plain" disabled={steps.length === 1} aria-label={`Remove step ${index + 1}`} onClick={() => send(steps.filter((_, each) => each !== index))}>×</button>
          </li>
        ))}
      </ol>
      <datalist id={`${id}-library`}>{library.map((step) => <option key={step.name} value={step.name} />)}</datalist>
      <input
        list={`${id}-library`}
        placeholder="add a step"
        aria-label="Add a step"
        value=""
        onChange={(event) => {
          const name = event.currentTarget.value.trim();
          event.currentTarget.value = "";
          if (name) send([...steps, { name, times: 1 }]);
        }}
      />
    </div>
  );
}
