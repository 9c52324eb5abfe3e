// Builds one file a page: code and style stand in it, and its policy names their hashes and forbids everything else.
// page.html shows recorded games (index.html); with --mode play it is the page of `hexwar play` (play.html).

import { createHash } from "node:crypto";
import { readFileSync, readdirSync, writeFileSync } from "node:fs";
import { join, sep } from "node:path";
import type { Plugin } from "vite";
import { defineConfig } from "vitest/config";

const HERE = import.meta.dirname;
const OUT = join(HERE, "../hexwar_sb3/viewer/built");
const SOURCES = ["index.html", "play.html", "package.json", "package-lock.json", "tsconfig.json", "vite.config.ts"];

function hashOf(text: string): string {
  return `'sha256-${createHash("sha256").update(text).digest("base64")}'`;
}

/** What a page may do; the one that plays talks to the server that it came from, and to nobody else. */
function policy(script: string, style: string, talks: boolean): string {
  const rules = [
    "default-src 'none'", `script-src ${hashOf(script)}`, `style-src ${hashOf(style)}`, "img-src data: blob:", "media-src blob:",
    "base-uri 'none'", "form-action 'none'",
    ...(talks ? ["connect-src 'self'"] : []),
  ];
  return `<meta http-equiv="Content-Security-Policy" content="${rules.join("; ")}">`;
}

/** Hash of all that the pages are built from; a Python test compares it, so that nobody forgets to build. */
function sourcesHash(): string {
  const digest = createHash("sha256");
  const found = readdirSync(join(HERE, "src"), { recursive: true, withFileTypes: true }).filter((one) => one.isFile());
  const files = [...SOURCES, ...found.map((one) => join(one.parentPath, one.name).slice(HERE.length + 1).split(sep).join("/"))].sort();
  for (const name of files) digest.update(`${name}\n`).update(readFileSync(join(HERE, name)));
  return digest.digest("hex");
}

function oneFile(name: string): Plugin {
  const talks = name === "play.html";
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
      const head = `${policy(script, style, talks)}\n<style>${style}</style>\n</head>`;
      const built = bare.replace("</head>", () => head).replace("</body>", () => `<script type="module">${script}</script>\n</body>`);
      this.emitFile({ type: "asset", fileName: name, source: built });
      writeFileSync(join(OUT, "sources.sha256"), `${sourcesHash()}\n`);
    },
  };
}

export default defineConfig(({ mode }) => {
  const plays = mode === "play";
  return {
    root: HERE,
    plugins: [oneFile(plays ? "play.html" : "page.html")],
    build: {
      outDir: OUT, emptyOutDir: false, modulePreload: false, cssCodeSplit: false, target: "es2022", assetsInlineLimit: 0,
      rollupOptions: { input: join(HERE, plays ? "play.html" : "index.html") },
    },
    test: { include: ["test/*.test.ts"] },
  };
});
