import { useEffect } from "preact/hooks";
import type { Studio } from "../model/studio";
import { listen } from "../ui/keys";
import { Header } from "./header";
import { Inspector } from "./inspector/inspector";
import { Library } from "./library/library";
import { Notices } from "./notices";
import { PlayView } from "./play/play_view";
import { ShowView } from "./show/show_view";
import { StageView } from "./stage/stage_view";
import { Storyboard } from "./storyboard/storyboard";
import { Timeline } from "./timeline/timeline";

/** The whole page: a header, and one of the views below it. */
export function App({ studio }: { studio: Studio }) {
  useEffect(() => listen(studio), [studio]);
  const view = studio.view.value;
  return (
    <>
      <Header studio={studio} />
      {view === "make" && (
        <main class="make">
          <Library studio={studio} />
          <StageView studio={studio} />
          <Inspector studio={studio} />
          <Timeline studio={studio} />
        </main>
      )}
      {view === "storyboard" && <Storyboard studio={studio} />}
      {view === "play" && <PlayView studio={studio} />}
      {view === "show" && <ShowView studio={studio} />}
      <Notices doc={studio.doc} />
    </>
  );
}
