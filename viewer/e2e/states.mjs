// States of pages in a real Chromium, offline: node e2e/states.mjs STATES.json [PICTURES]
// Each state is {name, page, hash, click, press, sizes, picture, spoil}. In each size no text, token or button lies over another one, and nothing is cut.
// With PICTURES, a folder, the size that `picture` names is kept as NAME.png. CHROMIUM names the browser.

import { execSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { chromium } from "playwright-core";
import { faults, remember } from "./layout.mjs";

const [file, pictures] = process.argv.slice(2);
const executablePath = process.env.CHROMIUM ?? execSync("command -v chromium || command -v chromium-browser", { encoding: "utf8" }).trim();
const SIZES = { desktop: [1280, 800], phone: [390, 844] };
const problems = [];

async function look(browser, state, size) {
  const [width, height] = SIZES[size];
  const context = await browser.newContext({ viewport: { width, height }, offline: true, colorScheme: "light", reducedMotion: "reduce", hasTouch: size === "phone" });
  const page = await context.newPage();
  const where = `${state.name}, ${size}`;
  page.on("console", (message) => problems.push(`${where}: the console says ${message.text()}`));
  page.on("pageerror", (error) => problems.push(`${where}: ${error.stack}`));
  await page.addInitScript(remember);
  await page.goto(`file://${state.page}${state.hash ?? ""}`);
  await page.waitForFunction(() => performance.getEntriesByName("first frame").length > 0, null, { timeout: 120_000 });
  for (const id of state.click ?? []) await page.locator(id).first().click();
  await page.evaluate(() => document.activeElement?.blur());
  for (const key of state.press ?? []) await page.keyboard.press(key);
  await page.mouse.move(0, 0);
  await page.evaluate((changes) => {
    for (const [place, style] of Object.entries(changes)) document.querySelector(place).style.cssText += style;
  }, state.spoil ?? {});
  await page.waitForTimeout(700); // the terrain is drawn anew
  for (const fault of await page.evaluate(faults)) problems.push(`${where}: ${fault}`);
  if (pictures && state.picture === size) await page.screenshot({ path: `${pictures}/${state.name}.png` });
  await context.close();
}

const browser = await chromium.launch({ executablePath, args: ["--no-sandbox"] });
try {
  for (const state of JSON.parse(readFileSync(file, "utf8"))) for (const size of state.sizes ?? Object.keys(SIZES)) await look(browser, state, size);
} finally {
  await browser.close();
}
for (const problem of problems) console.error(problem);
process.exit(problems.length ? 1 : 0);
