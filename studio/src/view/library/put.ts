// Putting something of the library into the show: at the cursor, for the dancers who are selected.
import type { Studio } from "../../model/studio";
import type { Entry } from "../../model/score";
import { DRAGGED, dragging, putEntry } from "../timeline/timeline";

export interface Item {
  list: string;
  value: Entry;
}

/** The rows that show what is put. */
function showRows(studio: Studio, item: Item): void {
  studio.mode.value = item.list === "sequence" ? "steps" : "motion";
}

export function drag(studio: Studio, event: DragEvent, item: Item): void {
  dragging.now = item;
  event.dataTransfer?.setData(DRAGGED, JSON.stringify(item));
  if (event.dataTransfer) event.dataTransfer.effectAllowed = "copy";
  setTimeout(() => showRows(studio, item)); // browsers end a drag whose page changes as it begins
}

export async function putAtCursor(studio: Studio, item: Item): Promise<void> {
  showRows(studio, item);
  await putEntry(studio, item);
}

/** Keys of an entry in the library: Enter puts it at the cursor; a click, or the space bar, opens it. */
export function onEnter(put: () => void): (event: KeyboardEvent) => void {
  return (event) => {
    if (event.key !== "Enter") return;
    event.preventDefault();
    put();
  };
}
