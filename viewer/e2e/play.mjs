// A game that is played, in a real Chromium against a real server: node e2e/play.mjs ADDRESS MODE [PICTURES]
// MODE: mouse, keys, tabs, phone or lost, made for the scenario of tests/server/test_play_page.py; guide, guide-phone; sample. Prints figures as JSON; fails with what is wrong.

import { execSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { chromium, devices } from "playwright-core";

const [address, mode, pictures] = process.argv.slice(2);
const executablePath = process.env.CHROMIUM ?? execSync("command -v chromium || command -v chromium-browser", { encoding: "utf8" }).trim();
const BARS = { answerMs: 100, touchPx: 44 };
const MAIN = "3635"; // the cell of the point
const MOST_RUNS = 60; // until the game must be over
const MOST_STOPS = 600; // likewise, of a whole game
const problems = [];
const figures = {};

function check(holds, text) {
  if (!holds) problems.push(text);
}

/** A page of the game, entered with the token of the address or the cookie of the page before it. */
async function open(context, where = address) {
  const page = await context.newPage();
  page.on("console", (message) => problems.push(`the console says ${message.text()}`));
  page.on("pageerror", (error) => problems.push(error.stack));
  page.on("request", (request) => {
    if (new URL(request.url()).origin !== new URL(address).origin && !/^(data|blob):/.test(request.url())) problems.push(`asked for ${request.url()}`);
  });
  await page.goto(where);
  await page.waitForFunction(() => performance.getEntriesByName("first frame").length > 0, null, { timeout: 20_000 });
  check(!page.url().includes("#"), "the token still stands in the address");
  return page;
}

const text = (page, id) => page.locator(`#${id}`).innerText();
const tick = (page) => page.evaluate(() => window.hexwar.session().tick);
const isOver = (page) => page.locator("#ending[open]").isVisible();
const tray = (page) => page.evaluate(() => window.hexwar.session().state.tray);
const plans = (page) => page.evaluate(() => window.hexwar.session().state.plans);
const token = (page, name) => page.evaluate((name) => window.hexwar.token(name), name);
const place = (page, name) => page.evaluate((name) => window.hexwar.placeOf(name), name);

async function picture(page, name) {
  if (pictures) await page.screenshot({ path: `${pictures}/${name}.png` });
}

/** Wait until something holds on the page. */
async function until(page, what, holds, ...args) {
  try {
    await page.waitForFunction(holds, args, { timeout: 8000 });
  } catch {
    throw new Error(`${what}; the page says: ${await text(page, "said")} ${await text(page, "told").catch(() => "")} ${await text(page, "tray")}`);
  }
}

const waits = (page, piece, part) => until(page, `${piece}: expected ${part} in the tray`, ([piece, part]) => JSON.stringify([window.hexwar.session().state.tray[piece], window.hexwar.session().state.plans[piece]]).includes(part), piece, part);
const nothingWaits = (page, piece) => until(page, `${piece}: expected no order`, ([piece]) => !window.hexwar.session().state.tray[piece] && !window.hexwar.session().state.plans[piece], piece);

/** Let the clock run by `start`, and wait until it stands at another tick, or the game is over. */
async function runs(page, start) {
  const before = await tick(page);
  await start();
  const stands = ([before]) => (window.hexwar.session().tick > before && !window.hexwar.session().state.clock.running) || document.querySelector("#ending[open]") !== null;
  await page.waitForFunction(stands, [before], { timeout: 60_000 });
}

/** What axe finds that is serious. */
async function readable(page, name) {
  if (!(await page.evaluate(() => "axe" in window))) await page.evaluate(readFileSync(new URL("../node_modules/axe-core/axe.min.js", import.meta.url), "utf8"));
  const found = await page.evaluate(() => window.axe.run(document, { resultTypes: ["violations"] }));
  for (const one of found.violations.filter(({ impact }) => impact === "serious" || impact === "critical")) {
    problems.push(`axe, ${name}: ${one.id}: ${one.nodes.slice(0, 3).map((node) => `${node.target} ${node.any.map(({ message }) => message).join("; ")}`).join(" | ")}`);
  }
}

async function readableEverywhere(page) {
  for (const colorScheme of ["light", "dark"]) {
    await page.emulateMedia({ colorScheme });
    for (const tab of ["orders", "pieces", "log", "hints"]) {
      await page.click(`#tab-${tab}`);
      await page.waitForTimeout(120);
      await readable(page, `${tab}, ${colorScheme}`);
    }
  }
  await page.emulateMedia({ colorScheme: "light" });
  await page.click("#tab-orders");
}

/** From a click on a cell to the picture with the order, ms: the tray has it, and a frame was drawn. */
async function answerTimes(page, cells) {
  const found = [];
  for (const cell of cells) {
    const at = await place(page, cell);
    await page.mouse.move(at.x, at.y);
    await page.waitForTimeout(150);
    await page.evaluate((cell) => {
      window.answered = new Promise((done, failed) => {
        setTimeout(() => failed(new Error(`no order to ${cell} is drawn`)), 5000);
        let start = 0;
        document.addEventListener("pointerup", () => (start = performance.now()), { capture: true, once: true });
        const watch = new MutationObserver(() => {
          if (!start || !document.getElementById("tray").innerText.includes(cell)) return;
          watch.disconnect();
          requestAnimationFrame(() => setTimeout(() => done(performance.now() - start)));
        });
        watch.observe(document.getElementById("tray"), { childList: true, subtree: true });
      });
    }, cell);
    await page.mouse.down();
    await page.mouse.up();
    found.push(await page.evaluate(() => window.answered));
  }
  return found.sort((a, b) => a - b);
}

// --- by mouse alone -------------------------------------------------------------------------------

async function mouse(context) {
  const page = await open(context);
  figures.firstFrameMs = Math.round(await page.evaluate(() => performance.getEntriesByName("first frame")[0].startTime));
  check(await page.locator("#first[open]").isVisible(), "no help with the first order");
  const name = await page.evaluate(() => window.hexwar.session().story.players.red.name);
  check((await page.locator(".you .name").textContent()) === name, `${name} is not shown as a text`);
  await readable(page, "first order");
  await page.click("#first button.strong");
  await rules(context, page);
  await clickOn(page, await token(page, "red:tank0"));
  const times = await answerTimes(page, ["3231", "3338", "3632", "3538", "3331", "3139", "3832", "3238", "3431"]);
  figures.answerMedianMs = Math.round(times[4]);
  figures.answerMostMs = Math.round(times[8]);
  check(process.env.SPEED === "no" || times[4] < BARS.answerMs, `an order is drawn after ${times[4]} ms`);
  while (await page.evaluate(() => window.hexwar.session().state.undo)) await takeBack(page);
  await nothingWaits(page, "tank0");

  await hoverOn(page, await place(page, MAIN));
  await until(page, "expected a way to be shown", () => window.hexwar.aimed()?.preview?.cells.length === 3);
  await clickOn(page, await place(page, MAIN));
  await waits(page, "tank0", `go ${MAIN}`);
  await page.click("#place-then");
  await page.click("#act-tank0-occupy");
  await waits(page, "tank0", "tank0 occupy");
  await page.keyboard.down("Shift");
  await clickOn(page, await place(page, "3634"));
  await page.keyboard.up("Shift");
  await waits(page, "tank0", "go 3634");
  await picture(page, "plan");
  await takeBack(page);
  check(!JSON.stringify(await plans(page)).includes("3634"), "taken back, and still planned");

  await clickOn(page, await token(page, "red:chariot0"));
  await page.click("#on-mortar");
  const soldier = await token(page, "blue:soldier0");
  await hoverOn(page, soldier);
  await until(page, "expected the mortar's chances", () => window.hexwar.aimed()?.lines[0]?.startsWith("Mortar at"));
  await picture(page, "mortar");
  await clickOn(page, soldier);
  await waits(page, "chariot0", "indirect-shoot");
  await readableEverywhere(page);

  await runs(page, () => page.click("#go"));
  await clickOn(page, await token(page, "red:tank0"));
  await hoverOn(page, await token(page, "blue:soldier0"));
  await page.waitForTimeout(300);
  await picture(page, "fight");
  await runs(page, () => page.click("#one"));
  for (let k = 0; k < MOST_RUNS && !(await isOver(page)); k++) await runs(page, () => page.click("#go"));
  await ended(page);
  await sameStory(context, page);
  await page.click("#after");
  await page.waitForFunction(() => document.title.includes("against"), null, { timeout: 20_000 });
}

/** All that was new, message by message, makes the story that a new page is told at once. */
async function sameStory(context, page) {
  const fresh = await open(context, new URL("/", address).href);
  const sorted = (value) => (Array.isArray(value) ? value.map(sorted) : value && typeof value === "object" ? Object.fromEntries(Object.keys(value).sort().map((key) => [key, sorted(value[key])])) : value);
  const [grown, whole] = await Promise.all([page, fresh].map((one) => one.evaluate(() => window.hexwar.session().story)));
  for (const key of Object.keys({ ...grown, ...whole })) {
    const [a, b] = [grown, whole].map((story) => JSON.stringify(sorted(story[key])));
    check(a === b, `${key} of the story: message by message ${a?.slice(0, 200)}, at once ${b?.slice(0, 200)}`);
  }
  await fresh.close();
}

/** The rules open in a tab of their own. */
async function rules(context, page) {
  const [popup] = await Promise.all([context.waitForEvent("page"), page.click("#rules")]);
  await popup.waitForLoadState();
  check((await popup.title()).toLowerCase().includes("rule"), `the rules are called ${await popup.title()}`);
  await popup.close();
}

async function hoverOn(page, at) {
  await page.mouse.move(at.x, at.y);
  await page.waitForTimeout(60);
}

async function clickOn(page, at) {
  await hoverOn(page, at);
  await page.mouse.click(at.x, at.y);
  await page.waitForTimeout(60);
}

async function takeBack(page) {
  const left = await page.evaluate(() => window.hexwar.session().state.undo);
  await page.click("#undo");
  await until(page, "expected an order to be taken back", ([left]) => window.hexwar.session().state.undo < left, left);
}

async function ended(page) {
  check(await isOver(page), "the game does not end");
  await page.waitForTimeout(300);
  await readable(page, "the end");
  await picture(page, "end");
  const { owners, result } = await page.evaluate(() => ({ owners: window.hexwar.state().owners, result: window.hexwar.session().over.result }));
  figures.result = result;
  check(owners[0] === "red", `the point is ${owners[0]}`);
  check((await text(page, "ending")).includes("true margins"), "the end does not say the margins");
}

// --- by keys alone --------------------------------------------------------------------------------

async function keys(context) {
  const page = await open(context);
  const press = async (...names) => {
    for (const name of names) {
      await page.keyboard.press(name);
      await page.waitForTimeout(60);
    }
  };
  const type = async (line) => {
    await press("/");
    await page.keyboard.type(line);
    await press("Enter");
  };
  await press("Enter"); // begin
  check(!(await page.locator("#first[open]").isVisible()), "the help does not close by Enter");
  await press("1", "ArrowRight", "ArrowRight", "ArrowRight");
  await until(page, "expected a way at the cursor", () => window.hexwar.aimed()?.preview?.cells.length === 3);
  await until(page, "expected the cursor to be told", () => document.getElementById("live").innerText.includes("3635"));
  await press("Enter");
  await waits(page, "tank0", `go ${MAIN}`);
  await press("Backspace");
  await nothingWaits(page, "tank0");
  await press("ArrowRight", "ArrowRight", "ArrowRight", "Enter");
  await waits(page, "tank0", `go ${MAIN}`);
  await press("ArrowUp", "Shift+Enter");
  await until(page, "expected shift Enter to plan one more", () => JSON.stringify(window.hexwar.session().state.plans).split("go ").length > 2);
  await press("Backspace");
  await until(page, "expected one plan", () => JSON.stringify(window.hexwar.session().state.plans).split("go ").length === 2);
  await type("then tank0 occupy");
  await waits(page, "tank0", "tank0 occupy");
  await press("2", "m");
  await until(page, "expected the mortar's cells", () => window.hexwar.mortarCells() > 100);
  await type("4135");
  await until(page, "expected the mortar's chances", () => window.hexwar.aimed()?.lines[0]?.startsWith("Mortar at"));
  await press("Enter");
  await waits(page, "chariot0", "indirect-shoot");
  await press("Escape", "1", "a");
  await until(page, "expected the focus in the list of actions", () => document.activeElement?.closest("#panel") !== null);
  await press("ArrowDown", "ArrowUp", "Escape");
  await page.evaluate(() => document.activeElement.blur());
  await press("p");
  check(await page.locator("#when[open]").isVisible(), "p does not show when the clock stops");
  await press("Escape", "?");
  check(await page.locator("#keys[open]").isVisible(), "? does not show the keys");
  await press("Escape");
  await runs(page, () => press("Enter")); // give the orders and run
  const before = await tick(page);
  await runs(page, () => press("."));
  check((await tick(page)) === before + 1, `one tick more than ${before} is ${await tick(page)}`);
  await press("Home");
  await until(page, "expected Home to look back", () => document.getElementById("tick").innerText === "0");
  await press("End");
  for (let k = 0; k < MOST_RUNS && !(await isOver(page)); k++) await runs(page, () => press(k % 2 ? "Enter" : "d"));
  await ended(page);
  await press("Enter"); // on the link to all of it
  await page.waitForFunction(() => location.pathname === "/after", null, { timeout: 20_000 });
}

// --- two tabs, and none ---------------------------------------------------------------------------

async function tabs(context) {
  const first = await open(context);
  await first.click("#first button.strong");
  const second = await open(context, new URL("/", address).href);
  check((await text(second, "notice")).includes("reads along"), `a second tab says ${await text(second, "notice")}`);
  check(!(await second.locator("#tray").isVisible()), "a second tab has a tray");
  await clickOn(second, await token(second, "red:tank0"));
  await hoverOn(second, await place(second, MAIN));
  check(await second.locator("#go:enabled").count() === 0, "a second tab can run the clock");
  const third = await context.newPage();
  await third.goto(new URL("/", address).href);
  await third.waitForFunction(() => document.getElementById("notice").textContent.includes("two tabs"), null, { timeout: 8000 }).catch(() => problems.push("a third tab does not say that there are two"));
  await third.close();
  await first.bringToFront();
  await first.keyboard.press("1");
  await clickOn(first, await place(first, MAIN));
  await waits(second, "tank0", `go ${MAIN}`);
  await first.click("#stops");
  for (const name of ["first_sight", "own_loss", "idle"]) await first.uncheck(`#stop-${name}`);
  await first.click("#when button.strong");
  await first.click("#play");
  await until(second, "expected the clock to run", () => window.hexwar.session().tick > 2);
  await first.close();
  await until(second, "expected the second tab to take over", () => window.hexwar.session().role === "commands");
  check(!(await second.evaluate(() => window.hexwar.session().state.clock.running)), "the clock runs on without who commands");
  const left = await tick(second);
  await second.waitForTimeout(600);
  check((await tick(second)) === left, "the clock runs on without who commands");
  await second.click("#play");
  await until(second, "expected the clock to run", ([left]) => window.hexwar.session().tick > left, left);
  await second.close();
  const last = await open(context, new URL("/", address).href);
  const [now, running] = await last.evaluate(() => [window.hexwar.session().tick, window.hexwar.session().state.clock.running]);
  check(now > left && !running, `after all tabs were closed: tick ${now}, running ${running}`);
  await last.waitForTimeout(500);
  check((await tick(last)) === now, "a closed tab does not pause");
}

// --- on a phone -----------------------------------------------------------------------------------

async function phone(context) {
  const page = await open(context);
  const tap = async (at) => {
    await page.touchscreen.tap(at.x, at.y);
    await page.waitForTimeout(120);
  };
  await picture(page, "phone-first");
  await page.tap("#first button.strong");
  await tap(await token(page, "red:tank0"));
  const cell = await place(page, MAIN);
  await tap(cell);
  await until(page, "expected an offer", () => document.getElementById("plan") !== null);
  check(Object.keys(await tray(page)).length === 0, "the first tap plans at once");
  await page.waitForTimeout(200);
  await picture(page, "phone");
  const small = await page.evaluate((least) => [...document.querySelectorAll("button, #tools a")].filter((one) => one.checkVisibility() && one.getBoundingClientRect().height < least - 0.5 && !one.closest("table, #rows, h2")).map((one) => `${one.id || one.textContent} ${one.getBoundingClientRect().height}`), BARS.touchPx);
  check(small.length === 0, `too small to touch: ${small.join(", ")}`);
  const wide = await page.evaluate(() => document.scrollingElement.scrollWidth);
  check(wide <= 390, `the page is ${wide} wide`);
  await page.tap("#plan");
  await waits(page, "tank0", `go ${MAIN}`);
  await picture(page, "phone-tray");
  await readableEverywhere(page);
  await runs(page, () => page.tap("#go"));
  await picture(page, "phone-stop");
}

// --- a server that is gone --------------------------------------------------------------------------

/** Says when it is ready, and waits until somebody stops the server. */
async function lost(context) {
  const page = await open(context);
  await page.click("#first button.strong");
  console.log("ready");
  await until(page, "expected a notice that the server is gone", () => !document.getElementById("notice").hidden);
  figures.notice = await text(page, "notice");
  check(/stopped|lost/.test(figures.notice), `a server that is gone is told as ${figures.notice}`);
  await clickOn(page, await token(page, "red:tank0"));
  await clickOn(page, await place(page, MAIN));
  await readable(page, "without a server");
}

// --- the pictures of the guide ----------------------------------------------------------------------

const OPENING = ["tank0 go 3135", "tank1 go 3147", "chariot0 go 2737", "chariot1 go 2743", "aerocraft0 go 3840", "speed 64"];

async function typed(page, line) {
  await page.keyboard.press("/");
  await page.keyboard.type(line);
  await page.keyboard.press("Enter");
  await page.waitForTimeout(100);
}

/** Give orders, and let the clock run from stop to stop until a tick. */
async function playTo(page, wanted) {
  while ((await tick(page)) < wanted) await runs(page, () => page.keyboard.press("Enter"));
  await page.waitForTimeout(400);
}

/** Show a part of the map, between two cells. */
async function showPart(page, cells, room) {
  await page.evaluate(([cells, room]) => window.hexwar.show(cells, room), [cells, room]);
  await page.waitForTimeout(500);
}

async function opened(context) {
  const page = await open(context);
  await page.keyboard.press("Enter");
  for (const line of OPENING) await typed(page, line);
  return page;
}

async function guide(context) {
  const page = await opened(context);
  await playTo(page, 400);
  await page.keyboard.press("2");
  await showPart(page, ["2537", "4349"], 3);
  await clickOn(page, await place(page, "3145"));
  await page.keyboard.down("Shift");
  await hoverOn(page, await place(page, "3647"));
  await page.waitForTimeout(700);
  await picture(page, "orders");
  await page.keyboard.up("Shift");
  await page.keyboard.press("Backspace");
  await playTo(page, 534);
  await page.keyboard.press("3");
  await page.keyboard.press("m");
  await showPart(page, ["2231", "4449"], 2);
  await hoverOn(page, await token(page, "blue:tank0"));
  await page.waitForTimeout(700);
  await picture(page, "mortar");
  await playTo(page, 615);
  await page.keyboard.press("2");
  await showPart(page, ["2637", "4149"], 2);
  await hoverOn(page, await token(page, "blue:tank1"));
  await page.waitForTimeout(700);
  await picture(page, "fight");
  await page.keyboard.press("p");
  await page.click("#finish");
  await page.waitForSelector("#ending[open]", { timeout: 60_000 });
  await page.waitForTimeout(800);
  await picture(page, "end");
}

async function guidePhone(context) {
  const page = await opened(context);
  await playTo(page, 615);
  await showPart(page, ["2842", "4152"], 0);
  await page.tap("#pick-tank1");
  const at = await token(page, "blue:tank1");
  await page.touchscreen.tap(at.x, at.y);
  await page.waitForTimeout(700);
  await picture(page, "phone");
}

// --- sample games -----------------------------------------------------------------------------------

const LEAST_POINTS = 1; // that a shot must be worth

/** A whole game: wherever the clock stops, each idle piece does the best that the page lists for it, else it goes to its goal. */
async function sample(context) {
  const goals = JSON.parse(process.env.GOALS);
  const page = await open(context);
  await page.keyboard.press("Enter");
  await typed(page, "speed 64");
  for (let k = 0; k < MOST_STOPS && !(await isOver(page)); k++) {
    const idle = await page.evaluate(() => [...document.querySelectorAll(".pick-row button")].map((one) => one.id.slice("pick-".length)).filter((name) => window.hexwar.session().isIdle(name)));
    for (const name of idle) await act(page, name, goals[name]);
    await runs(page, () => page.click("#go"));
  }
  check(await isOver(page), "the game does not end");
  figures.result = await page.evaluate(() => window.hexwar.session().over?.result);
}

async function act(page, name, goal) {
  await page.click(`#pick-${name}`);
  await until(page, `${name}: expected a list of what it can do`, ([name]) => document.querySelector(`#pick-${name}[aria-pressed="true"]`) && document.querySelector("#panel .acts"), name);
  await page.waitForTimeout(500); // an answer of an earlier tick is asked for again
  const found = await page.evaluate(([name, goal, least]) => {
    const { map, game, tick, camp } = window.hexwar.session();
    const { cell } = game.shown(game.byName(`${camp}:${name}`), tick);
    const there = goal === [cell % map.width, Math.floor(cell / map.width)].map((number) => String(number + 1).padStart(2, "0")).join("");
    const offers = [...document.querySelectorAll("#panel .acts button")].map((one) => ({ id: one.id, points: Number.parseFloat(one.querySelector(".points")?.textContent ?? "0") }));
    const shot = offers.find(({ points }) => points >= least);
    const other = (verb) => offers.find(({ id }) => id.startsWith(`act-${name}-${verb}`));
    return { there, id: (shot ?? other("occupy") ?? (there ? other("get-off") ?? other("hide") : undefined))?.id };
  }, [name, goal, LEAST_POINTS]);
  if (found.id) await page.click(`#${found.id}`, { timeout: 3000 }).catch(() => {}); // gone: the list was of an earlier tick
  else if (goal && !found.there) await typed(page, `${name} go ${goal}`);
}

const browser = await chromium.launch({ executablePath, args: ["--no-sandbox"] });
try {
  const { defaultBrowserType: _, ...pixel } = devices["Pixel 7"];
  const context = await browser.newContext(mode.endsWith("phone") ? { ...pixel, viewport: { width: 390, height: 844 }, deviceScaleFactor: 2 } : { viewport: mode === "guide" ? { width: 1280, height: 800 } : { width: 1400, height: 900 } });
  await { mouse, keys, tabs, phone, lost, guide, "guide-phone": guidePhone, sample }[mode](context);
} catch (error) {
  problems.push(error.message);
} finally {
  await browser.close();
}
console.log(JSON.stringify(figures));
for (const problem of problems.slice(0, 20)) console.error(problem);
process.exit(problems.length ? 1 : 0);
