// Charts by uPlot: zoom by dragging (double click: all), values under the cursor, series switched in the legend, cursors in step
// across charts over time, data as CSV.

import uPlot from 'uplot';
import { axisTitle, download, element, shown } from './data.js';
import { marksPlugin } from './marks.js';
import { colour, onTheme, paletteColour } from './theme.js';
import { thin } from './thin.js';

const PRINT_WIDTH = 680;
const HEIGHT = 260;

/** x that rises strictly, as uPlot joins series by it: the second sample of an instant comes a hair later. */
function rising(x) {
  const out = Float64Array.from(x);
  const hair = Math.abs(out[out.length - 1] - out[0]) * 1e-7 || 1e-12;
  for (let i = 1; i < out.length; i++) if (out[i] <= out[i - 1]) out[i] = out[i - 1] + hair;
  return out;
}

function sorted(x, ys) {
  let inOrder = true;
  for (let i = 1; i < x.length && inOrder; i++) inOrder = !(x[i] < x[i - 1]);
  if (inOrder) return [x, ys];
  const order = [...x.keys()].sort((a, b) => x[a] - x[b]);
  return [order.map((i) => x[i]), ys.map((y) => order.map((i) => y[i]))];
}

/** The series of a chart with their numbers, bands as two more series behind their own. */
function readSeries(chart, data) {
  return chart.series.map((s, index) => {
    const low = data.array(s.low);
    const high = data.array(s.high);
    const ys = [data.array(s.y), ...(low.length ? [low, high] : [])];
    const [x, columns] = sorted(data.array(s.x), ys);
    return { ...s, hue: s.colour >= 0 ? s.colour : index, x: rising(x), columns, banded: low.length > 0 };
  });
}

/** What uPlot draws between two values of x: all series joined on one x; undefined: no sample here, null: a gap. */
function joined(series, from, to) {
  const tables = series.map((s) => {
    const kept = thin(s.x, s.columns[0], from, to);
    return [kept.map((i) => s.x[i]), ...s.columns.map((c) => kept.map((i) => (Number.isNaN(c[i]) ? null : c[i])))];
  });
  if (!tables.length) return [[]];
  return tables.length === 1 ? tables[0] : uPlot.join(tables);
}

function extent(series, logarithmic) {
  let low = Infinity;
  let high = -Infinity;
  for (const s of series) {
    for (const x of s.x) {
      if (!Number.isFinite(x) || (logarithmic && x <= 0)) continue;
      low = Math.min(low, x);
      high = Math.max(high, x);
    }
  }
  if (low > high) return [0, 1];
  if (low === high) return [low - 0.5, high + 0.5];
  return [low, high];
}

function csv(chart, series) {
  const quoted = (text) => `"${String(text).replace(/"/g, '""')}"`;
  const shared = series.every((s) => chart.series[0].x === s.key);
  const columns = [];
  series.forEach((s, i) => {
    if (!shared || i === 0) columns.push([quoted(axisTitle(chart.x) + (shared ? '' : ` of ${s.name}`)), s.whole.x]);
    const names = [s.name, `${s.name}, lower`, `${s.name}, upper`];
    const unit = chart.y.unit && chart.y.unit !== '-' ? ` [${chart.y.unit}]` : '';
    s.whole.ys.forEach((y, k) => columns.push([quoted(names[k] + unit), y]));
  });
  const rows = Math.max(0, ...columns.map(([, values]) => values.length));
  const lines = [columns.map(([name]) => name).join(',')];
  for (let r = 0; r < rows; r++) {
    lines.push(columns.map(([, v]) => (r < v.length && !Number.isNaN(v[r]) ? Number(v[r].toPrecision(8)) : '')).join(','));
  }
  return lines.join('\n') + '\n';
}

function seriesOptions(chart, series) {
  const options = [{ label: axisTitle(chart.x), value: (u, v) => (v === null ? '–' : shown(v)) }];
  const bands = [];
  const unit = chart.y.unit && chart.y.unit !== '-' ? ` ${chart.y.unit}` : '';
  for (const s of series) {
    const points = s.style === 'points';
    const own = options.length;
    options.push({
      label: s.name,
      stroke: () => paletteColour(s.hue),
      width: points ? 0 : 1.75,
      dash: s.style === 'dashed' ? [6, 4] : undefined,
      paths: points ? () => null : s.style === 'steps' ? uPlot.paths.stepped({ align: 1 }) : undefined,
      points: { show: points, size: 7, fill: () => paletteColour(s.hue) },
      value: (u, v) => (v === null || v === undefined ? '–' : shown(v) + unit),
    });
    if (!s.banded) continue;
    const edge = { stroke: 'transparent', width: 0, points: { show: false }, label: '' };
    options.push({ ...edge }, { ...edge });
    bands.push({ series: [own + 2, own + 1], fill: () => paletteColour(s.hue) + '33', own });
  }
  return [options, bands];
}

function axes(chart) {
  const look = {
    stroke: () => colour('--ink'),
    grid: { stroke: () => colour('--grid'), width: 1 },
    ticks: { stroke: () => colour('--grid'), width: 1 },
    font: '12px system-ui, sans-serif',
    labelFont: '12px system-ui, sans-serif',
    labelSize: 20,
  };
  const values = (u, splits) => splits.map((v) => (v === null ? '' : shown(v)));
  return [
    { ...look, label: axisTitle(chart.x), values, size: 34 },
    { ...look, label: axisTitle(chart.y), values, size: (u, v) => 22 + 7 * Math.max(2, ...(v || []).map((t) => t.length)) },
  ];
}

/** The scale of y: as the axis says, else what the data and the horizontal marks need. */
function scaleY(axis, marks) {
  const made = { distr: axis.log ? 3 : 1 };
  const [low, high] = axis.range;
  const heights = marks.map((m) => m.y).filter((y) => y !== null && (!axis.log || y > 0));
  if (low !== null && high !== null) made.range = [low, high];
  else if (heights.length && !axis.log) {
    made.range = (u, least, most) => uPlot.rangeNum(Math.min(least, ...heights), Math.max(most, ...heights), 0.1, true);
  }
  return made;
}

/** Makes one chart inside `place`. Returns what the scrubber and tests need of it. */
export function makeChart(chart, data, place, hooks = {}) {
  const series = readSeries(chart, data);
  series.forEach((s, i) => {
    const given = chart.series[i];
    const ys = [given.y, given.low, given.high].filter((a) => a !== null && a !== undefined);
    s.key = given.x;
    s.whole = { x: data.array(given.x), ys: ys.map((a) => data.array(a)) };
  });
  const figure = element('figure', 'chart');
  figure.id = `chart-${chart.id}`;
  const save = element('button', 'quiet', 'data (CSV)');
  save.type = 'button';
  save.addEventListener('click', () => download(`${chart.id}.csv`, csv(chart, series), 'text/csv'));
  const canvas = element('div', 'plot');
  figure.append(element('div', 'head', null, element('h3', '', chart.title), save), canvas);
  if (chart.caption) figure.append(element('figcaption', '', chart.caption));
  place.append(figure);

  const full = extent(series, chart.x.log);
  const [options, bands] = seriesOptions(chart, series);
  let busy = false;  // while zooming changes the data that zooming looks at
  const show = (u, from, to) => {
    busy = true;
    u.batch(() => {
      u.setData(joined(series, from, to), false);
      u.setScale('x', { min: from, max: to });
    });
    busy = false;
  };
  const width = () => Math.max(260, Math.floor(canvas.clientWidth));
  const plot = new uPlot(
    {
      width: width(),
      height: HEIGHT,
      pxAlign: 0,
      scales: { x: { time: false, distr: chart.x.log ? 3 : 1 }, y: scaleY(chart.y, chart.marks) },
      series: options,
      bands,
      axes: axes(chart),
      legend: { live: true },
      cursor: {
        y: false,
        points: { size: 7 },
        drag: { x: true, y: false, dist: 4 },
        sync: chart.overTime ? { key: 'time', scales: ['x', null], setSeries: false } : undefined,
        bind: {
          dblclick: (u) => () => {
            show(u, ...full);
            return null;
          },
        },
      },
      hooks: {
        setScale: [
          (u, key) => {
            if (key !== 'x' || busy || u.status !== 1) return;
            const { min, max } = u.scales.x;
            queueMicrotask(() => show(u, Math.max(min, full[0]), Math.min(max, full[1])));
          },
        ],
        setSeries: [
          (u, index, change) => {
            if (change.show === undefined) return;
            for (const b of bands) if (b.own === index) b.series.forEach((k) => u.setSeries(k, { show: change.show }));
          },
        ],
      },
      plugins: [marksPlugin(chart.marks)],
    },
    joined(series, ...full),
    canvas,
  );
  busy = true;
  plot.setScale('x', { min: full[0], max: full[1] });
  queueMicrotask(() => (busy = false));
  const rows = plot.root.querySelectorAll('.u-legend .u-series');
  for (const b of bands) b.series.forEach((k) => rows[k].remove());
  if (hooks.onPick) plot.over.addEventListener('click', () => hooks.onPick(plot.posToVal(plot.cursor.left, 'x'), plot));

  new ResizeObserver(() => {
    if (!document.documentElement.classList.contains('printing')) plot.setSize({ width: width(), height: HEIGHT });
  }).observe(canvas);
  onTheme(({ printing }) => {
    plot.setSize({ width: printing ? Math.min(width(), PRINT_WIDTH) : width(), height: HEIGHT });
    plot.redraw(true, true);
  });
  return {
    chart,
    plot,
    figure,
    setTime(t) {
      const { min, max } = plot.scales.x;
      const outside = t < min || t > max;
      plot.setCursor({ left: outside ? -10 : plot.valToPos(t, 'x'), top: outside ? -10 : 10 }, false);
    },
    zoom: (from, to) => show(plot, from, to),
  };
}
