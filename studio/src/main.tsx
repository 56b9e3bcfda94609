import { render } from "preact";
import { App } from "./view/app";
import { Door } from "./view/door";
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

async function isRight(key: string): Promise<boolean> {
  if (!key) return false;
  const answer = await fetch("/surface.json", { headers: { Authorization: `Bearer ${key}` } }).catch(() => null);
  return answer?.ok === true;
}

function enter(key: string): void {
  const name = localStorage.getItem(NAME) || `guest ${Math.floor(Math.random() * 90) + 10}`;
  localStorage.setItem(NAME, name);
  const studio = new Studio(key, name);
  studio.open();
  render(<App studio={studio} />, place);
  (window as unknown as { studio: Studio }).studio = studio;
}

const place = document.getElementById("app") as HTMLElement;
const key = storedKey();
if (await isRight(key)) enter(key);
else {
  render(
    <Door
      wrong={key !== ""}
      onKey={async (tried) => {
        const found = tried.includes("#") ? tried.slice(tried.lastIndexOf("#") + 1).replace(/^key=/, "") : tried.trim();
        if (!(await isRight(found))) return false;
        localStorage.setItem(KEY, found);
        enter(found);
        return true;
      }}
    />,
    place,
  );
}
