import { useEffect, useState } from "preact/hooks";
import { chainsOf, type Chain, type Missing } from "../../model/steps";
import type { Studio } from "../../model/studio";

const MOST = 40;

interface Lack {
  chain: Chain;
  missing: Missing;
}

/** What would have to be recorded so that the steps of the score can follow one another, with the measure. */
export function Lacks({ studio }: { studio: Studio }) {
  const [lacks, setLacks] = useState<Lack[]>([]);
  const chains = chainsOf(studio.boxes.value).filter((chain) => chain.words.length).slice(0, MOST);
  const asked = JSON.stringify([chains, studio.doc.structure.value?.library]);
  useEffect(() => {
    let left = false;
    void Promise.all(chains.map(async (chain) => (await studio.library.missing(chain.words)).missing.map((missing) => ({ chain, missing })))).then((found) => {
      if (!left) setLacks(found.flat());
    });
    return () => { left = true; };
  }, [studio, asked]);
  if (!lacks.length) return null;
  return (
    <details class="lacks">
      <summary>{lacks.length === 1 ? "1 step to record" : `${lacks.length} steps to record`}</summary>
      {lacks.slice(0, 30).map(({ chain, missing }, index) => {
        const measure = chain.start + missing.measure;
        return (
          <div key={index} class="lack">
            <button class="plain" title="Look at this measure" onClick={() => { studio.cursor.value = measure - 1; }}>Record this to make measure {measure} possible</button>
            <p>{missing.needs}</p>
            {missing.because.map((words, at) => <p key={at} class="hint">{words}</p>)}
          </div>
        );
      })}
    </details>
  );
}
