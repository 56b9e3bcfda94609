// What the theme leaves out for those who read by keyboard or by ear, and films that play while they are seen.
document.addEventListener("DOMContentLoaded", () => {
  for (const caption of document.querySelectorAll("p.caption[role=heading]")) caption.setAttribute("aria-level", "2");
  document.querySelector("aside.sidebar-drawer")?.setAttribute("aria-label", "Pages");
  document.querySelector("aside.toc-drawer")?.setAttribute("aria-label", "On this page");
  for (const block of document.querySelectorAll("pre, .table-wrapper")) {
    if (block.scrollWidth > block.clientWidth) block.tabIndex = 0;
  }
  if (!matchMedia("(prefers-reduced-motion: reduce)").matches) {
    const seen = new IntersectionObserver((films) => {
      for (const { target, isIntersecting } of films) isIntersecting ? target.play().catch(() => {}) : target.pause();
    });
    for (const film of document.querySelectorAll("figure.film video")) seen.observe(film);
  }
  if (!document.querySelector("h1")) {
    const title = document.createElement("h1");
    title.textContent = document.title.split(" - ")[0];
    document.querySelector("#furo-main-content, [role=main]")?.prepend(title);
  }
});
