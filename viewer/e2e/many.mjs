// Pages of many games in a real Chromium, offline: node e2e/many.mjs ALBUM COMPARE LEAGUE
// The album's first point opens its first game; two of its games are put side by side, also on a phone; a cell of the league opens its game, two of them are compared.
// PARTING is the tick at which the two games of COMPARE part; CHROMIUM names the browser; SHOTS a folder that gets pictures.

import { execSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { chromium } from "playwright-core";

const [album, compare, league] = process.argv.slice(2);
const executablePath = process.env.CHROMIUM ?? execSync("command -v chromium || command -v chromium-browser", { encoding: "utf8" }).trim();
const shots = process.env.SHOTS;
const problems = [];

function check(holds, text) {
  if (!holds) problems.push(text);
}

async function open(browser, file, viewport = { width: 1400, height: 900 }, colorScheme = "light") {
  const context = await browser.newContext({ viewport, offline: true, colorScheme });
  const page = await context.newPage();
  page.on("console", (message) => problems.push(`${file}: the console says ${message.text()}`));
  page.on("pageerror", (error) => problems.push(`${file}: ${error.stack}`));
  page.on("request", (request) => {
    if (!/^(data|blob):/.test(request.url()) && request.url().split("#")[0] !== `file://${file}`) problems.push(`${file}: asked for ${request.url()}`);
  });
  await page.goto(`file://${file}`);
  await page.waitForFunction(() => performance.getEntriesByName("first frame").length > 0, null, { timeout: 120_000 });
  return page;
}

async function shot(page, name, fullPage = false) {
  if (!shots) return;
  await page.waitForTimeout(400);
  await page.screenshot({ path: `${shots}/${name}.png`, fullPage });
}

const address = (page) => page.evaluate(() => location.hash);
const isShown = (page, id) => page.evaluate((id) => !document.getElementById(id).hidden, id);
const shown = (page, id) => page.waitForFunction((id) => !document.getElementById(id).hidden, id, { timeout: 120_000 });

/** What axe finds that is serious. */
async function readable(page, name) {
  await page.evaluate(readFileSync(new URL("../node_modules/axe-core/axe.min.js", import.meta.url), "utf8"));
  const found = await page.evaluate(() => window.axe.run(document, { resultTypes: ["violations"] }));
  for (const one of found.violations.filter(({ impact }) => impact === "serious" || impact === "critical")) {
    problems.push(`axe, ${name}: ${one.id}: ${one.nodes.slice(0, 3).map((node) => `${node.target} ${node.any.map(({ message }) => message).join("; ")}`).join(" | ")}`);
  }
}

/** The cover, the curve, a game by its address, back again, and two games to compare. */
async function lookAtAlbum(browser) {
  const page = await open(browser, album);
  check(await isShown(page, "cover"), "the album does not begin with its cover");
  await shot(page, "album");
  await readable(page, "album");
  await page.locator(".point").first().focus();
  await page.keyboard.press("Enter");
  await shown(page, "app");
  check((await address(page)).startsWith("#game=1"), `the first point opened ${await address(page)}`);
  await page.keyboard.press("a");
  await shown(page, "cover");
  await page.locator(".point").nth(1).click();
  await shown(page, "app");
  check((await address(page)).startsWith("#game=2"), `the second point opened ${await address(page)}`);
  await page.goBack();
  await shown(page, "cover");
  await page.evaluate(() => (location.hash = "#game=2&t=7"));
  await shown(page, "app");
  check((await page.getAttribute("#timeline", "aria-valuenow")) === "7", "the address of a moment does not lead there");
  await page.click("#all");
  await page.check("#compare-1");
  await page.check("#compare-2");
  await page.click("#compare");
  await shown(page, "app");
  check((await address(page)).startsWith("#game=1&with=2"), `the two that were picked opened ${await address(page)}`);
  await page.context().close();
}

async function lookAtPair(browser) {
  const page = await open(browser, compare);
  check(await isShown(page, "app"), "two games are not side by side at once");
  const parting = await page.evaluate(() => window.hexwar.parting()?.tick ?? -1);
  if (process.env.PARTING) check(parting === Number(process.env.PARTING), `they part at ${parting}, expected ${process.env.PARTING}`);
  check((await page.textContent("#parting")).includes(`${parting}`), "the page does not say where they part");
  await page.evaluate(() => window.hexwar.seek(600));
  await page.click("#parting");
  check((await page.getAttribute("#timeline", "aria-valuenow")) === String(parting), "the button does not lead to where they part");
  await page.evaluate(() => window.hexwar.seek(900));
  await shot(page, "compare");
  await readable(page, "compare");
  await page.keyboard.press("w");
  check((await page.getAttribute("#pick-1", "aria-pressed")) === "true", "key w does not lead to the other game");
  await page.context().close();
}

async function lookAtLeague(browser) {
  const page = await open(browser, league);
  await shot(page, "league");
  await readable(page, "league");
  const cell = page.locator("button.rate").first();
  const number = await cell.getAttribute("data-game");
  await cell.click();
  await shown(page, "app");
  check((await address(page)).startsWith(`#game=${number}`), `a cell of game ${number} opened ${await address(page)}`);
  await page.click("#all");
  await shown(page, "cover");
  await compareCells(page);
  await page.context().close();
}

/** Two cells are picked, then put side by side; a third cannot be picked. */
async function compareCells(page) {
  const cells = page.locator("button.rate");
  const numbers = await Promise.all([0, 1].map((k) => cells.nth(k).getAttribute("data-game")));
  await page.click("#pick-two");
  check(await page.locator("#compare").isDisabled(), "nothing is picked, and can be compared");
  await cells.nth(0).click();
  check((await cells.nth(0).getAttribute("aria-pressed")) === "true", "a cell that is picked does not say so");
  check(await page.locator("#compare").isDisabled(), "one game can be compared with none");
  await cells.nth(0).click();
  check((await cells.nth(0).getAttribute("aria-pressed")) === "false", "a cell that was picked cannot be let go");
  for (const k of [0, 1]) await cells.nth(k).click();
  await readable(page, "league, two picked");
  await page.click("#compare");
  await shown(page, "app");
  check((await address(page)).startsWith(`#game=${numbers[0]}&with=${numbers[1]}`), `cells of games ${numbers} opened ${await address(page)}`);
  await page.click("#all");
  await page.click("#pick-two");
  await cells.nth(1).click();
  await shown(page, "app");
  check((await address(page)).startsWith(`#game=${numbers[1]}`) && !(await address(page)).includes("with="), "a cell no longer opens its game");
}

/** Two games on a phone: the panel takes the place of the map of the other game, and gives it back. */
async function lookAtPairByThumb(browser) {
  const page = await open(browser, compare, { width: 390, height: 844 });
  const maps = () => page.evaluate(() => ["stage", "stage-2"].map((id) => document.getElementById(id).clientHeight > 100));
  const panel = page.locator("#panel");
  check(String(await maps()) === "true,true" && !(await panel.isVisible()), "a phone does not begin with both maps");
  await page.click("#tab-pieces");
  check(await panel.locator("#row-0").isVisible(), "the pieces cannot be reached");
  check(String(await maps()) === "true,false", "beside the panel the map of its game is shown");
  await readable(page, "compare, by thumb");
  await page.click("#pick-1");
  check(String(await maps()) === "false,true" && (await panel.isVisible()), "the panel of the other game cannot be reached");
  for (const tab of ["log", "policy"]) {
    await page.click(`#tab-${tab}`);
    check(await panel.isVisible(), `the ${tab} cannot be reached`);
  }
  check((await page.getAttribute("#fold", "aria-expanded")) === "true", "the button does not say that the panel is open");
  await page.click("#fold");
  check(String(await maps()) === "true,true" && !(await panel.isVisible()), "both maps do not come back");
  await page.context().close();
}

const browser = await chromium.launch({ executablePath, args: ["--no-sandbox"] });
try {
  await lookAtAlbum(browser);
  await lookAtPair(browser);
  await lookAtPairByThumb(browser);
  await lookAtLeague(browser);
  if (shots) {
    for (const [name, file, size, scheme] of [["album-phone", album, [390, 844], "light"], ["album-dark", album, [1400, 900], "dark"], ["league-dark", league, [1400, 900], "dark"], ["compare-phone", compare, [390, 844], "light"]]) {
      const page = await open(browser, file, { width: size[0], height: size[1] }, scheme);
      await shot(page, name);
      await page.context().close();
    }
  }
} finally {
  await browser.close();
}
for (const problem of problems.slice(0, 20)) console.error(problem);
process.exit(problems.length ? 1 : 0);
