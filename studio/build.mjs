// Builds the page into live/control/web/studio, where the engine serves it. `--check`: compares the bytes instead.
// `--tests`: builds the tests into out/.
import { build } from "esbuild";
import { copyFile, mkdtemp, readFile, readdir, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const page = join(here, "..", "live", "control", "web", "studio");
const shared = { bundle: true, format: "esm", target: "es2022", jsx: "automatic", jsxImportSource: "preact", logLevel: "warning" };

async function makePage(folder) {
  await build({
    ...shared,
    absWorkingDir: here,
    entryPoints: { app: "src/main.tsx", stage3d: "src/view/stage/stage3d.ts" },
    outdir: folder,
    entryNames: "[name]",
    chunkNames: "[name]",
    splitting: false,
    minify: true,
    legalComments: "eof",
    external: ["./stage3d.js"],
  });
  await copyFile(join(here, "src", "index.html"), join(folder, "index.html"));
}

if (process.argv.includes("--tests")) {
  const tests = (await readdir(join(here, "test"))).filter((name) => name.endsWith(".test.ts"));
  await build({ ...shared, absWorkingDir: here, entryPoints: tests.map((name) => join("test", name)), outdir: "out", platform: "node" });
} else if (process.argv.includes("--check")) {
  const folder = await mkdtemp(join(tmpdir(), "studio-"));
  await makePage(folder);
  const [made, kept] = await Promise.all([readdir(folder), readdir(page)]);
  const differ = [];
  for (const name of new Set([...made, ...kept])) {
    const [one, other] = await Promise.all([folder, page].map((place) => readFile(join(place, name)).catch(() => null)));
    if (!one || !other || !one.equals(other)) differ.push(name);
  }
  await rm(folder, { recursive: true });
  if (differ.length) {
    console.error(`live/control/web/studio is not what studio/src makes (${differ.join(", ")}): run make studio`);
    process.exit(1);
  }
} else {
  await makePage(page);
}
