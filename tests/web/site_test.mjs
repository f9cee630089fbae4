// Opens pages of the built site in a headless Chromium, from the file system, and looks at what people would see.
//   node site_test.mjs CHROMIUM SITE

import { readFileSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { startChromium } from './chromium.mjs';

const [program, folder] = process.argv.slice(2);
const ready = "document.readyState === 'complete' && document.body.innerText.length > 100";
let failures = 0;

function check(condition, what) {
  if (condition) return;
  failures += 1;
  console.log(`FAILED ${what}`);
}

/** page: texts that it must show. */
const pages = {
  'index.html': ['A first leap', 'A plan in MuJoCo', 'jaculus.solve("leap_tail")'],
  'tutorial.html': ['jaculus solve'],
  'contributing.html': ['Longer checks', 'scripts/check'],
  'examples/first_leap.html': ['first_leap.ipynb', 'import jaculus'],
  'reference/command_solve.html': ['Usage: jaculus solve', '--override'],
  'reference/effects.html': ['tail_compliance', 'acts in tail_transmission'],
  'reference/settings.html': ['kept_singles'],
  'reference/problem_file.html': ['mean_acceleration', 'max_iterations'],
  'reference/python.html': ['to_joints', 'Solves a problem by direct collocation', 'Parameters'],
  'reference/cpp.html': ['tail_drag.h'],
  'cpp/index.html': ['jaculus'],
  'cpp/tail__drag_8h.html': ['Quasi-steady aerodynamic drag'],
};

async function checkPage(browser, name, texts) {
  const page = await browser.open(pathToFileURL(resolve(join(folder, name))).href, { ready });
  await page.settle();
  const shown = (await page.evaluate('document.body.innerText')).replace(/\s+/g, ' ');
  for (const text of texts) check(shown.includes(text), `${name}: '${text}' is not shown`);
  const hollow = await page.evaluate('[...document.images].filter((i) => !i.naturalWidth).map((i) => i.src)');
  check(hollow.length === 0, `${name}: no picture at ${hollow}`);
  const wide = await page.evaluate('document.documentElement.scrollWidth - innerWidth');
  check(wide <= 0, `${name}: ${wide} pixels wider than the window`);
  check(page.errors.length === 0, `${name}: ${page.errors.join('; ')}`);
  const elsewhere = page.requests.filter((address) => !/^(file|data|blob):/.test(address));
  check(elsewhere.length === 0, `${name}: asks for ${elsewhere}`);
  return page;
}

/** The search, which runs in the page, finds an effect. */
async function checkSearch(page) {
  const found = await page.evaluate(`(async () => {
    const field = document.querySelector('.md-search__input');
    field.focus();
    field.value = 'tail_compliance';
    field.dispatchEvent(new Event('input', { bubbles: true }));
    field.dispatchEvent(new KeyboardEvent('keyup', { bubbles: true }));
    for (let k = 0; k < 200; ++k) {
      const links = [...document.querySelectorAll('.md-search-result__link')].map((a) => a.getAttribute('href'));
      if (links.length) return links;
      await new Promise((done) => setTimeout(done, 50));
    }
    return [];
  })()`);
  check(found.some((link) => link.includes('effects.html')), `the search leads to ${found}`);
}

const browser = await startChromium(program);
try {
  for (const [name, texts] of Object.entries(pages)) {
    const page = await checkPage(browser, name, texts);
    if (name === 'index.html') await checkSearch(page);
  }
  const notebook = JSON.parse(readFileSync(join(folder, 'examples/first_leap.ipynb'), 'utf8'));
  check(notebook.cells.some((cell) => cell.cell_type === 'code'), 'first_leap.ipynb has no code');
} finally {
  await browser.close();
}
console.log(failures ? `${failures} faults` : `${Object.keys(pages).length} pages as they should be`);
process.exit(failures ? 1 : 0);
