// Builds one file: code and style stand in the page, and its policy names their hashes and forbids everything else.

import { createHash } from "node:crypto";
import { readFileSync, readdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import type { Plugin } from "vite";
import { defineConfig } from "vitest/config";

const HERE = import.meta.dirname;
const OUT = join(HERE, "../hexwar_sb3/viewer/built");
const SOURCES = ["index.html", "package.json", "package-lock.json", "tsconfig.json", "vite.config.ts"];

function hashOf(text: string): string {
  return `'sha256-${createHash("sha256").update(text).digest("base64")}'`;
}

function policy(script: string, style: string): string {
  const rules = [
    "default-src 'none'", `script-src ${hashOf(script)}`, `style-src ${hashOf(style)}`, "img-src data: blob:", "media-src blob:",
    "base-uri 'none'", "form-action 'none'",
  ];
  return `<meta http-equiv="Content-Security-Policy" content="${rules.join("; ")}">`;
}

/** Hash of all that the page is built from; a Python test compares it, so that nobody forgets to build. */
function sourcesHash(): string {
  const digest = createHash("sha256");
  const files = [...SOURCES, ...readdirSync(join(HERE, "src")).map((name) => `src/${name}`)].sort();
  for (const name of files) digest.update(`${name}\n`).update(readFileSync(join(HERE, name)));
  return digest.digest("hex");
}

function oneFile(): Plugin {
  return {
    name: "one-file",
    enforce: "post",
    generateBundle(_, bundle) {
      let [script, style, page] = ["", "", ""];
      for (const part of Object.values(bundle)) {
        if (part.type === "chunk") script += part.code;
        else if (part.fileName.endsWith(".css")) style += String(part.source);
        else page = String(part.source);
        delete bundle[part.fileName];
      }
      script = script.trim();
      style = style.trim();
      if (/<\/script|<!--/i.test(script)) this.error("the script would end the page's script block");
      const bare = page.replace(/\s*<script type="module"[^>]*><\/script>/, "").replace(/\s*<link rel="stylesheet"[^>]*>/, "");
      const head = `${policy(script, style)}\n<style>${style}</style>\n</head>`;
      const built = bare.replace("</head>", () => head).replace("</body>", () => `<script type="module">${script}</script>\n</body>`);
      this.emitFile({ type: "asset", fileName: "page.html", source: built });
      writeFileSync(join(OUT, "sources.sha256"), `${sourcesHash()}\n`);
    },
  };
}

export default defineConfig({
  root: HERE,
  plugins: [oneFile()],
  build: { outDir: OUT, emptyOutDir: false, modulePreload: false, cssCodeSplit: false, target: "es2022", assetsInlineLimit: 0 },
  test: { include: ["test/*.test.ts"] },
});
