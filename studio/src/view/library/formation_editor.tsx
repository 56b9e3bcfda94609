import { useSignal } from "@preact/signals";
import { formationEdits, freeName, usesOf } from "../../model/formations";
import { text, type Entry } from "../../model/score";
import type { Studio } from "../../model/studio";
import { Dialog } from "../../ui/dialog";
import { DrawingBoard } from "./drawing_board";
import { FormationFields } from "./formation_fields";
import { usePlaces } from "./formation_picture";

/** One formation: drawn or with numbers, seen as it is edited, and saved by one edit. Every use of it changes. */
export function FormationEditor({ studio, number, table, dancers, onClose }: { studio: Studio; number: number; table: Entry; dancers: number; onClose: () => void }) {
  const draft = useSignal<Entry>(table);
  const count = useSignal(dancers);
  const saving = useSignal(false);
  const { name: _, ...unnamed } = draft.value;
  const places = usePlaces(studio, unnamed, count.value);
  const uses = usesOf(studio.score.value, text(table, "name"));
  const used = number ? uses.segments.length + uses.groups.length : 0;
  const name = text(draft.value, "name").trim();
  const edits = formationEdits(studio.score.value, number, { ...draft.value, name });
  const change = (changed: Entry): void => {
    draft.value = Object.fromEntries(Object.entries(changed).filter(([, value]) => value !== undefined));
  };
  const save = async (): Promise<void> => {
    saving.value = true;
    const answer = await studio.doc.edits(edits);
    saving.value = false;
    if (!answer.refused) onClose();
  };
  const fault = places?.refused?.[0];
  return (
    <Dialog wide title={number ? `Formation ${text(table, "name")}` : "New formation"} more={used > 1 ? `${used} uses: all change` : used ? "1 use: it changes as well" : ""} onClose={onClose}>
      <div class="body editor">
        <div class="boardside">
          <DrawingBoard studio={studio} table={draft.value} places={places} onChange={change} />
          <div class="told" role="status">
            {fault ? <p class="alarm">{fault.what}{fault.remedy ? ` – ${fault.remedy}` : ""}</p> : places && <Told places={places} table={draft.value} onChange={change} />}
          </div>
        </div>
        <div class="fieldside">
          <FormationFields table={draft.value} onChange={change} />
          <label class="field">Shown for
            <input type="number" min="1" max="400" value={count.value} aria-label="Shown for so many dancers" onChange={(event) => { count.value = Math.min(400, Math.max(1, Number(event.currentTarget.value) || 1)); }} />
          </label>
        </div>
      </div>
      <footer>
        <span class="hint">{studio.doc.link.state.value === "open" ? "" : "No connection: it is saved when it is there again"}</span>
        <button onClick={onClose}>Cancel</button>
        {number > 0 && (
          <button disabled={saving.value || Boolean(fault)} onClick={() => void studio.doc.edit({ do: "insert", at: ["formation"], value: { ...draft.value, name: freeName(studio.score.value, name) } }).then((answer) => { if (!answer.refused) onClose(); })}>
            Save as another one
          </button>
        )}
        <button class="primary" disabled={saving.value || !name || Boolean(fault) || !edits.length} onClick={() => void save()}>Save</button>
      </footer>
    </Dialog>
  );
}

function Told({ places, table, onChange }: { places: NonNullable<ReturnType<typeof usePlaces>>; table: Entry; onChange: (table: Entry) => void }) {
  const drawn = table["points"] !== undefined && table["size"] === undefined;
  return (
    <>
      <p>
        {places.slots.length} places
        {places.least_m !== null ? `, the nearest two ${places.least_m.toFixed(2)} m apart` : ""}
        {places.fits ? "" : <span class="alarm">. Off the stage: {places.remedy}</span>}
      </p>
      {places.warnings.map((words) => <p key={words} class="hint">{words}</p>)}
      {!places.fits && !drawn && (
        <button
          onClick={() => {
            const [w, d] = (table["size"] as [number, number] | undefined) ?? [8, 5];
            const [x, z] = (table["centre"] as [number, number] | undefined) ?? [0, 0];
            const round = (value: number): number => Math.floor(value * 100) / 100;
            onChange({ ...table, size: [round(w * places.scale), round(d * places.scale)], centre: [round(x + places.move[0]), round(z + places.move[1])] });
          }}
        >
          Make it fit the stage
        </button>
      )}
    </>
  );
}
