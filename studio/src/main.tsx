import { render } from "preact";
import { App } from "./view/app";
import { Door } from "./view/door";
import type { LabelFacts } from "./model/labels";
import { LabelPage } from "./view/label/label_page";
import { StartPage, type StartFacts } from "./view/start/start_page";
import { Studio } from "./model/studio";
import "./style.css";

const KEY = "live.operator.key";
const NAME = "live.studio.name";

function storedKey(): string {
  const brought = new URLSearchParams(location.hash.slice(1)).get("key") ?? (location.hash.length > 16 ? location.hash.slice(1) : "");
  if (brought) {
    history.replaceState(null, "", location.pathname);
    localStorage.setItem(KEY, brought);
  }
  return brought || localStorage.getItem(KEY) || "";
}

/** What runs here without a show: what one can be begun from, or couples whose patterns are labelled. */
interface Facts {
  start?: StartFacts;
  label?: LabelFacts;
}

/** What runs here for a key; null: the key is wrong. */
async function askWhat(key: string): Promise<Facts | null> {
  if (!key) return null;
  const answer = await fetch("/surface.json", { headers: { Authorization: `Bearer ${key}` } }).catch(() => null);
  return answer?.ok ? ((await answer.json()) as Facts) : null;
}

async function enter(key: string, what: Facts): Promise<void> {
  if (what.label) {
    render(<LabelPage secret={key} facts={what.label} />, place);
    return;
  }
  if (what.start) {
    render(<StartPage secret={key} facts={what.start} isShow={async () => { const now = await askWhat(key); return now !== null && !now.start; }} />, place);
    return;
  }
  const name = localStorage.getItem(NAME) || `guest ${Math.floor(Math.random() * 90) + 10}`;
  localStorage.setItem(NAME, name);
  const studio = new Studio(key, name);
  studio.open();
  render(<App studio={studio} />, place);
  (window as unknown as { studio: Studio }).studio = studio;
}

const place = document.getElementById("app") as HTMLElement;
const key = storedKey();
const what = await askWhat(key);
if (what) await enter(key, what);
else {
  render(
    <Door
      wrong={key !== ""}
      onKey={async (tried) => {
        const found = tried.includes("#") ? tried.slice(tried.lastIndexOf("#") + 1).replace(/^key=/, "") : tried.trim();
        const there = await askWhat(found);
        if (!there) return false;
        localStorage.setItem(KEY, found);
        await enter(found, there);
        return true;
      }}
    />,
    place,
  );
}
