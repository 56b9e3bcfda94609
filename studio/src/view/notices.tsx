import type { ShowDocument } from "../model/document";

/** What was refused, and why: it stays until it is closed. */
export function Notices({ doc }: { doc: ShowDocument }) {
  return (
    <div class="notices" role="log" aria-live="polite" aria-label="Messages">
      {doc.notices.value.map((notice) => (
        <section key={notice.id} class={`notice ${notice.tone}`}>
          <header>
            <strong>{notice.title}</strong>
            <button class="plain" aria-label="Close this message" onClick={() => doc.dismiss(notice.id)}>×</button>
          </header>
          {notice.faults.slice(0, 5).map((fault, index) => (
            <p key={index}>
              {fault.measure ? <b>Measure {fault.measure}: </b> : null}
              {fault.what}
              {fault.remedy ? <em> – {fault.remedy}</em> : null}
            </p>
          ))}
          {notice.faults.length > 5 && <p>and {notice.faults.length - 5} more</p>}
        </section>
      ))}
    </div>
  );
}
