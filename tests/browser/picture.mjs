// Makes the picture of the README from a report: the verdict board and the head of the ledger.
//
// usage: node picture.mjs REPORT.html OUT.png
import { existsSync } from "node:fs";
import { pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

const [report, out] = process.argv.slice(2);
const executablePath = [process.env.CHROMIUM, "/usr/bin/chromium", "/usr/bin/google-chrome"].find((path) => path && existsSync(path));
const browser = await chromium.launch({ executablePath, args: ["--no-sandbox", "--disable-gpu", "--disable-background-networking"] });
const page = await browser.newPage({ viewport: { width: 1240, height: 1180 }, colorScheme: "light" });
await page.goto(pathToFileURL(report).href);
await page.screenshot({ path: out });
await browser.close();
