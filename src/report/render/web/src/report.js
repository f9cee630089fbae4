// A report: reads the data that stands in the page and builds the page from it. Text is only ever set as text.

import 'uplot/dist/uPlot.min.css';
import './report.css';
import { makeAnimation, spanOf } from './animation.js';
import { makeBars, makeChoice, makeDrawing, makeHeatMap, makePicture, makeTable } from './blocks.js';
import { makeChart } from './chart.js';
import { makeClock, makeControls } from './clock.js';
import { element, readData } from './data.js';
import { lowerBound } from './thin.js';

function header(data) {
  const head = element('header');
  head.append(element('h1', '', data.title), element('p', 'caption', data.caption));
  for (const [question, sentence] of data.summary)
    head.append(element('p', 'summary', null, element('strong', '', question), element('span', '', sentence)));
  if (data.picture.panels.length) makePicture(data.picture, head);
  if (data.facts.length) {
    const facts = element('dl', 'facts');
    for (const [name, value] of data.facts) facts.append(element('div', '', null, element('dt', '', name), element('dd', '', value)));
    head.append(facts);
  }
  for (const notice of data.notices) head.append(element('p', 'notice', notice));
  return head;
}

function clockOf(data) {
  const spans = [];
  for (const section of data.sections) {
    for (const animation of section.animations) spans.push(spanOf(animation, data));
  }
  if (!spans.length) return null;
  return makeClock(Math.min(...spans.map((s) => s[0])), Math.max(...spans.map((s) => s[1])));
}

/** The nearest point of the chart's first series to a value of x. */
function nearest(chart, data, x) {
  const xs = data.array(chart.series[0].x);
  const after = Math.min(lowerBound(xs, x), xs.length - 1);
  const before = Math.max(0, after - 1);
  return Math.abs(xs[before] - x) < Math.abs(xs[after] - x) ? before : after;
}

function build(data) {
  const main = document.getElementById('report');
  main.append(header(data));
  const clock = clockOf(data);
  const charts = [];
  const chosenBy = new Map();
  if (clock) main.append(makeControls(clock));
  for (const section of data.sections) {
    const place = element(section.folded ? 'details' : 'section');
    place.append(element(section.folded ? 'summary' : 'h2', '', section.title));
    main.append(place);
    for (const paragraph of section.text) place.append(element('p', '', paragraph));
    for (const animation of section.animations) makeAnimation(animation, data, place, clock);
    const pictures = element('div', 'grid');
    const grid = element('div', 'grid');
    for (const table of section.tables) makeTable(table, place);
    for (const bars of section.bars) makeBars(bars, pictures);
    for (const map of section.heatMaps) makeHeatMap(map, pictures);
    for (const drawing of section.drawings) makeDrawing(drawing, pictures);
    if (pictures.children.length) place.append(pictures);
    place.append(grid);
    for (const choice of section.choices) {
      const choose = makeChoice(choice, grid);
      if (choice.chart) chosenBy.set(choice.chart, (i) => choose(Math.min(i, choice.drawings.length - 1)));
    }
    for (const chart of section.charts) {
      const choose = chosenBy.get(chart.id);
      charts.push(makeChart(chart, data, grid, { onPick: choose && ((x) => choose(nearest(chart, data, x))) }));
    }
  }
  main.append(element('footer', '', `jaculus ${data.version}`));
  const moving = charts.filter((c) => c.chart.overTime);
  if (clock) {
    clock.follow((t) => moving.forEach((c) => c.setTime(t)));
    for (const c of moving) c.plot.over.addEventListener('click', () => clock.set(c.plot.posToVal(c.plot.cursor.left, 'x')));
  }
  if (clock) requestAnimationFrame(() => clock.set(clock.time));  // charts know their scales by then
  addEventListener('beforeprint', () => main.querySelectorAll('details').forEach((d) => (d.open = true)));
  // For tests: what stands on the page.
  window.jaculusReport = { data, clock, charts };
  document.documentElement.classList.add('ready');
}

build(readData('data'));
