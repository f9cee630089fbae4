// Opens every kind of report in a headless Chromium and looks at what people would see.
//   node reports_test.mjs CHROMIUM JACULUS SAMPLE_REPORTS PROBLEMS FOLDER
// Reports and screenshots go into FOLDER/<kind>; the last screenshots stay there to be looked at.

import { spawnSync } from 'node:child_process';
import { existsSync, mkdirSync, readdirSync, rmSync, statSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { startChromium } from './chromium.mjs';

const [chromium, jaculus, sampleReports, problems, folder] = process.argv.slice(2);
const MOST_BYTES = 5e6;
let failures = 0;

function check(condition, what) {
  if (condition) return;
  failures += 1;
  console.log(`FAILED ${what}`);
}

// Runs in the page: how many pixels of a canvas are not of its background.
const INK = `(canvas) => {
  const c = document.createElement('canvas');
  c.width = canvas.width; c.height = canvas.height;
  const ctx = c.getContext('2d');
  ctx.drawImage(canvas, 0, 0);
  const { data } = ctx.getImageData(0, 0, c.width, c.height);
  let ink = 0;
  for (let i = 3; i < data.length; i += 4) if (data[i] > 0) ink += 1;
  return ink;
}`;
// The line of a chart alone, not its axes: pixels within the plotting area in the colour of its first visible series.
const LINE_INK = `(u) => {
  const { left, top, width, height } = u.bbox;
  const data = u.ctx.getImageData(left, top, width, height).data;
  const probe = document.createElement('canvas').getContext('2d');
  const colours = u.series.slice(1).map((s) => (typeof s.stroke === 'function' ? s.stroke(u, 1) : s.stroke));
  let ink = 0;
  for (const colour of colours) {
    probe.clearRect(0, 0, 1, 1);
    probe.fillStyle = colour;
    probe.fillRect(0, 0, 1, 1);
    const [r, g, b, a] = probe.getImageData(0, 0, 1, 1).data;
    if (!a) continue;
    for (let i = 0; i < data.length; i += 4)
      if (Math.abs(data[i] - r) + Math.abs(data[i + 1] - g) + Math.abs(data[i + 2] - b) < 60 && data[i + 3] > 100) ink += 1;
  }
  return ink;
}`;

async function checkCharts(page, kind) {
  const charts = await page.evaluate(`jaculusReport.charts.map((c) => ({
    id: c.chart.id, ink: (${LINE_INK})(c.plot), width: c.plot.width, shown: c.figure.getClientRects().length > 0,
    legend: c.figure.querySelectorAll('.u-legend .u-series').length, series: c.chart.series.length }))`);
  for (const c of charts.filter((one) => one.shown)) {
    check(c.ink > 20, `${kind}: chart ${c.id} shows nothing (${c.ink} pixels of its lines)`);
    check(c.legend === c.series + 1, `${kind}: chart ${c.id} has ${c.legend} rows of legend for ${c.series} series`);
  }
  return charts.length;
}

/** The scrubber moves the figure and the charts' cursors. */
async function checkScrubber(page, kind) {
  const state = (share) => page.evaluate(`(async () => {
    const scrubber = document.querySelector('.scrubber');
    scrubber.value = ${share} * scrubber.max;
    scrubber.dispatchEvent(new Event('input'));
    await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
    const canvases = [...document.querySelectorAll('.animation canvas')];
    return {
      time: jaculusReport.clock.time,
      shown: document.querySelector('output.time').textContent,
      ink: canvases.map(${INK}),
      pictures: canvases.map((c) => c.toDataURL()),
      cursors: jaculusReport.charts.filter((c) => c.chart.overTime && c.figure.getClientRects().length).map((c) => c.plot.cursor.left),
    };
  })()`);
  const a = await state(0.2);
  const b = await state(0.6);
  check(b.time > a.time && a.shown !== b.shown, `${kind}: the scrubber does not move the time`);
  check(a.ink.length > 0 && a.ink.every((n) => n > 100), `${kind}: an animation is empty (${a.ink})`);
  check(a.pictures.some((p, i) => p !== b.pictures[i]), `${kind}: the scrubber does not move the figure`);
  check(b.cursors.some((left, i) => left > a.cursors[i] + 1), `${kind}: the scrubber does not move the charts' cursors`);
}

/** Dragging zooms, a double click brings everything back, the data behind a chart can be had. */
async function checkInteraction(page, kind) {
  const result = await page.evaluate(`(async () => {
    const c = jaculusReport.charts.find((one) => one.figure.getClientRects().length);
    const full = [c.plot.scales.x.min, c.plot.scales.x.max];
    const span = full[1] - full[0];
    c.zoom(full[0] + 0.4 * span, full[0] + 0.5 * span);
    await new Promise((done) => setTimeout(done, 30));
    const zoomed = c.plot.scales.x.max - c.plot.scales.x.min;
    c.plot.over.dispatchEvent(new MouseEvent('dblclick', { bubbles: true }));
    await new Promise((done) => setTimeout(done, 30));
    let saved = null;
    const make = URL.createObjectURL;
    URL.createObjectURL = (blob) => { saved = blob; return make.call(URL, blob); };
    HTMLAnchorElement.prototype.click = function () {};
    c.figure.querySelector('button').click();
    const text = saved && (await saved.text());
    return { zoomed: zoomed / span, back: (c.plot.scales.x.max - c.plot.scales.x.min) / span, rows: text && text.trim().split('\\n').length - 1,
             most: Math.max(...c.chart.series.map((s) => jaculusReport.data.array(s.x).length)) };
  })()`);
  check(Math.abs(result.zoomed - 0.1) < 0.01, `${kind}: a chart does not zoom (${result.zoomed})`);
  check(Math.abs(result.back - 1) < 0.01, `${kind}: a double click does not show everything (${result.back})`);
  check(result.rows === result.most, `${kind}: the data of a chart have ${result.rows} rows of ${result.most}`);
}

/** Smooth scrubbing: the time that 50 steps take. */
async function checkSpeed(page, kind) {
  const perStep = await page.evaluate(`(() => {
    const { clock } = jaculusReport;
    const start = performance.now();
    for (let i = 0; i < 50; i++) clock.set(clock.from + ((clock.to - clock.from) * i) / 50);
    return (performance.now() - start) / 50;
  })()`);
  console.log(`${kind}: ${perStep.toFixed(1)} ms a step of the scrubber`);
  check(perStep < 100, `${kind}: a step of the scrubber takes ${perStep} ms`);
}

async function checkNames(page, kind) {
  check(!(await page.evaluate('Boolean(window.hacked)')), `${kind}: a name ran as a script`);
  check((await page.evaluate("document.querySelectorAll('img, iframe, object, embed, link[rel=stylesheet], script[src]').length")) === 0,
    `${kind}: there are elements that nobody put there`);
  check((await page.evaluate("document.querySelectorAll('main script, main style, main b').length")) === 0, `${kind}: a name became markup`);
  const scripts = await page.evaluate('document.scripts.length');
  check(scripts === 2, `${kind}: ${scripts} scripts, of two`);
}

/** Mean brightness of the page's background, 0 to 255. */
const BACKGROUND = `(() => { const c = getComputedStyle(document.body).backgroundColor.match(/[\\d.]+/g).map(Number); return (c[0] + c[1] + c[2]) / 3; })()`;

async function checkReport(browser, kind, file) {
  const address = pathToFileURL(file).href;
  const bytes = statSync(file).size;
  check(bytes < MOST_BYTES, `${kind}: ${bytes} bytes`);
  const out = (name) => join(resolve(folder), kind, name);
  const page = await browser.open(address);
  const charts = await checkCharts(page, kind);
  const animated = await page.evaluate("document.querySelectorAll('.animation').length");
  if (animated) {
    await checkScrubber(page, kind);
    await checkSpeed(page, kind);
  }
  if (charts) await checkInteraction(page, kind);
  await checkNames(page, kind);
  check((await page.evaluate(BACKGROUND)) > 200, `${kind}: the light page is dark`);
  await page.screenshot(out('light.png'), { captureBeyondViewport: true, clip: { x: 0, y: 0, width: 1300, height: 2600, scale: 0.7 } });
  const pdf = await page.pdf(out('print.pdf'));
  check(pdf.length > 20000 && pdf.subarray(0, 5).toString() === '%PDF-', `${kind}: nothing is printed`);

  const dark = await browser.open(address, { dark: true });
  check((await dark.evaluate(BACKGROUND)) < 60, `${kind}: the dark page is light`);
  await checkCharts(dark, `${kind}, dark`);
  await dark.screenshot(out('dark.png'));
  // On paper: light, without controls, nothing wider than the page.
  await dark.call('Emulation.setEmulatedMedia', { media: 'print', features: [{ name: 'prefers-color-scheme', value: 'dark' }] });
  await dark.call('Emulation.setDeviceMetricsOverride', { width: 720, height: 1000, deviceScaleFactor: 1, mobile: false });
  await dark.evaluate("dispatchEvent(new Event('beforeprint'))");
  await dark.settle();
  check((await dark.evaluate(BACKGROUND)) > 200, `${kind}: paper is dark`);
  check(await dark.evaluate("[...document.querySelectorAll('.controls, .layers, figure button')].every((e) => e.getClientRects().length === 0)"),
    `${kind}: controls are printed`);
  check(await dark.evaluate('document.documentElement.scrollWidth <= 721'), `${kind}: the printed page is too wide`);
  await dark.screenshot(out('print.png'));

  const phone = await browser.open(address, { width: 390, height: 800 });
  check(await phone.evaluate('document.documentElement.scrollWidth <= 391'), `${kind}: too wide for a phone`);
  await phone.screenshot(out('phone.png'));
  for (const [p, medium] of [[page, 'screen'], [dark, 'dark and print'], [phone, 'phone']]) {
    check(p.errors.length === 0, `${kind}, ${medium}: ${p.errors.join('; ')}`);
    const outside = p.requests.filter((url) => !/^(file|data|blob|about):/.test(url));
    check(outside.length === 0, `${kind}, ${medium}: asks for ${outside}`);
    await p.close();
  }
  console.log(`${kind}: ${charts} charts, ${animated} animations, ${bytes} bytes`);
}

/** The robot in three dimensions moves with the scrubber. */
async function checkView(browser, file) {
  const page = await browser.open(pathToFileURL(file).href);
  const bytes = statSync(file).size;
  check(bytes < MOST_BYTES, `view: ${bytes} bytes`);
  check(await page.evaluate('jaculusView.drawn > 0'), 'view: nothing was drawn');
  const picture = async (share) => {
    await page.evaluate(`(() => { const { clock } = jaculusView; clock.set(clock.from + ${share} * (clock.to - clock.from)); })()`);
    await page.settle();
    return page.evaluate("document.querySelector('.stage3d canvas').toDataURL()");
  };
  const [a, b] = [await picture(0.1), await picture(0.9)];
  check(a !== b, 'view: the robot does not move');
  check(a.length > 5000, 'view: the picture is empty');
  check(page.errors.length === 0, `view: ${page.errors.join('; ')}`);
  check(page.requests.every((url) => /^(file|data|blob|about):/.test(url)), `view: asks for ${page.requests}`);
  await page.screenshot(join(file, '..', 'view.png'));
  await page.close();
  console.log(`view: ${bytes} bytes`);
}

/** Runs a program that must not fail. */
function run(program, ...argumentsOf) {
  const { status, stderr } = spawnSync(program, argumentsOf, { encoding: 'utf8' });
  check(status === 0, `${program} ${argumentsOf.join(' ')}: exit code ${status}, ${stderr}`);
}

/** One report of each kind, from the program where that takes seconds. */
function makeReports() {
  rmSync(folder, { recursive: true, force: true });
  mkdirSync(folder, { recursive: true });
  const problem = (name) => join(problems, `${name}.yaml`);
  const out = (kind) => ['--quiet', '--out', join(folder, kind)];
  run(jaculus, 'solve', problem('leap_tail'), ...out('solve'));
  run(jaculus, 'solve', problem('double_integrator'), ...out('solve_slider'));
  run(jaculus, 'compare', problem('leap_tailless'), problem('leap_tail'), ...out('compare'));
  run(jaculus, 'study', problem('fig4_shaft'), problem('fig6_drop'), problem('drag_bench'), problem('self_righting'), ...out('study'));
  run(jaculus, 'view', join(folder, 'solve'), '--quiet', '--out', join(folder, 'solve', 'view.html'));
  run(sampleReports, folder);
}

makeReports();
const browser = await startChromium(chromium);
try {
  const kinds = readdirSync(folder).filter((kind) => existsSync(join(folder, kind, 'report.html')));
  check(kinds.length > 0, `no report in ${folder}`);
  for (const kind of kinds) await checkReport(browser, kind, resolve(folder, kind, 'report.html'));
  await checkView(browser, resolve(folder, 'solve', 'view.html'));
} finally {
  await browser.close();
}
console.log(failures ? `${failures} failed` : 'all passed');
process.exitCode = failures ? 1 : 0;
