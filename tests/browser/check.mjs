// Opens a report in headless Chromium and prints what it finds as JSON: {"ran": false, "because": ...} where no
// browser is at hand, else {"ran": true, "failures": [...], "facts": {...}}.
//
// usage: node check.mjs REPORT.html
import { existsSync, readFileSync, statSync } from "node:fs";
import { createRequire } from "node:module";
import { pathToFileURL } from "node:url";

const file = process.argv[2];
const say = (answer) => { process.stdout.write(`${JSON.stringify(answer)}\n`); process.exit(0); };

const browsers = [process.env.CHROMIUM, "/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"];
const executablePath = browsers.find((path) => path && existsSync(path));
if (!executablePath) say({ ran: false, because: "no Chromium on this machine" });
let chromium;
let HtmlValidate;
let axe;
try {
  ({ chromium } = await import("playwright-core"));
  ({ HtmlValidate } = await import("html-validate"));
  axe = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");
} catch (error) {
  say({ ran: false, because: `npm packages are missing (tests/browser/setup.sh installs them): ${error.code}` });
}

const failures = [];
const facts = {};
const expect = (holds, what) => { if (!holds) failures.push(what); };
const address = pathToFileURL(file).href;

// Size and mark-up.
facts.bytes = statSync(file).size;
expect(facts.bytes <= 3 * 1024 * 1024, `the page has ${facts.bytes} bytes, more than 3 MiB`);
const validator = new HtmlValidate({ extends: ["html-validate:recommended"] });
const report = await validator.validateFile(file);
for (const message of report.results.flatMap((result) => result.messages).slice(0, 20)) {
  failures.push(`html-validate ${message.ruleId} at line ${message.line}: ${message.message}`);
}

const browser = await chromium.launch({
  executablePath,
  args: ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync"],
});

/** A page that reports every message and every request. */
const open = async (options, hash = "") => {
  const context = await browser.newContext(options);
  const page = await context.newPage();
  const name = JSON.stringify(options);
  page.on("console", (message) => failures.push(`console ${message.type()} in ${name}: ${message.text()}`));
  page.on("pageerror", (error) => failures.push(`error in ${name}: ${error.message}`));
  page.on("request", (request) => {
    if (!request.url().startsWith("file:") && !request.url().startsWith("data:")) {
      failures.push(`request in ${name}: ${request.url()}`);
    }
  });
  page.on("dialog", (dialog) => { failures.push(`dialog: ${dialog.message()}`); dialog.dismiss(); });
  await page.goto(address + hash);
  return page;
};

// No horizontal scroll at three widths, folded and unfolded.
for (const width of [360, 768, 1440]) {
  const page = await open({ viewport: { width, height: 900 } });
  for (const unfolded of [false, true]) {
    if (unfolded) {
      await page.evaluate(() => document.querySelectorAll("details").forEach((d) => { d.open = true; }));
    }
    const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    expect(wide <= 0, `at ${width} px the page is ${wide} px too wide${unfolded ? " when unfolded" : ""}`);
  }
  await page.context().close();
}

// Axe in both themes, everything unfolded.
for (const colorScheme of ["light", "dark"]) {
  const page = await open({ viewport: { width: 1280, height: 900 }, colorScheme });
  await page.evaluate(() => document.querySelectorAll("details").forEach((d) => { d.open = true; }));
  const review = page.locator("#review");
  if (await review.isVisible()) await review.click();
  await page.evaluate(axe);
  const { violations } = await page.evaluate(() => globalThis.axe.run(document, { resultTypes: ["violations"] }));
  for (const violation of violations) {
    const where = violation.nodes.slice(0, 3).map((node) => node.target.join(" ")).join("; ");
    failures.push(`axe ${violation.id} in ${colorScheme}: ${violation.help} (${violation.nodes.length}: ${where})`);
  }
  await page.context().close();
}

// Complete without JavaScript: the same words, and every part of the page in view.
{
  const words = async (options) => {
    const page = await open(options);
    const text = await page.locator("main > section").allInnerTexts();
    const drawings = await page.locator("svg.plot").count();
    const tools = await page.locator(".tools").isVisible();
    await page.context().close();
    return { text: text.join("\n").replace(/\bCopy\b|takes (less than )?[\d.e+-]+ s to compute/g, "").replace(/\s+/g, " "), drawings, tools };
  };
  const without = await words({ javaScriptEnabled: false, viewport: { width: 1280, height: 900 } });
  const scripted = await words({ viewport: { width: 1280, height: 900 } });
  expect(without.text === scripted.text, "without JavaScript the words differ");
  expect(without.drawings === scripted.drawings && without.drawings > 0, "without JavaScript drawings are missing");
  expect(!without.tools, "without JavaScript the tools, which need it, are shown");
  facts.drawings = without.drawings;
}

// Behaviour: address, search, filter, theme, review, keys. Without motion: while the page scrolls smoothly to a claim the
// tools move until they stick, and a button that is pressed meanwhile may be let go beside it.
{
  const page = await open({ viewport: { width: 1280, height: 900 }, reducedMotion: "reduce" });
  /** What a page does some time after it was asked to: a change of address is handled in a task of its own. */
  const becomes = async (what, holds, given) => {
    await page.waitForFunction(holds, given, { timeout: 10000 }).catch(() => failures.push(what));
  };
  const claims = page.locator(".claim");
  facts.claims = await claims.count();
  if (facts.claims > 0) {
    const id = await claims.last().getAttribute("id");
    await page.goto(`${address}#${id}`);
    await becomes("the address of a claim does not open it", (id) => document.querySelector(`#${id} details`).open, id);
    await page.keyboard.press("/");
    await page.keyboard.type(id.toLowerCase());
    expect(await page.locator(`#${id}`).isVisible(), "searching a claim hides it");
    await becomes("the search does not stand in the address", () => location.hash.includes("q="));
    await page.locator("#search").fill("no such words anywhere");
    expect(await claims.filter({ visible: true }).count() === 0, "the search hides nothing");
    await page.keyboard.press("Escape");
    expect(await claims.filter({ visible: true }).count() === facts.claims, "Escape does not clear the search");
    const verdict = await claims.last().getAttribute("data-verdict");
    await page.locator(`#show-${verdict}`).uncheck();
    expect(!(await page.locator(`#${id}`).isVisible()), "the filter hides nothing");
    await page.locator(`#show-${verdict}`).check();
    await page.keyboard.press("j");
    await becomes("the key j goes nowhere", () => /^#C\d+$/.test(location.hash)
      && document.querySelector(`${location.hash} details`).open);
    await page.locator("#review").click();
    await becomes("the button Review does nothing", () => document.querySelector("#review").getAttribute("aria-pressed") === "true");
    await page.locator(`#${id} textarea`).fill("a note");
    await page.locator(`#${id} select`).selectOption("2");
    const download = page.waitForEvent("download");
    await page.locator("#export-json").click();
    const notes = JSON.parse(readFileSync(await (await download).path(), "utf8"));
    const row = notes.claims.find((claim) => claim.claim === id);
    expect(row?.note === "a note" && row.judgement === "I disagree", "the exported notes lack the note");
    facts.questions = await page.locator(".check").count();
    expect(notes.checklist.length === facts.questions, "the exported checklist is not that of the page");
    for (const item of notes.checklist) {
      expect(item.text && item.answer && item.evidence && item.source, `the exported line ${item.question} is not filled in`);
      for (const target of item.see) {
        expect(await page.locator(`[id="${target.slice(1)}"]`).count() === 1, `${item.question} points at ${target}, which is not there`);
      }
    }
    const markdown = page.waitForEvent("download");
    await page.locator("#export-md").click();
    const text = readFileSync(await (await markdown).path(), "utf8");
    expect(text.includes(`**${id}**`) && text.includes("> a note"), "the exported Markdown lacks the note");
    expect(facts.questions === 0 || /- \[[ x]\] \*\*R01\*\* .*the report says/.test(text), "the exported Markdown lacks the checklist");
  }
  const ground = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
  const before = await ground();
  await page.locator("#theme").click();
  await page.locator("#theme").click();
  expect(await ground() !== before, "the theme does not change");
  await page.context().close();
}

// Filters and views work without JavaScript, and downloads hold what they say.
{
  const page = await open({ javaScriptEnabled: false, viewport: { width: 1280, height: 900 } });
  const filter = page.locator(".filters input").first();
  if (await filter.count()) {
    const verdict = (await filter.getAttribute("id")).slice(5);
    await filter.uncheck();
    expect(await page.locator(`.claim.v-${verdict}`).filter({ visible: true }).count() === 0, "the filter needs JavaScript");
  }
  const views = page.locator(".views").first();
  if (await views.count()) {
    const card = page.locator(".card:has(.views)").first();
    await card.locator("input[value=full]").check();
    expect(await card.locator(".view.full").isVisible() && !(await card.locator(".view.paper").isVisible()),
      "the switch of axes needs JavaScript");
  }
  const files = await page.locator("a[download]").evaluateAll((links) => links.map((a) => [a.download, a.getAttribute("href")]));
  for (const [name, href] of files) {
    const [kind, ...payload] = href.split(",");
    const text = decodeURIComponent(payload.join(","));
    if (name.endsWith(".csv")) {
      expect(kind.startsWith("data:text/csv") && text.includes(",") && text.endsWith("\n"), `${name} is no CSV`);
    } else {
      expect(kind === "data:image/svg+xml" && text.startsWith("<svg"), `${name} is no SVG`);
    }
  }
  facts.files = files.length;
  await page.context().close();
}
{
  // Every drawing to download is well-formed on its own.
  const page = await open({});
  const broken = await page.evaluate(() => [...document.querySelectorAll("a[download$='.svg']")].filter((a) => {
    const text = decodeURIComponent(a.getAttribute("href").slice("data:image/svg+xml,".length));
    return new DOMParser().parseFromString(text, "image/svg+xml").querySelector("parsererror");
  }).map((a) => a.download));
  for (const name of broken) failures.push(`${name} is not well-formed`);
  const paint = await page.evaluate(() => performance.getEntriesByName("first-contentful-paint")[0]?.startTime ?? null);
  facts.first_paint_ms = paint === null ? null : Math.round(paint);
  await page.context().close();
}

// Print: claims do not break across pages, tools are gone.
{
  const page = await open({ viewport: { width: 794, height: 1123 } });
  await page.emulateMedia({ media: "print" });
  expect(!(await page.locator(".tools").isVisible()), "the tools are printed");
  const broken = await page.locator(".claim").evaluateAll((all) =>
    all.filter((claim) => getComputedStyle(claim).breakInside !== "avoid").length);
  expect(broken === 0, `${broken} claims may break across pages`);
  const pdf = await page.pdf({ format: "A4" });
  facts.pdf_bytes = pdf.length;
  await page.context().close();
}

await browser.close();
say({ ran: true, failures, facts });
