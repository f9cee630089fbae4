// Pictures of reports for the README.
//   node screenshots.mjs CHROMIUM FOLDER REPORT.html NAME [SHARE [SELECTOR]]
// FOLDER/NAME.png shows the report with its scrubber at SHARE of the time, from the element SELECTOR on.

import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { startChromium } from './chromium.mjs';

const [program, folder, report, name, share = '0.6', selector = 'main'] = process.argv.slice(2);
const WIDTH = 1500;
const HEIGHT = 1250;
const browser = await startChromium(program);
try {
  const page = await browser.open(pathToFileURL(resolve(report)).href, { width: WIDTH, height: HEIGHT });
  await page.evaluate(`{ const { clock } = jaculusReport; if (clock) clock.set(clock.from + ${Number(share)} * (clock.to - clock.from)); }`);
  await page.settle();
  const top = await page.evaluate(`document.querySelector(${JSON.stringify(selector)}).getBoundingClientRect().top + scrollY`);
  await page.screenshot(join(folder, `${name}.png`), {
    captureBeyondViewport: true,
    clip: { x: 0, y: Math.max(0, top - 10), width: WIDTH, height: HEIGHT, scale: 0.72 },
  });
  if (page.errors.length) throw new Error(page.errors.join('; '));
} finally {
  await browser.close();
}
