// A group's motion that is dragged onto a region or a line: what it becomes there is shown at once, and kept when it is dropped.
import { signal } from "@preact/signals";
import { reached } from "./danced";
import type { Places } from "./formations";
import type { Place } from "./geometry";
import { bendEdits, bentTable, dancersIn, drawnGround, groundAt, groundWords, namedGround, triedEdits, type Ground, type Material, type Put } from "./material";
import { entries, text } from "./score";
import type { StageState } from "./stage_state";

const MOST_GROUNDS = 32;
const MOST_DANCERS = 400;
const NEW_MEASURES = 4;

export class Bending {
  /** What is dragged; null: nothing. */
  readonly held = signal<Material | null>(null);
  /** Where it can be dropped. */
  readonly grounds = signal<Ground[]>([]);
  /** Where it would be dropped now. */
  readonly target = signal<Ground | null>(null);
  /** The place of the floor over which it is held. */
  private place: Place | null = null;
  private asked = 0;
  private shown = "";

  constructor(private readonly stage: StageState) {}

  /** Take something up: regions and lines of the show appear, and a line that is drawn just now. */
  async begin(material: Material): Promise<void> {
    this.held.value = material;
    this.target.value = null;
    this.place = null;
    this.shown = "";
    const stroke = this.stage.stroke.value;
    const drawn = stroke ? [drawnGround(stroke.points, stroke.closed)] : [];
    this.grounds.value = drawn;
    const { studio } = this.stage;
    const names = entries(studio.score.value, "formation").filter((one) => one["like"] === undefined).map((one) => text(one, "name"));
    const others = names.filter((name) => name.toLowerCase() !== material.name.toLowerCase()).slice(0, MOST_GROUNDS);
    const places = await Promise.all(others.map((name) => studio.library.placesOf(name, this.count(material))));
    if (this.held.value !== material) return;
    this.grounds.value = [...drawn, ...others.flatMap((name, at) => namedGround(name, (places[at] as Places).lines) ?? [])];
    if (this.place) this.over(this.place);
  }

  /** It is held over a place of the floor. */
  over(place: Place): void {
    this.place = place;
    this.aim(groundAt(place, this.grounds.value));
  }

  /** The next ground, by keyboard; its words. */
  next(by: number): void {
    const all = this.grounds.value;
    if (!all.length) return;
    const at = this.target.value ? all.indexOf(this.target.value) : by > 0 ? -1 : 0;
    this.aim(all[(at + by + all.length) % all.length] ?? null);
  }

  private aim(ground: Ground | null): void {
    this.target.value = ground;
    if (this.held.value && ground) this.show(this.held.value, ground, this.put(this.held.value));
    else this.hide();
  }

  /** Show what it becomes on a ground: its places first, then the ways there. */
  show(material: Material, ground: Ground, put: Put): void {
    const { studio } = this.stage;
    const score = studio.score.value;
    const key = JSON.stringify([material, ground.kind, ground.to, put]);
    if (key === this.shown) return;
    this.shown = key;
    const asked = ++this.asked;
    const measures = this.measures(material, put);
    if (material.list === "evolution") {
      this.stage.drag(bendEdits(score, material, ground, put), measures);
      return;
    }
    const wish = { formation: bentTable(score, material, ground), dancers: this.count(material, put.group) };
    void studio.preview.ask({ places: [wish] }, "bend", true).then((answer) => {
      if (answer.replaced || asked !== this.asked) return;
      const found = (answer.texts["places"]?.["places"] as Places[] | undefined)?.[0];
      const room = found?.waiting ? found.warnings.filter((words) => words.includes("room")).map((what) => ({ what })) : [];
      this.stage.refusal.value = [...(answer.refused ?? []), ...(found?.refused ?? []), ...room];
      this.stage.thought.value = found?.slots ?? [];
      this.stage.endDrag();
      if (found && !this.stage.refusal.value.length) this.stage.drag(triedEdits(score, material, found.slots, put), measures);
    });
  }

  private hide(): void {
    this.asked++;
    this.shown = "";
    this.stage.refusal.value = [];
    this.stage.thought.value = [];
    this.stage.endDrag();
  }

  /** Let it go: kept where it is held, by one edit. */
  async drop(): Promise<void> {
    const { held, target } = this;
    const [material, ground] = [held.value, target.value];
    this.cancel();
    if (!material || !ground) return;
    const { studio } = this.stage;
    const taken = await this.stage.send(bendEdits(studio.score.value, material, ground, this.put(material)));
    if (!taken) return;
    if (typeof ground.to !== "string") this.stage.stroke.value = null;
    studio.doc.tell("told", `${material.name} goes ${groundWords(ground)}`);
    const segments = entries(studio.score.value, "segment").length;
    studio.select({ list: "segment", number: material.segment || segments });
  }

  cancel(): void {
    this.held.value = null;
    this.target.value = null;
    this.grounds.value = [];
    this.hide();
  }

  /** How many dance it. */
  private count(material: Material, group = this.put(material).group): number {
    const { studio, segmentAnswer } = this.stage;
    const groups = studio.doc.structure.value?.groups ?? [];
    const told = material.segment ? (segmentAnswer.value?.texts["ways"]?.["dancers"] as number[] | undefined) : undefined; // also those who wait in the wings
    const found = (dancersIn(groups, group) ?? told ?? dancersIn(groups, "*") ?? []).length;
    return Math.min(Math.max(found, 1), MOST_DANCERS);
  }

  private put(material: Material): Put {
    const { studio } = this.stage;
    const entry = material.segment ? studio.entry({ list: "segment", number: material.segment }) : undefined;
    return { start: this.stage.here(), measures: NEW_MEASURES, group: entry ? text(entry, "group", "*") : studio.whom.value };
  }

  private measures(material: Material, put: Put): ReturnType<typeof reached> {
    const own = material.segment ? this.stage.measuresOf("segment", material.segment) : null;
    return own ?? reached(this.stage.studio.score.value, put.start, put.measures);
  }
}
