import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { feetInWords, isWanted, stepDetail, type StepFacts } from "../../model/steps";
import type { Studio } from "../../model/studio";
import { SmallFigure } from "./figure";
import { drag, onEnter, putAtCursor } from "./put";
import { Lacks } from "./lacks";
import { StepCard } from "./step_card";

/** The steps of the show, each danced on the beat. A click opens its card, Enter puts it at the cursor. */
export function StepsPanel({ studio, wanted }: { studio: Studio; wanted: string }) {
  const card = useSignal("");
  useEffect(() => studio.library.need(), [studio]);
  const known = studio.library.steps.value;
  const plain = studio.doc.structure.value?.library ?? [];
  const rows = plain.map((step) => ({ step, facts: known?.find((one) => one.name === step.name) }));
  const found = rows.filter(({ step, facts }) => isWanted(facts ?? step, wanted));
  return (
    <>
      <ul class="items" aria-label="Steps">
        {found.map(({ step, facts }) => (
          <StepRow key={step.name} studio={studio} name={step.name} facts={facts} onOpen={() => { card.value = step.name; }} />
        ))}
      </ul>
      {!known && !studio.library.fault.value && <p class="hint none" role="status">The steps come in a moment …</p>}
      {!found.length && <p class="hint none">{plain.length ? "No step is called so." : "This show has no steps."}</p>}
      {studio.library.fault.value && <p class="hint none" role="alert">{studio.library.fault.value}</p>}
      <Lacks studio={studio} />
      {card.value && <StepCard key={card.value} studio={studio} name={card.value} onOpen={(name) => { card.value = name; }} onClose={() => { card.value = ""; }} />}
    </>
  );
}

function StepRow({ studio, name, facts, onOpen }: { studio: Studio; name: string; facts: StepFacts | undefined; onOpen: () => void }) {
  const item = { list: "sequence", value: { steps: [name] } };
  return (
    <li class="step">
      <button
        draggable
        class="entry"
        title="Drag it onto a row. Click: look at it. Enter: put it at the cursor"
        onDragStart={(event) => drag(studio, event, item)}
        onKeyDown={onEnter(() => void putAtCursor(studio, item))}
        onClick={onOpen}
      >
        <SmallFigure studio={studio} name={name} />
        <span class="words">
          <b>{name}</b>
          <small>{facts ? stepDetail(facts) : " "}</small>
          <small>{facts ? feetInWords(facts) : " "}</small>
        </span>
      </button>
      <button class="plain add" aria-label={`Put ${name} at the cursor`} title="Put it at the cursor" onClick={() => void putAtCursor(studio, item)}>+</button>
    </li>
  );
}
