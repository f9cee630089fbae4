// What is no chart: tables, bars with intervals, heat maps, drawings to scale.

import { element, shown } from './data.js';
import { boundsOf } from './frames.js';

const SVG = 'http://www.w3.org/2000/svg';
const numeric = /^[+\-−]?\d[\d.,eE+\-−]*( ?%| \*)?$|^[-–]$/;

export function makeTable(table, place) {
  const wrap = element('div', 'table');
  if (table.title) wrap.append(element('h3', '', table.title));
  const made = element('table');
  const head = element('tr');
  for (const column of table.columns) head.append(element('th', '', column));
  made.append(element('thead', '', null, head));
  const body = element('tbody');
  for (const row of table.rows) {
    const line = element('tr');
    row.forEach((cell, i) => line.append(element(i ? 'td' : 'th', numeric.test(cell) ? 'number' : '', cell)));
    body.append(line);
  }
  made.append(body);
  wrap.append(element('div', 'scroll', null, made));
  if (table.note) wrap.append(element('p', 'note', table.note));
  place.append(wrap);
}

/** 0.93 as "93 %" where the unit is that of a ratio. */
function amount(value, unit) {
  if (value === null) return '–';
  return unit === '-' ? `${(100 * value).toFixed(1)} %` : `${shown(value)} ${unit}`;
}

export function makeBars(bars, place) {
  const figure = element('figure', 'bars');
  figure.id = `bars-${bars.id}`;
  figure.append(element('h3', '', bars.title));
  const values = bars.items.flatMap((i) => [i.value, i.low, i.high]).filter((v) => v !== null);
  const low = Math.min(0, ...values);
  const high = Math.max(bars.unit === '-' ? 1 : 0, ...values);
  const share = (v) => (100 * (v - low)) / (high - low || 1);
  for (const item of bars.items) {
    const track = element('div', 'track');
    if (item.value !== null) {
      const bar = element('div', 'bar');
      bar.style.left = `${Math.min(share(0), share(item.value))}%`;
      bar.style.width = `${Math.abs(share(item.value) - share(0))}%`;
      track.append(bar);
    }
    if (item.low !== null && item.high !== null) {
      const interval = element('div', 'interval');
      interval.style.left = `${share(item.low)}%`;
      interval.style.width = `${share(item.high) - share(item.low)}%`;
      track.append(interval);
    }
    const range = item.low !== null && item.high !== null ? ` (${amount(item.low, bars.unit)} to ${amount(item.high, bars.unit)})` : '';
    figure.append(
      element('div', 'item', null, element('span', 'label', item.label), track,
        element('span', 'amount', amount(item.value, bars.unit) + range), element('span', 'note', item.note)),
    );
  }
  if (bars.caption) figure.append(element('figcaption', '', bars.caption));
  place.append(figure);
}

/** 0 to 1 as a colour between the page's and the accent. */
function heat(share) {
  return `color-mix(in srgb, var(--heat) ${Math.round(100 * Math.min(1, Math.max(0, share)))}%, var(--cold))`;
}

export function makeHeatMap(map, place) {
  const figure = element('figure', 'heat');
  figure.id = `heat-${map.id}`;
  figure.append(element('h3', '', map.title));
  const most = Math.max(1e-12, ...map.values.flat().filter((v) => v !== null));
  const table = element('table');
  const corner = element('th', 'corner', `${map.rowTitle} ↓   ${map.columnTitle} →`);
  table.append(element('thead', '', null, element('tr', '', null, corner, ...map.columns.map((c) => element('th', '', c)))));
  const body = element('tbody');
  map.rows.forEach((name, r) => {
    const line = element('tr', '', null, element('th', '', name));
    map.columns.forEach((column, c) => {
      const value = map.values[r][c];
      const cell = element('td', 'number', value === null ? '' : shown(value));
      cell.title = `${name}, ${column}: ${shown(value)}`;
      if (value !== null) {
        cell.style.background = heat(value / most);
        if (value / most > 0.55) cell.classList.add('hot');
      }
      line.append(cell);
    });
    body.append(line);
  });
  table.append(body);
  figure.append(element('div', 'scroll', null, table));
  if (map.caption) figure.append(element('figcaption', '', map.caption));
  place.append(figure);
}

function svg(tag, attributes, ...children) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

/** Lines to scale with a bar for the scale; parts with a value are coloured by it. */
export function drawingSvg(drawing, box) {
  const pad = 0.08 * Math.max(box.right - box.left, box.high - box.low) + 0.02;
  const [left, top] = [box.left - pad, -(box.high + pad)];
  const [width, height] = [box.right - box.left + 2 * pad, box.high - box.low + 3 * pad];
  const picture = svg('svg', { viewBox: `${left} ${top} ${width} ${height}`, role: 'img', 'aria-label': drawing.title });
  for (const part of drawing.parts) {
    const line = svg('polyline', {
      points: part.line.map(([x, z]) => `${x},${-z}`).join(' '),
      fill: 'none',
      'stroke-width': part.width,
      'stroke-linecap': 'round',
      'stroke-linejoin': 'round',
      class: part.style || (part.value === null ? 'plain' : 'valued'),
    });
    if (part.style === 'assumed') line.setAttribute('stroke-dasharray', `${2 * part.width} ${2.5 * part.width}`);
    if (part.value !== null) line.style.stroke = heat(part.value);
    const title = svg('title', {});
    title.textContent = part.text || part.name;
    line.append(title);
    picture.append(line);
  }
  const step = width > 1.5 ? 0.5 : width > 0.6 ? 0.2 : 0.1;
  const y = -(box.low - 1.2 * pad);
  picture.append(svg('line', { x1: left + pad / 2, x2: left + pad / 2 + step, y1: y, y2: y, class: 'ruler', 'stroke-width': width / 250 }));
  const label = svg('text', { x: left + pad / 2 + step + width / 80, y: y + width / 120, 'font-size': width / 28, class: 'ruler' });
  label.textContent = `${step} m`;
  picture.append(label);
  return picture;
}

export function boxOf(drawings) {
  return boundsOf(drawings.flatMap((d) => d.parts.map((p) => p.line.flat())));
}

export function makeDrawing(drawing, place) {
  const figure = element('figure', 'drawing');
  figure.id = `drawing-${drawing.id}`;
  figure.append(element('h3', '', drawing.title), drawingSvg(drawing, boxOf([drawing])));
  const named = drawing.parts.filter((p) => p.value !== null && p.text);
  if (named.length) figure.append(element('ul', 'legend', null, ...named.map((p) => element('li', '', p.text))));
  if (drawing.caption) figure.append(element('figcaption', '', drawing.caption));
  place.append(figure);
}

/** Drawings side by side at one scale, with what their styles mean. */
export function makePicture(picture, place) {
  const figure = element('figure', 'drawing picture');
  figure.id = `picture-${picture.id}`;
  const box = boxOf(picture.panels);
  const panels = element('div', 'panels');
  for (const drawing of picture.panels)
    panels.append(element('div', 'panel', null, element('h4', '', drawing.title), drawingSvg(drawing, box), element('p', 'note', drawing.caption)));
  const legend = element('p', 'meanings');
  for (const [style, meaning] of picture.legend) legend.append(element('span', style, meaning));
  figure.append(element('h3', '', picture.title), panels, legend);
  if (picture.caption) figure.append(element('figcaption', '', picture.caption));
  place.append(figure);
}

/** One of several drawings, chosen from a list or by the points of a chart. Returns choose(index). */
export function makeChoice(choice, place) {
  const figure = element('figure', 'drawing choice');
  figure.id = `choice-${choice.id}`;
  const list = element('select');
  list.setAttribute('aria-label', choice.title);
  choice.labels.forEach((label, i) => {
    const option = element('option', '', label);
    option.value = i;
    list.append(option);
  });
  const stage = element('div', 'stage');
  const text = element('figcaption');
  const box = boxOf(choice.drawings);
  const choose = (index) => {
    list.value = index;
    stage.replaceChildren(drawingSvg(choice.drawings[index], box));
    text.textContent = choice.drawings[index].caption;
  };
  list.addEventListener('change', () => choose(Number(list.value)));
  figure.append(element('div', 'head', null, element('h3', '', choice.title), list), stage, text);
  place.append(figure);
  choose(choice.chosen);
  return choose;
}
