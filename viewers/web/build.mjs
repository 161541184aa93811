// Bundles src/ and three.js into the one ESM file that Jupyter, Panel and plain pages load: npm run build
import { createHash } from "node:crypto";
import { readFileSync, readdirSync } from "node:fs";
import { join } from "node:path";
import { build } from "esbuild";

const here = import.meta.dirname;
const sources = readdirSync(join(here, "src"), { recursive: true })
  .filter((name) => /\.(js|css)$/.test(name))
  .map((name) => name.replaceAll("\\", "/"))
  .sort();

// The test that the committed bundle belongs to the committed sources recomputes this digest.
const digest = createHash("sha256");
for (const name of sources) {
  digest.update(name).update("\0").update(readFileSync(join(here, "src", name))).update("\0");
}

const licence = readFileSync(join(here, "node_modules/three/LICENSE"), "utf8").trim();
await build({
  entryPoints: [join(here, "src/index.js")],
  outfile: join(here, "player.bundle.js"),
  bundle: true,
  minify: true,
  format: "esm",
  target: "es2022",
  charset: "utf8",
  loader: { ".css": "text" },
  legalComments: "eof",
  banner: { js: `/* motionloom player. Built by \`npm run build\`; sources sha256: ${digest.digest("hex")} */` },
  footer: { js: `/* three.js, bundled above:\n\n${licence}\n*/` },
});
