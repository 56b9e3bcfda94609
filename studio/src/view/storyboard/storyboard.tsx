import { useSignal } from "@preact/signals";
import { useCallback, useEffect } from "preact/hooks";
import { sceneBox, sceneStart, sheetsFile, type Paper, type SheetScene, type Sheets } from "../../model/sheets";
import type { Studio } from "../../model/studio";
import { PageOfSheet } from "./sheet_page";
import "./storyboard.css";

const PAPERS: [Paper, string][] = [["a4", "A4"], ["letter", "Letter"]];

/** The show on paper, as `live sheets` prints it: the storyboard, or the sheets of a dancer. */
export function Storyboard({ studio }: { studio: Studio }) {
  const sheets = useSignal<Sheets | null>(null);
  const problem = useSignal("");
  const works = useSignal(false);
  const dancer = useSignal<number | null>(null);
  const paper = useSignal<Paper>(navigator.language.endsWith("-US") ? "letter" : "a4");
  const printing = useSignal(false);
  const revision = studio.doc.revision.value;
  const isThere = studio.doc.structure.value !== null;
  const name = String(studio.score.value["name"] ?? "");

  useEffect(() => {
    if (!isThere) return;
    let wanted = true;
    works.value = true;
    const whose = dancer.value === null ? {} : { dancer: dancer.value };
    void studio.preview.ask({ sheets: paper.value, ...whose }, "sheets", true).then((answer) => {
      if (!wanted || answer.replaced) return;
      works.value = false;
      problem.value = faultWords(answer.refused);
      if (answer.texts["sheets"]) sheets.value = answer.texts["sheets"] as unknown as Sheets;
    });
    return () => { wanted = false; };
  }, [isThere, revision, dancer.value, paper.value]);

  const look = useCallback((scene: SheetScene): void => {
    const structure = studio.doc.structure.peek();
    if (!structure) return;
    const start = sceneStart(structure, scene);
    const box = sceneBox(structure, scene);
    studio.view.value = "make";
    studio.mode.value = "motion";
    if (start >= 0) studio.cursor.value = start;
    studio.select(box);
  }, [studio]);

  const savePdf = async (): Promise<void> => {
    printing.value = true;
    const answer = await studio.preview.ask({ sheets: paper.value, pdf: true }, "sheets as PDF");
    printing.value = false;
    if (answer.document) save(answer.document, sheetsFile(name));
    else if (!answer.replaced) studio.doc.tell("refused", "The sheets cannot be drawn", answer.refused ?? []);
  };

  const found = sheets.value;
  return (
    <main class="storyboard">
      <header class="strip">
        <h2>Storyboard</h2>
        <label class="field">
          Pages
          <select value={String(dancer.value ?? "")} onChange={(event) => { dancer.value = event.currentTarget.value === "" ? null : Number(event.currentTarget.value); }}>
            <option value="">storyboard</option>
            {(found?.dancers ?? []).map((one) => <option key={one} value={String(one)}>dancer {one}</option>)}
          </select>
        </label>
        <label class="field">
          Paper
          <select value={paper.value} onChange={(event) => { paper.value = event.currentTarget.value as Paper; }}>
            {PAPERS.map(([value, words]) => <option key={value} value={value}>{words}</option>)}
          </select>
        </label>
        <button disabled={!found} onClick={() => print()}>Print</button>
        <button disabled={printing.value} title="Storyboard and the sheets of all dancers" onClick={() => void savePdf()}>{printing.value ? "Drawing …" : "PDF of all sheets"}</button>
        <span class="hint" role="status">{problem.value || statusText(found, works.value || printing.value, studio.preview.progress.value)}</span>
      </header>
      <div class={`pages paper-${found?.paper ?? paper.value}`}>
        {found?.pages.map((page, index) => (
          <PageOfSheet
            key={index} page={page} scenes={found.scenes} look={look}
            label={`${found.dancer === null ? "Storyboard" : `Dancer ${found.dancer}`}, page ${index + 1} of ${found.pages.length}`}
          />
        ))}
      </div>
    </main>
  );
}

function faultWords(faults: { what: string; remedy?: string }[] | null): string {
  return (faults ?? []).map((one) => `${one.what}${one.remedy ? ` – ${one.remedy}` : ""}`).join("; ");
}

function statusText(found: Sheets | null, works: boolean, progress: number | null): string {
  const old = found && works ? "; below as it was" : "";
  if (works) return progress ? `The show is simulated: ${progress} ${progress === 1 ? "measure" : "measures"} so far${old}` : `The pages come in a moment …${old}`;
  if (!found) return "";
  return `${count(found.scenes.length, "scene")} on ${count(found.pages.length, "page")}`;
}

function count(many: number, word: string): string {
  return `${many} ${word}${many === 1 ? "" : "s"}`;
}

function save(file: Blob, name: string): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(file);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
