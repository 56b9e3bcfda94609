import { useSignal } from "@preact/signals";
import { dancersOf, freeName, usesOf, WORDS } from "../../model/formations";
import { entries, text, type Entry } from "../../model/score";
import type { Studio } from "../../model/studio";
import { FormationEditor } from "./formation_editor";
import { FormationPicture, usePlaces } from "./formation_picture";
import { drag, onEnter, putAtCursor } from "./put";

/** The formations of the show, and shapes that need no name. A click opens one, Enter puts it at the cursor. */
export function FormationsPanel({ studio, wanted }: { studio: Studio; wanted: string }) {
  const group = useSignal("");
  const editing = useSignal<{ number: number; table: Entry } | null>(null);
  const dancers = dancersOf(studio.doc.structure.value, group.value);
  const folded = wanted.toLowerCase();
  const own = entries(studio.score.value, "formation").map((table, index) => ({ table, number: index + 1, name: text(table, "name") }));
  const found = own.filter((one) => one.name.toLowerCase().includes(folded));
  const evolutions = entries(studio.score.value, "evolution").map((table) => text(table, "name")).filter((name) => name.toLowerCase().includes(folded));
  const names = own.map((one) => one.name.toLowerCase());
  const words = WORDS.filter((name) => name.includes(folded) && !names.includes(name));
  return (
    <>
      <div class="tools">
        <label class="field">for
          <select value={group.value} aria-label="How many dancers the pictures show" onChange={(event) => { group.value = event.currentTarget.value; }}>
            <option value="">all ({dancersOf(studio.doc.structure.value, "")})</option>
            {studio.doc.structure.value?.groups.map((one) => <option key={one.name} value={one.name}>{one.name} ({one.dancers})</option>)}
          </select>
        </label>
        <button onClick={() => { editing.value = { number: 0, table: { name: freeName(studio.score.value, "formation 1"), shape: "circle", size: [5, 4] } }; }}>New …</button>
      </div>
      <div class="scroll">
        {found.length > 0 && <h2>Of this show</h2>}
        <ul class="pictures" aria-label="Formations of this show">
          {found.map((one) => (
            <OwnFormation key={one.number} studio={studio} name={one.name} number={one.number} dancers={dancers} onEdit={() => { editing.value = { number: one.number, table: one.table }; }} />
          ))}
        </ul>
        {evolutions.length > 0 && <h2>Ways of this show</h2>}
        <ul class="evolutions" aria-label="Ways of this show">
          {evolutions.map((name) => <Evolution key={name} studio={studio} name={name} />)}
        </ul>
        {words.length > 0 && <h2>Shapes</h2>}
        <ul class="pictures" aria-label="Shapes">
          {words.map((name) => <Shape key={name} studio={studio} name={name} dancers={dancers} />)}
        </ul>
        {!found.length && !words.length && !evolutions.length && <p class="hint none">No formation is called so.</p>}
      </div>
      {editing.value && (
        <FormationEditor studio={studio} number={editing.value.number} table={editing.value.table} dancers={dancers} onClose={() => { editing.value = null; }} />
      )}
    </>
  );
}

function itemOf(name: string): { list: string; value: Entry } {
  return { list: "segment", value: { formation: name, measures: 4 } };
}

function OwnFormation({ studio, name, number, dancers, onEdit }: { studio: Studio; name: string; number: number; dancers: number; onEdit: () => void }) {
  const places = usePlaces(studio, name, dancers);
  const uses = usesOf(studio.score.value, name);
  const count = uses.segments.length + uses.groups.length;
  return (
    <li>
      <button
        class="picture"
        draggable
        title={`Drag it onto a row, or onto a region of the stage: it bends. Click: edit it. Enter: put it at the cursor${places && !places.fits ? `\nIt does not fit the stage: ${places.remedy}` : ""}`}
        onDragStart={(event) => drag(studio, event, itemOf(name))}
        onKeyDown={onEnter(() => void putAtCursor(studio, itemOf(name)))}
        onClick={onEdit}
      >
        <FormationPicture studio={studio} places={places} />
        <b>{name}</b>
        {places && !places.fits && <small class="alarm">off the stage</small>}
      </button>
      <div class="under">
        <button
          class="plain uses"
          disabled={!count}
          title={uses.groups.length ? `${uses.groups.join(", ")} begin with it` : "Select where it is used"}
          onClick={() => {
            studio.mode.value = "motion";
            studio.selected.value = uses.segments.map((segment) => ({ list: "segment", number: segment }));
          }}
        >
          {count ? (count === 1 ? "1 use" : `${count} uses`) : "not used"}
        </button>
        <button class="plain" aria-label={`Put ${name} at the cursor`} title="Put it at the cursor" onClick={() => void putAtCursor(studio, itemOf(name))}><Icon path="M8 3v10M3 8h10" /></button>
        <button class="plain" aria-label={`Duplicate ${name}`} title="Duplicate" onClick={() => void studio.doc.edit({ do: "copy", at: ["formation", number], value: freeName(studio.score.value, `${name} 2`) })}><Icon path="M5.5 5.5h7v7h-7zM3.5 10.5v-7h7" /></button>
        <button class="plain" aria-label={`Delete ${name}`} title={count ? "It is used: delete or change its boxes first" : "Delete"} disabled={count > 0} onClick={() => void studio.doc.edit({ do: "delete", at: ["formation", number] })}><Icon path="M4 4l8 8M12 4l-8 8" /></button>
      </div>
    </li>
  );
}

/** Ways that are kept as an evolution. */
function Evolution({ studio, name }: { studio: Studio; name: string }) {
  const item = { list: "segment", value: { evolution: name, measures: 4 } };
  return (
    <li>
      <button
        class="plainrow" draggable title="Drag it onto a row, or onto a region of the stage. Enter or a click: it is put at the cursor"
        onDragStart={(event) => drag(studio, event, item)} onKeyDown={onEnter(() => void putAtCursor(studio, item))} onClick={() => void putAtCursor(studio, item)}
      >
        <b>{name}</b>
        <small>ways</small>
      </button>
    </li>
  );
}

function Shape({ studio, name, dancers }: { studio: Studio; name: string; dancers: number }) {
  const places = usePlaces(studio, name, dancers);
  const item = itemOf(name);
  return (
    <li>
      <button class="picture" draggable title="Drag it onto a row, or click: it is put at the cursor" onDragStart={(event) => drag(studio, event, item)} onKeyDown={onEnter(() => void putAtCursor(studio, item))} onClick={() => void putAtCursor(studio, item)}>
        <FormationPicture studio={studio} places={places} />
        <b>{name}</b>
      </button>
    </li>
  );
}

function Icon({ path }: { path: string }) {
  return <svg class="icon" viewBox="0 0 16 16" aria-hidden="true"><path d={path} /></svg>;
}
