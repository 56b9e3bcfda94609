import { useSignal } from "@preact/signals";
import { useEffect, useState } from "preact/hooks";
import { asLed, reached } from "../../model/danced";
import type { SingleEdit } from "../../model/document";
import { freeName } from "../../model/formations";
import { FACINGS, fillEntry, gapEdits, MATCHES, WAYS, type Gap, type Option, type OptionFigures } from "../../model/gap";
import { entries, text } from "../../model/score";
import type { Studio } from "../../model/studio";
import { Dialog } from "../../ui/dialog";
import { placeOf } from "../timeline/shortcuts";
import { LinkByHand } from "./link_by_hand";
import { WayPicture } from "./way_picture";
import "./ways.css";

interface Found {
  dancers: number[];
  options: OptionFigures[];
  fault: string;
}

/** The ways into a formation with each matching, side by side; the one that is chosen becomes one edit. */
export function WaysDialog({ studio, gap, onClose }: { studio: Studio; gap: Gap; onClose: () => void }) {
  const entry = entries(studio.score.value, "segment")[gap.to - 1] ?? {};
  const match = useSignal(gap.free ? "squared" : text(entry, "match", "squared"));
  const way = useSignal(gap.free ? "mended" : text(entry, "way", "mended"));
  const facing = useSignal(gap.free ? "" : text(entry, "facing"));
  const headings = useSignal<number[]>((entry["headings_deg"] as number[] | undefined) ?? []);
  const linking = useSignal(false);
  const [found, setFound] = useState<Found | null>(null);
  const place = placeOf(studio, gap.start);
  const length = Math.round(gap.length);
  const turned = Array.from({ length }, (_, index) => headings.value[index] ?? headings.value.at(-1) ?? 0);
  const option = (name: string): Option => ({
    match: name, way: way.value, ...(facing.value ? { facing: facing.value } : {}), ...(facing.value === "declared" ? { headings_deg: turned } : {}),
  });
  const asked = JSON.stringify([gap, MATCHES.map(([name]) => option(name)), studio.doc.revision.value]);

  useEffect(() => {
    let left = false;
    const tried: SingleEdit[] = gap.free ? [{ do: "insert", at: ["segment"], value: fillEntry(gap, place, {}) }] : [];
    const segment = gap.free ? entries(studio.score.peek(), "segment").length + 1 : gap.to;
    const timer = setTimeout(() => {
      void studio.library.ask({ segment, ...asLed(reached(studio.score.peek(), gap.start).led), options: MATCHES.map(([name]) => option(name)), ...(tried.length ? { with: tried } : {}) }).then((answer) => {
        if (left) return;
        const told = answer.texts["options"] as { dancers: number[]; options: OptionFigures[] } | undefined;
        setFound({
          dancers: told?.dancers ?? [], options: told?.options ?? [],
          fault: told ? "" : (answer.refused ?? []).map((one) => `${one.what}${one.remedy ? ` – ${one.remedy}` : ""}`).join("; ") || "There are no ways to choose from.",
        });
      });
    }, 120);
    return () => {
      left = true;
      clearTimeout(timer);
    };
  }, [studio, asked]);

  const save = async (linked: { name: string; table: Record<string, unknown> } | null): Promise<void> => {
    const edits = gapEdits(gap, place, entry, option(match.value), linked);
    const answer = await studio.doc.edits(edits);
    if (answer.refused) return;
    if (gap.free) studio.select({ list: "segment", number: entries(studio.score.peek(), "segment").length });
    onClose();
  };
  const own = found?.options[MATCHES.findIndex(([name]) => name === match.value)];
  const title = gap.free ? `Fill the gap before ${gap.formation}` : `Ways into ${gap.formation}`;
  return (
    <Dialog wide title={title} more={`${length} ${length === 1 ? "measure" : "measures"} from measure ${format(gap.start + 1)}${gap.group && gap.group !== "*" ? `, ${gap.group}` : ""}`} onClose={onClose}>
      <div class="body">
        {found?.fault && <p role="alert">{found.fault}</p>}
        {!found && <p class="hint" role="status">The ways are computed …</p>}
        {found && !found.fault && !linking.value && (
          <div class="options" role="radiogroup" aria-label="Who goes where">
            {MATCHES.map(([name, words, more], index) => {
              const figures = found.options[index];
              return figures && <OptionCard key={name} studio={studio} dancers={found.dancers} figures={figures} words={words} more={more} chosen={match.value === name} onChoose={() => { match.value = name; }} />;
            })}
          </div>
        )}
        {linking.value && own && found && (
          <LinkByHand
            studio={studio} dancers={found.dancers} figures={own}
            onCancel={() => { linking.value = false; }}
            onSave={(points) => void save({ name: freeName(studio.score.peek(), `${gap.formation.slice(0, 50)} linked`), table: { shape: "places", points } })}
          />
        )}
      </div>
      {!linking.value && (
        <footer>
          <label class="field">Ways <Choice value={way.value} options={WAYS} onChange={(value) => { way.value = value; }} /></label>
          <label class="field">They turn <Choice value={facing.value} options={FACINGS} onChange={(value) => { facing.value = value; }} /></label>
          {facing.value === "declared" && (
            <span class="headings" role="group" aria-label="Heading in each measure, in degrees">
              {turned.slice(0, 16).map((degrees, index) => (
                <input key={index} type="number" step="15" value={degrees} aria-label={`Heading in measure ${index + 1}`} onChange={(event) => { headings.value = turned.map((one, at) => (at === index ? Number(event.currentTarget.value) || 0 : one)); }} />
              ))}
            </span>
          )}
          <span class="hint" />
          <button disabled={!own || Boolean(own.refused)} onClick={() => { linking.value = true; }}>Link by hand …</button>
          <button onClick={onClose}>Cancel</button>
          <button class="primary" disabled={!own || Boolean(own.refused)} onClick={() => void save(null)}>{gap.free ? "Fill the gap" : "Take these ways"}</button>
        </footer>
      )}
    </Dialog>
  );
}

function OptionCard({ studio, dancers, figures, words, more, chosen, onChoose }: { studio: Studio; dancers: number[]; figures: OptionFigures; words: string; more: string; chosen: boolean; onChoose: () => void }) {
  const meet = figures.meetings?.length ?? 0;
  const far = new Set(figures.too_far?.map((one) => one.dancer)).size;
  return (
    <label class={chosen ? "option chosen" : "option"}>
      {figures.refused
        ? <p class="hint">{figures.refused[0]?.what}</p>
        : <WayPicture studio={studio} dancers={dancers} figures={figures} label={`${words}: ${dancers.length} dancers go ${figures.total_m.toFixed(1)} m in all`} />}
      <span class="name"><input type="radio" name="match" checked={chosen} onChange={onChoose} /> <b>{words}</b> <small>{more}</small></span>
      {!figures.refused && (
        <span class="figures">
          <span>in all {figures.total_m.toFixed(1)} m</span>
          <span>longest {figures.longest_m.toFixed(1)} m</span>
          <span class={meet ? "alarm" : ""}>{meet ? `${meet} ${meet === 1 ? "meeting" : "meetings"}` : "nobody meets"}</span>
          {far > 0 && <span class="alarm">{far} too far</span>}
        </span>
      )}
    </label>
  );
}

function Choice({ value, options, onChange }: { value: string; options: [string, string][]; onChange: (value: string) => void }) {
  return <select value={value} onChange={(event) => onChange(event.currentTarget.value)}>{options.map(([name, words]) => <option key={name} value={name}>{words}</option>)}</select>;
}

function format(measure: number): string {
  return String(Math.round(measure * 100) / 100);
}
