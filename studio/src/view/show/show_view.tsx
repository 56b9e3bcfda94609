import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { Control } from "../../ui/controls";
import type { Studio } from "../../model/studio";
import type { Widget } from "../../net/values";
import { GoPage } from "./go_page";
import { JoinLink } from "./join_link";
import { Health } from "./health";
import { Projected } from "./projected";
import { VoteForm } from "./vote_form";
import { StageView } from "../stage/stage_view";
import "./show.css";

const ROLES = ["Go", "Stage", "Light", "Clock", "Phones", "Everything"] as const;
type Role = (typeof ROLES)[number];
const STORED = "live.studio.role";

/** Which parts of the control surface a role sees, with their headings. */
const PARTS: Record<string, [string, RegExp][]> = {
  Stage: [["Move them", /^\/dance\/(spread|wander|flock|pause|release|enter|clear)$/], ["Where", /^\/dance\/(attract|repel|flow\/radial|flow\/vortex)$/], ["How they move", /^\/dance\/motion\//]],
  Light: [["Light", /^\/dance\/light\//], ["Spots", /^\/dance\/spot\//], ["Background", /^\/dance\/background\//], ["Drawing", /^\/dance\/draw\//], ["Camera", /^\/dance\/camera\//], ["Picture", /^\/dance\/(pass|output)\//]],
  Phones: [["What phones may do", /^\/dance\/audience\/(open|close|mute|gain|shake)$/], ["Projectors", /^\/dance\/audience\/(qr|tally)$/]],
  Clock: [["Beat", /^\/dance\/clock\//], ["Sound and delays", /^\/dance\/(audio|latency)\//]],
};

/** Pages for running a show, each for a role. */
export function ShowView({ studio }: { studio: Studio }) {
  const role = useSignal<Role>((localStorage.getItem(STORED) as Role | null) ?? "Go");
  useEffect(() => localStorage.setItem(STORED, role.value), [role.value]);
  return (
    <main class="show">
      <nav class="choice roles" aria-label="Roles">
        {ROLES.map((name) => <button key={name} aria-pressed={role.value === name} onClick={() => { role.value = name; }}>{name}</button>)}
        <Health studio={studio} />
      </nav>
      {role.value === "Go" && <GoPage studio={studio} />}
      {role.value === "Stage" && <StageView studio={studio} />}
      {role.value === "Light" && <Projected studio={studio} />}
      {role.value === "Phones" && <><JoinLink studio={studio} /><VoteForm studio={studio} /></>}
      {role.value === "Everything" ? <Everything studio={studio} /> : role.value !== "Go" && <Parts studio={studio} parts={PARTS[role.value] ?? []} />}
    </main>
  );
}

function widgetsOf(studio: Studio): Widget[] {
  return studio.values.surface.value?.pages.flatMap((page) => page.widgets) ?? [];
}

function Parts({ studio, parts }: { studio: Studio; parts: [string, RegExp][] }) {
  const all = widgetsOf(studio);
  return (
    <div class="parts">
      {parts.map(([title, address]) => {
        const widgets = all.filter((widget) => address.test(widget.address));
        return widgets.length ? <Part key={title} studio={studio} title={title} widgets={widgets} /> : null;
      })}
    </div>
  );
}

function Part({ studio, title, widgets }: { studio: Studio; title: string; widgets: Widget[] }) {
  return (
    <section aria-label={title}>
      <h2>{title}</h2>
      <div class="controls">
        {widgets.map((widget, index) => <Control key={`${widget.address} ${index}`} values={studio.values} widget={widget} />)}
      </div>
    </section>
  );
}

function Everything({ studio }: { studio: Studio }) {
  const wanted = useSignal("");
  const words = wanted.value.toLowerCase().split(/\s+/).filter(Boolean);
  const fits = (widget: Widget): boolean => words.every((word) => `${widget.address} ${widget.label} ${widget.words}`.toLowerCase().includes(word));
  const pages = studio.values.surface.value?.pages ?? [];
  return (
    <div class="parts">
      <input type="search" placeholder="Find a control" aria-label="Find a control" value={wanted.value} onInput={(event) => { wanted.value = event.currentTarget.value; }} />
      {pages.map((page) => {
        const widgets = page.widgets.filter(fits);
        return widgets.length ? <Part key={page.title} studio={studio} title={page.title} widgets={widgets} /> : null;
      })}
    </div>
  );
}
