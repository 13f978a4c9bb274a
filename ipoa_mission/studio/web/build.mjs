// Makes the page: one script, one style sheet, MapLibre's worker beside them. `--watch` makes it again when it changes.
import { copyFile, mkdir, readFile, writeFile } from "node:fs/promises";
import * as esbuild from "esbuild";

const options = {
  entryPoints: { studio: "main.tsx" },
  outdir: "dist",
  bundle: true,
  format: "esm",
  target: "es2022",
  minify: true,
  legalComments: "linked",
  jsx: "automatic",
  jsxImportSource: "preact",
  logLevel: "warning",
};
await mkdir("dist", { recursive: true });
await copyFile("node_modules/maplibre-gl/dist/maplibre-gl-worker.mjs", "dist/map-worker.js");
await esbuild.build(options);
const licenses = ["maplibre-gl/LICENSE.txt", "preact/LICENSE"].map(file => readFile(`node_modules/${file}`, "utf8"));
await writeFile("dist/LICENSES.txt", (await Promise.all(licenses)).join("\n\n"));
await copyFile("index.html", "dist/index.html");
