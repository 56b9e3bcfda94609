// What one person sees and does in this page: the show, what is selected, and where the timeline stands.
import { computed, effect, signal } from "@preact/signals";
import { Preview, type PreviewAnswer } from "../net/preview";
import { Values } from "../net/values";
import { Library } from "./library";
import { ShowDocument, type Edit, type SingleEdit } from "./document";
import { groundOf, type Copied, type Snap } from "./arrange";
import { allBoxes, beatsPerMeasure, grown, hasEnd, planRows, scoreLength, sectionSpans, type Box, type Mode } from "./plan";
import { numbersInWords } from "./geometry";
import { entries, type Entry } from "./score";

export type View = "make" | "play" | "show" | "storyboard";
export type Panel = "steps" | "formations" | "elements" | "people";
export interface Selected {
  list: string;
  /** From 1. */
  number: number;
}

/** Selected entries, and dancers, that the others are told. */
const MOST_TOLD = 200;
const TELL_MS = 60;

export class Studio {
  readonly view = signal<View>("make");
  readonly panel = signal<Panel>("steps");
  readonly mode = signal<Mode>("motion");
  readonly snap = signal<Snap>("measure");
  readonly selected = signal<Selected[]>([]);
  /** Dancers that are selected on the stage, from 1. */
  readonly dancers = signal<number[]>([]);
  /** Pixels of a measure in the timeline. */
  readonly scale = signal(64);
  /** The measure of the written score (from 0) that is looked at; null: the one that is danced. */
  readonly cursor = signal<number | null>(null);
  /** The chosen measures of the written score, [first, last) from 0: for preview and loop; null: none. */
  readonly range = signal<[number, number] | null>(null);
  /** The row of the timeline into which things are put: its id. */
  readonly row = signal<string | null>(null);
  /** What Ctrl+C kept. */
  readonly clipboard = signal<Copied[]>([]);
  readonly preview: Preview;
  readonly values: Values;
  readonly doc: ShowDocument;
  readonly library: Library;
  /** Whether the ways of the selected segments are looked at, to choose from. */
  readonly choosing = signal(false);
  /** Whether the table of keys is looked at. */
  readonly helping = signal(false);

  readonly score = computed(() => this.doc.structure.value?.score ?? {});
  readonly boxes = computed(() => (this.doc.structure.value ? allBoxes(this.doc.structure.value) : []));
  /** What others have selected, "dancer 3" too: by key, who, and the name of their colour. */
  readonly lookedAt = computed(() => {
    const found = new Map<string, { name: string; colour: string }>();
    for (const person of this.doc.people.value) {
      if (person.name === this.by) continue;
      for (const [list, numbers] of Object.entries(person.selected)) {
        for (const number of numbers) found.set(`${list} ${number}`, { name: person.name, colour: personColour(person.name) });
      }
    }
    return found;
  });
  /** What the preview says of what is dragged, on the stage or in the timeline. */
  readonly dragAnswer = signal<PreviewAnswer | null>(null);
  private telling = 0;
  private readonly boxesByKey = computed(() => new Map(this.boxes.value.map((box) => [keyOf(box), box])));
  readonly selectedKeys = computed(() => new Set(this.selected.value.map(keyOf)));
  readonly rows = computed(() => (this.doc.structure.value ? planRows(this.doc.structure.value, this.mode.value) : []));
  readonly spans = computed(() => sectionSpans(this.score.value));
  private readonly written = computed(() => (this.doc.structure.value ? scoreLength(this.doc.structure.value) : 16));
  readonly length = computed(() => (hasEnd(this.score.value) ? this.written.value : grown(this.written.value, this.playhead.value)));
  readonly ground = computed(() => groundOf(this.score.value, this.doc.structure.value?.library ?? []));
  readonly beats = computed(() => beatsPerMeasure(this.score.value));
  /** Words of a selection for what is drawn or put: the chosen dancers, or everybody. */
  readonly whom = computed(() => {
    const chosen = this.dancers.value;
    if (!chosen.length) return "*";
    let at = 0;
    for (const group of this.doc.structure.value?.groups ?? []) {
      if (chosen.length === group.dancers && chosen[0] === at + 1 && chosen.at(-1) === at + group.dancers) return group.name;
      at += group.dancers;
    }
    return numbersInWords(chosen);
  });
  /** Where the show is danced now, in measures of the written score from 0; null before it begins. */
  readonly playhead = computed(() => {
    const clock = this.doc.clock.value;
    return clock && clock.measure >= 1 ? clock.score_measure - 1 + (clock.beat - 1) / this.beats.value : null;
  });

  constructor(readonly key: string, readonly by: string) {
    this.doc = new ShowDocument(key, by);
    this.preview = new Preview(key);
    this.values = new Values(key);
    this.library = new Library(this.preview, this.doc);
    effect(() => {
      const told: Record<string, number[]> = {};
      for (const one of this.selected.value.slice(0, MOST_TOLD)) (told[one.list] ??= []).push(one.number);
      if (this.dancers.value.length) told["dancer"] = this.dancers.value.slice(0, MOST_TOLD);
      clearTimeout(this.telling);
      this.telling = window.setTimeout(() => this.doc.want({ selected: told }), TELL_MS); // a marquee changes it often
    });
    effect(() => {
      // an entry that was selected may be another one after a change, or gone
      const change = this.doc.lastChange.value;
      if (change?.shifts.length) this.selected.value = this.selected.peek().flatMap((one) => shifted(one, change.shifts));
    });
  }

  open(): void {
    this.doc.link.open();
    this.values.link.open();
  }

  /** The entry of a selected one; undefined if it is gone. */
  entry(one: Selected): Entry | undefined {
    return entries(this.score.value, one.list)[one.number - 1];
  }

  box(one: Selected): Box | undefined {
    return this.boxesByKey.value.get(keyOf(one));
  }

  isSelected(box: Selected): boolean {
    return this.selectedKeys.value.has(keyOf(box));
  }

  select(one: Selected | null, more = false): void {
    if (!one) this.selected.value = [];
    else if (!more) this.selected.value = [{ list: one.list, number: one.number }];
    else if (this.isSelected(one)) this.selected.value = this.selected.value.filter((each) => each.list !== one.list || each.number !== one.number);
    else this.selected.value = [...this.selected.value, { list: one.list, number: one.number }];
  }

  /** Insert an entry and select it. */
  async insert(list: string, value: Entry): Promise<boolean> {
    const answer = await this.doc.edit({ do: "insert", at: [list], value });
    if (answer.refused) return false;
    this.select({ list, number: entries(this.score.peek(), list).length });
    return true;
  }

  async removeSelected(): Promise<void> {
    const chosen = [...this.selected.value].sort((a, b) => b.number - a.number);
    this.selected.value = [];
    await this.doc.edits(chosen.map((one): SingleEdit => ({ do: "delete", at: [one.list, one.number] })));
  }

  /** The boxes that are selected. */
  chosenBoxes(): Box[] {
    return this.selected.value.flatMap((one) => this.box(one) ?? []);
  }

  /** What edits would do, before they are sent. */
  try(edits: Edit[], from: number, to: number): Promise<PreviewAnswer> {
    return this.preview.ask({ from, to, with: edits, positions: "none", notes: true });
  }
}

const PERSON_COLOURS = 8;

/** The name of a person's colour in the style sheet, the same in all pages. */
export function personColour(name: string): string {
  let sum = 7;
  for (const letter of name) sum = (sum * 31 + (letter.codePointAt(0) ?? 0)) >>> 0;
  return `--person-${sum % PERSON_COLOURS}`;
}

export function keyOf(one: Selected): string {
  return `${one.list} ${one.number}`;
}

function shifted(one: Selected, shifts: { list: string; from: number | null; to: number | null }[]): Selected[] {
  let { number } = one;
  for (const { list, from, to } of shifts) {
    if (list !== one.list) continue;
    if (from === null) number += to !== null && to <= number ? 1 : 0;
    else if (to === null) {
      if (from === number) return [];
      number -= from < number ? 1 : 0;
    } else if (from === number) number = to;
    else number += (to <= number && number < from ? 1 : 0) - (from < number && number <= to ? 1 : 0);
  }
  return [{ list: one.list, number }];
}
