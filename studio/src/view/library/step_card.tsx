import { useSignal } from "@preact/signals";
import { useEffect, useState } from "preact/hooks";
import type { Look, Motion } from "../../model/figure";
import { feetInWords, measuresInWords, stepDetail, takeInWords, written, type Missing, type StepFacts } from "../../model/steps";
import type { Studio } from "../../model/studio";
import { Dialog } from "../../ui/dialog";
import { Figure } from "./figure";
import { TakesGallery } from "./takes_gallery";
import { drag, putAtCursor } from "./put";

const LOOKS: [Look, string][] = [["front", "from the public"], ["side", "from the side"], ["above", "from above"]];

/** One step, seen from three sides: its takes, and what may come after it, as a sequence that can be put into the show. */
export function StepCard({ studio, name, onOpen, onClose }: { studio: Studio; name: string; onOpen: (name: string) => void; onClose: () => void }) {
  const facts = studio.library.step(name);
  const take = useSignal(1);
  const other = useSignal(0);
  const [motions, setMotions] = useState<Motion[]>([]);
  useEffect(() => {
    let left = false;
    void studio.library.motion(name, [take.value, ...(other.value ? [other.value] : [])]).then((found) => { if (!left) setMotions(found); });
    return () => { left = true; };
  }, [studio, name, take.value, other.value]);
  const own = facts?.takes[take.value - 1];
  return (
    <Dialog title={name} more={facts ? stepDetail(facts) : ""} onClose={onClose}>
      <div class="body card">
        <div class="looks">
          {LOOKS.map(([look, words]) => (
            <figure key={look}>
              {motions.length > 0 && <Figure studio={studio} motions={motions} look={look} label={`${name} ${words}`} />}
              <figcaption class="hint">{words}</figcaption>
            </figure>
          ))}
        </div>
        {motions[0] && <Feet motion={motions[0]} />}
        <div class="about">
          <dl>
            <dt>Feet</dt><dd>{own ? feetInWords(own) : "…"}</dd>
            <dt>Way</dt><dd>{own ? `${own.direction}${own.distance_m > 0.1 ? `, ${own.distance_m.toFixed(1)} m` : ""}` : "…"}</dd>
            {own && (own.begin_pose || own.end_pose) && <><dt>Poses</dt><dd>{own.begin_pose || "any"} → {own.end_pose || "any"}</dd></>}
            {own && (own.author || own.style) && <><dt>By</dt><dd>{[own.author, own.style].filter(Boolean).join(", ")}</dd></>}
          </dl>
          {facts && facts.takes.length > 1 && (
            <div class="takes">
              <label class="field">Take <Takes facts={facts} value={take.value} onChange={(value) => { take.value = value; }} /></label>
              <label class="field">Compare <Takes facts={facts} value={other.value} none onChange={(value) => { other.value = value; }} /></label>
              {other.value > 0 && <p class="hint">The second one is blue.</p>}
            </div>
          )}
        </div>
        {facts && facts.takes.filter((one) => !one.mirrored).length > 1 && <TakesGallery studio={studio} facts={facts} onLook={(number) => { take.value = number; }} />}
        {facts && <Chain studio={studio} facts={facts} onOpen={onOpen} onPut={onClose} />}
      </div>
    </Dialog>
  );
}

function Takes({ facts, value, none, onChange }: { facts: StepFacts; value: number; none?: boolean; onChange: (value: number) => void }) {
  return (
    <select value={String(value)} onChange={(event) => onChange(Number(event.currentTarget.value))}>
      {none && <option value="0">none</option>}
      {facts.takes.map((take, index) => <option key={index} value={String(index + 1)}>{takeInWords(take, index + 1)}</option>)}
    </select>
  );
}

/** Which foot is on the floor, beat by beat. */
function Feet({ motion }: { motion: Motion }) {
  const count = Math.max(motion.contact.length - 1, 1);
  return (
    <svg class="feet" viewBox={`0 0 ${count} 10`} preserveAspectRatio="none" role="img" aria-label="When the left and the right foot are on the floor">
      {motion.contact.slice(0, count).map((feet, index) => (
        <g key={index}>
          {(feet & 1) > 0 && <rect class="left" x={index} y="1" width="1.05" height="3.4" />}
          {(feet & 2) > 0 && <rect class="right" x={index} y="5.6" width="1.05" height="3.4" />}
        </g>
      ))}
      {Array.from({ length: motion.beats + 1 }, (_, beat) => <line key={beat} x1={beat * motion.samplesPerBeat} x2={beat * motion.samplesPerBeat} y1="0" y2="10" vector-effect="non-scaling-stroke" />)}
    </svg>
  );
}

/** Steps one after the other: what may follow is clicked, what cannot is told with what to record. */
function Chain({ studio, facts, onOpen, onPut }: { studio: Studio; facts: StepFacts; onOpen: (name: string) => void; onPut: () => void }) {
  const chain = useSignal([facts.name]);
  const [check, setCheck] = useState<{ missing: Missing[]; fault: string } | null>(null);
  const last = studio.library.step(chain.value.at(-1) ?? "") ?? facts;
  const others = (studio.library.steps.value ?? []).map((one) => one.name).filter((one) => !last.follows.includes(one));
  const measures = chain.value.reduce((sum, name) => sum + (studio.library.step(name)?.measures ?? 1), 0);
  useEffect(() => {
    let left = false;
    setCheck(null);
    if (chain.value.length > 1) void studio.library.missing(chain.value).then((found) => { if (!left) setCheck(found); });
    return () => { left = true; };
  }, [studio, chain.value]);
  const add = (name: string): void => { chain.value = [...chain.value, name]; };
  const item = { list: "sequence", value: { steps: written(chain.value) } };
  return (
    <section class="chain" aria-label="Sequence">
      <h3>Sequence <span class="hint">{measuresInWords(measures)}</span></h3>
      <ol>
        {chain.value.map((name, index) => {
          const bad = check?.missing.some((one) => one.to === name && one.from === chain.value[index - 1]);
          return (
            <li key={index} class={bad ? "bad" : ""}>
              <button class="plain" title="Look at this step" onClick={() => onOpen(name)}>{name}</button>
              {index > 0 && <button class="plain" aria-label={`Take ${name} out of the sequence`} onClick={() => { chain.value = chain.value.filter((_, at) => at !== index); }}>×</button>}
            </li>
          );
        })}
      </ol>
      {check?.fault && <p role="alert" class="lack">{check.fault}</p>}
      {check?.missing.map((one, index) => (
        <div key={index} class="lack" role="status">
          <b>Record this to make measure {one.measure} of it possible</b>
          <p>{one.needs}</p>
          {one.because.map((words, at) => <p key={at} class="hint">{words}</p>)}
        </div>
      ))}
      <h3>May follow {last.name}</h3>
      <div class="chips">
        {last.follows.map((name) => <button key={name} onClick={() => add(name)}>{name}</button>)}
        {!last.follows.length && <span class="hint">nothing yet</span>}
      </div>
      {others.length > 0 && (
        <>
          <h3>Cannot follow yet</h3>
          <div class="chips cannot">{others.map((name) => <button key={name} title="Add it, and see what is missing" onClick={() => add(name)}>{name}</button>)}</div>
        </>
      )}
      <h3>May come before {facts.name}</h3>
      <p class="hint">{facts.precedes.join(", ") || "nothing yet"}</p>
      <div class="actions">
        <button class="primary" draggable onDragStart={(event) => drag(studio, event, item)} disabled={Boolean(check?.missing.length || check?.fault)} onClick={() => { void putAtCursor(studio, item); onPut(); }}>
          Put at the cursor
        </button>
      </div>
    </section>
  );
}
