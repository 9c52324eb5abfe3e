// A page in a real Chromium, offline: node e2e/run.mjs PAGE TRUTH.json
// TRUTH.json is made by tests/viewer/test_browser.py: what the game says at some ticks. Prints figures as JSON; fails with what differs.
// SPEED=no leaves out the times of frames and seeks, ONLY=compare all but the comparison, CHROMIUM names the browser.

import { execSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { chromium } from "playwright-core";

const [file, truthFile] = process.argv.slice(2);
const truth = JSON.parse(readFileSync(truthFile, "utf8"));
const executablePath = process.env.CHROMIUM ?? execSync("command -v chromium || command -v chromium-browser", { encoding: "utf8" }).trim();
const BARS = { firstFrameMs: 1000, slowFirstFrameMs: 2000, refereeFrameMs: 4, fogFrameMs: 8, seekMs: 50, heapMB: 60 };
const problems = [];

function check(holds, text) {
  if (!holds) problems.push(text);
}

/** Open a page and note whatever it says or asks for. */
async function open(browser, how, name, bar = BARS.firstFrameMs) {
  const context = await browser.newContext({ viewport: { width: 1400, height: 900 }, offline: true });
  const page = await context.newPage();
  page.on("console", (message) => problems.push(`${name}: the console says ${message.text()}`));
  page.on("pageerror", (error) => problems.push(`${name}: ${error.stack}`));
  page.on("request", (request) => {
    if (!/^(file|about|data|blob):/.test(request.url()) || (request.url().startsWith("file:") && request.url().split("#")[0] !== `file://${file}`)) problems.push(`${name}: asked for ${request.url()}`);
  });
  const frame = await how(page);
  await frame.waitForFunction(() => performance.getEntriesByName("first frame").length > 0, null, { timeout: 20_000 });
  const firstFrameMs = await frame.evaluate(() => performance.getEntriesByName("first frame")[0].startTime);
  check(firstFrameMs < bar, `${name}: first frame after ${firstFrameMs} ms`);
  return { page, frame, context, firstFrameMs };
}

const fromFile = (slower = 1) => async (page) => {
  if (slower > 1) await (await page.context().newCDPSession(page)).send("Emulation.setCPUThrottlingRate", { rate: slower });
  await page.goto(`file://${file}`);
  return page.mainFrame();
};
const framed = (sandbox) => async (page) => {
  await page.setContent("<!doctype html><iframe width='1300' height='800'></iframe>");
  await page.evaluate(([html, sandbox]) => {
    const frame = document.querySelector("iframe");
    if (sandbox) frame.setAttribute("sandbox", sandbox);
    frame.srcdoc = html;
  }, [readFileSync(file, "utf8"), sandbox]);
  const handle = await page.waitForSelector("iframe");
  return handle.contentFrame();
};

async function performanceOf(page) {
  const session = await page.context().newCDPSession(page);
  await session.send("Performance.enable");
  return session.send("Performance.getMetrics");
}

function percentile(values, share) {
  return [...values].sort((a, b) => a - b)[Math.floor(share * (values.length - 1))];
}

/** Compare what is drawn with what the game says, in every view that the page has. */
async function compare(frame) {
  let compared = 0;
  for (const view of Object.keys(truth.views)) {
    await frame.evaluate((view) => window.hexwar.show(view), view);
    for (const wanted of truth.views[view]) {
      const found = await frame.evaluate((tick) => window.hexwar.at(tick), wanted.tick);
      for (const key of Object.keys(wanted)) {
        compared += 1;
        check(JSON.stringify(found[key]) === JSON.stringify(wanted[key]), `${view}, tick ${wanted.tick}, ${key}: drawn ${JSON.stringify(found[key])}, the game says ${JSON.stringify(wanted[key])}`);
      }
    }
  }
  return compared;
}

const FRAMES = 360; // that are counted, after as many as a compiler needs
const WARM = 60;

/** CPU time of the frames of a game at 64x, by Chromium's own counters of its main thread: the same frames on any machine. And the time of a seek. */
async function speed(page, frame, view) {
  await browser.startTracing(page, { categories: ["devtools.timeline"] });
  const seeks = await playAndSeek(frame, view);
  const { traceEvents } = JSON.parse((await browser.stopTracing()).toString());
  const cpu = traceEvents.filter(({ name, ph }) => name === "TimerFire" && ph === "X").map(({ tdur }) => tdur / 1000);
  return { cpu: cpu.slice(-FRAMES), seeks };
}

/** Each frame is a task of its own, 64/60 ticks after the one before, from the first fight on. */
async function playAndSeek(frame, view) {
  return frame.evaluate(async ([view, count, from]) => {
    const { hexwar } = window;
    await hexwar.show(view);
    const seeks = [];
    for (let k = 0; k < 40; k++) {
      hexwar.costs.length = 0;
      hexwar.seek((k * 797) % 1800);
      await new Promise(requestAnimationFrame);
      await new Promise(requestAnimationFrame);
      seeks.push(hexwar.costs[0]);
    }
    const start = performance.now();
    for (let k = 0; k < count; k++) {
      await new Promise((done) => setTimeout(() => {
        hexwar.frame(from + (k * 64) / 60, start + (k * 1000) / 60);
        done();
      }));
    }
    return seeks;
  }, [view, FRAMES + WARM, truth.fight ?? 0]);
}

/** Whole control by keys: they work in a frame of its own, and nothing happens while somebody types. */
async function keys(page, frame) {
  await page.mouse.click(500, 400);
  const tick = () => frame.evaluate(() => Number(document.getElementById("timeline").getAttribute("aria-valuenow")));
  const press = async (key) => {
    await page.keyboard.press(key);
    await page.waitForTimeout(60);
  };
  for (const [key, wanted] of [["Home", 0], ["ArrowRight", 1], ["Shift+ArrowRight", 76], ["ArrowLeft", 75], ["End", truth.last], ["d", truth.last]]) {
    await press(key);
    check((await tick()) === wanted, `key ${key}: tick ${await tick()}, expected ${wanted}`);
  }
  await press("/");
  await page.keyboard.type("t 577");
  await press("Enter");
  check((await tick()) === 577, `command t 577: tick ${await tick()}`);
}

/** What axe finds that is serious: in each tab, in light and in dark. */
async function readable(page, frame) {
  await frame.evaluate(readFileSync(new URL("../node_modules/axe-core/axe.min.js", import.meta.url), "utf8"));
  for (const colorScheme of ["light", "dark"]) {
    await page.emulateMedia({ colorScheme });
    for (const tab of ["pieces", "log", "policy"]) {
      await frame.click(`#tab-${tab}`);
      await page.waitForTimeout(100);
      const found = await frame.evaluate(() => window.axe.run(document, { resultTypes: ["violations"] }));
      for (const one of found.violations.filter(({ impact }) => impact === "serious" || impact === "critical")) {
        problems.push(`axe, ${tab}, ${colorScheme}: ${one.id}: ${one.nodes.slice(0, 3).map((node) => `${node.target} ${node.any.map(({ message }) => message).join("; ")}`).join(" | ")}`);
      }
    }
  }
}

/** A browser that cannot unpack the stories shows the picture, and a sentence. */
async function withoutUnpacking(browser) {
  const context = await browser.newContext({ offline: true });
  const page = await context.newPage();
  await page.addInitScript(() => delete window.DecompressionStream);
  await page.goto(`file://${file}`);
  await page.waitForSelector("#fallback.now img", { state: "visible", timeout: 5000 }).catch(() => problems.push("without DecompressionStream there is no picture"));
  check((await page.innerText("#fallback")).includes("DecompressionStream"), "without DecompressionStream nobody says why");
  await context.close();
}

const browser = await chromium.launch({ executablePath, args: ["--no-sandbox"] });
const figures = {};
try {
  const main = await open(browser, fromFile(), "file");
  figures.firstFrameMs = Math.round(main.firstFrameMs);
  figures.compared = await compare(main.frame);
  const only = process.env.ONLY === "compare"; // for many games
  if (!only && process.env.SPEED !== "no") {
    for (const view of ["referee", "red"].filter((view) => view in truth.views)) {
      const { cpu, seeks } = await speed(main.page, main.frame, view);
      figures[view] = { frames: cpu.length, cpuMedianMs: percentile(cpu, 0.5), cpuP95Ms: percentile(cpu, 0.95), seekP95Ms: percentile(seeks, 0.95) };
      check(cpu.length === FRAMES, `${view}: ${cpu.length} frames were counted`);
      check(figures[view].cpuP95Ms < (view === "referee" ? BARS.refereeFrameMs : BARS.fogFrameMs), `${view}: p95 of the CPU time of a frame ${figures[view].cpuP95Ms} ms`);
      check(figures[view].seekP95Ms < BARS.seekMs, `${view}: p95 of a seek ${figures[view].seekP95Ms} ms`);
    }
  }
  if (!only) {
    const { metrics } = await performanceOf(main.page);
    figures.heapMB = Math.round(metrics.find(({ name }) => name === "JSHeapUsedSize").value / 1e5) / 10;
    check(figures.heapMB < BARS.heapMB, `${figures.heapMB} MB of heap`);
  }
  if (!only) await keys(main.page, main.frame);
  if (!only) await readable(main.page, main.frame);
  await main.context.close();
  for (const [name, sandbox] of only ? [] : [["srcdoc", ""], ["sandboxed", "allow-scripts"]]) {
    const one = await open(browser, framed(sandbox), name);
    figures[`${name}FirstFrameMs`] = Math.round(one.firstFrameMs);
    await keys(one.page, one.frame);
    await one.context.close();
  }
  if (!only) {
    const context = await browser.newContext({ javaScriptEnabled: false, offline: true });
    const page = await context.newPage();
    await page.goto(`file://${file}`);
    await page.waitForTimeout(2500);
    check(await page.locator("#fallback img").isVisible(), "without scripts there is no picture");
    await context.close();
    await withoutUnpacking(browser);
    const slow = []; // a wall clock with other processes beside it: the middle one of three
    for (const name of ["once", "twice", "three times"]) {
      const one = await open(browser, fromFile(4), `four times slower, ${name}`, Infinity);
      slow.push(Math.round(one.firstFrameMs));
      await one.context.close();
    }
    figures.slowFirstFrameMs = percentile(slow, 0.5);
    check(figures.slowFirstFrameMs < BARS.slowFirstFrameMs, `four times slower: first frame after ${slow.join(", ")} ms`);
  }
} finally {
  await browser.close();
}
console.log(JSON.stringify(figures));
for (const problem of problems.slice(0, 20)) console.error(problem);
process.exit(problems.length ? 1 : 0);
