// Stick figures on canvases, side by side at one scale, in step with the report's clock.

import { element, shown } from './data.js';
import { boundsOf, frameAt, longest, pointAt } from './frames.js';
import { colour, onTheme, paletteColour } from './theme.js';

const ARROW_LENGTH = { force: 0.3, drag: 0.22 };  // of the longest arrow [m]
const WIDTH = { base: 7, tail: 3, scoop: 6, leg: 4, link: 4 };  // [px]
const LAYERS = [
  ['forces', 'foot forces'],
  ['cone', 'friction cone'],
  ['drag', 'tail drag'],
  ['com', 'centre of mass'],
  ['ghost', 'ghost'],
];

function readActor(actor, data) {
  return {
    ...actor,
    times: data.array(actor.time),
    centre: data.array(actor.com),
    parts: actor.bodies.map((b) => ({ ...b, values: data.array(b.xz) })),
    loads: actor.arrows.map((a) => ({ ...a, at: data.array(a.from), vector: data.array(a.force) })),
  };
}

function phaseAt(actor, time) {
  let index = actor.phases.findIndex((p) => time <= p.to);
  if (index < 0) index = actor.phases.length - 1;
  return index;
}

function arrow(ctx, x, y, dx, dy, head) {
  const length = Math.hypot(dx, dy);
  if (!(length > 0.5)) return;
  const ux = dx / length;
  const uy = dy / length;
  const size = Math.min(head, length);
  ctx.beginPath();
  ctx.moveTo(x, y);
  ctx.lineTo(x + dx, y + dy);
  ctx.stroke();
  ctx.beginPath();
  ctx.moveTo(x + dx, y + dy);
  ctx.lineTo(x + dx - size * (ux - 0.5 * uy), y + dy - size * (uy + 0.5 * ux));
  ctx.lineTo(x + dx - size * (ux + 0.5 * uy), y + dy - size * (uy - 0.5 * ux));
  ctx.closePath();
  ctx.fill();
}

/** World [m] to canvas [px]; the same scale for both directions. */
function viewOf(box, width, height) {
  const scale = Math.min(width / (box.right - box.left), height / (box.high - box.low));
  const x0 = (width - scale * (box.right - box.left)) / 2 - scale * box.left;
  const y0 = height - (height - scale * (box.high - box.low)) / 2 + scale * box.low;
  return { scale, x: (x) => x0 + scale * x, y: (z) => y0 - scale * z };
}

function drawFloor(ctx, view, box, actor, time, width) {
  const index = actor ? phaseAt(actor, time) : -1;
  ctx.strokeStyle = index >= 0 ? colour(`--phase${index % 4}`) : colour('--muted');
  ctx.lineWidth = 3;
  ctx.beginPath();
  ctx.moveTo(0, view.y(0));
  ctx.lineTo(width, view.y(0));
  ctx.stroke();
  ctx.fillStyle = colour('--muted');
  ctx.font = '11px system-ui, sans-serif';
  const step = box.right - box.left > 4 ? 1 : box.right - box.left > 1.6 ? 0.5 : 0.2;
  for (let x = Math.ceil(box.left / step) * step; x <= box.right; x += step) {
    ctx.fillRect(view.x(x), view.y(0), 1, 5);
    ctx.fillText(`${shown(Math.round(x * 10) / 10)} m`, view.x(x) + 3, view.y(0) + 14);
  }
}

function drawBodies(ctx, view, actor, at) {
  ctx.lineCap = 'round';
  ctx.lineJoin = 'round';
  for (const part of actor.parts) {
    ctx.strokeStyle = part.kind === 'scoop' ? colour('--drag') : paletteColour(actor.colour);
    ctx.lineWidth = WIDTH[part.kind] || 4;
    ctx.beginPath();
    let started = false;
    for (let k = 0; k < part.points; k++) {
      const [x, z] = pointAt(part.values, part.points, k, at);
      if (Number.isNaN(x) || Number.isNaN(z)) {
        started = false;
        continue;
      }
      if (started) ctx.lineTo(view.x(x), view.y(z));
      else ctx.moveTo(view.x(x), view.y(z));
      started = true;
      if (part.points === 1) ctx.lineTo(view.x(x) + 0.1, view.y(z));
    }
    ctx.stroke();
  }
}

function drawCentre(ctx, view, actor, at) {
  if (!actor.centre.length) return;
  ctx.strokeStyle = colour('--muted');
  ctx.lineWidth = 1.25;
  ctx.setLineDash([4, 3]);
  ctx.beginPath();
  for (let i = 0; i + 1 < actor.centre.length; i += 2) ctx.lineTo(view.x(actor.centre[i]), view.y(actor.centre[i + 1]));
  ctx.stroke();
  ctx.setLineDash([]);
  const [x, z] = pointAt(actor.centre, 1, 0, at);
  ctx.fillStyle = colour('--ink');
  ctx.beginPath();
  ctx.arc(view.x(x), view.y(z), 4, 0, 7);
  ctx.fill();
}

function drawLoads(ctx, view, actor, at, reach, layers) {
  for (const load of actor.loads) {
    if (!layers[load.kind === 'force' ? 'forces' : 'drag']) continue;
    const [x, z] = pointAt(load.at, 1, 0, at);
    const [fx, fz] = pointAt(load.vector, 1, 0, at);
    if (![x, z, fx, fz].every(Number.isFinite)) continue;
    const ink = colour(load.kind === 'force' ? '--force' : '--drag');
    const scale = (view.scale * ARROW_LENGTH[load.kind]) / (reach[load.kind] || 1);
    ctx.strokeStyle = ink;
    ctx.fillStyle = ink;
    ctx.lineWidth = 2;
    arrow(ctx, view.x(x), view.y(z), fx * scale, -fz * scale, 8);
    if (load.kind === 'force' && layers.cone && actor.friction !== null && fz > 1e-3 * reach.force) {
      const height = ARROW_LENGTH.force * view.scale;
      ctx.setLineDash([3, 3]);
      ctx.lineWidth = 1;
      ctx.beginPath();
      ctx.moveTo(view.x(x) - actor.friction * height, view.y(z) - height);
      ctx.lineTo(view.x(x), view.y(z));
      ctx.lineTo(view.x(x) + actor.friction * height, view.y(z) - height);
      ctx.stroke();
      ctx.setLineDash([]);
    }
  }
}

function makePanel(panel, actors, box, reach, layers) {
  const canvas = element('canvas');
  canvas.setAttribute('role', 'img');
  canvas.setAttribute('aria-label', `stick figure: ${panel.title}`);
  const state = element('div', 'state');
  const place = element('div', 'panel', null, element('h4', '', panel.title), canvas, state);
  const draw = (time) => {
    const ratio = Math.max(1, devicePixelRatio || 1);
    const width = Math.max(200, canvas.clientWidth);
    const height = Math.max(160, canvas.clientHeight);
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
    }
    const ctx = canvas.getContext('2d');
    ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
    ctx.clearRect(0, 0, width, height);
    const view = viewOf(box, width, height);
    const leader = actors.find((a) => a.style === 'solid' && a.phases.length);
    drawFloor(ctx, view, box, leader, time, width);
    for (const actor of actors) {
      const ghost = actor.style === 'ghost';
      if (ghost && !layers.ghost) continue;
      if (ghost && (time < actor.times[0] - 1e-9 || time > actor.times[actor.times.length - 1] + 1e-9)) continue;
      const at = frameAt(actor.times, time);
      ctx.globalAlpha = ghost ? 0.4 : 1;
      if (ghost) ctx.setLineDash([7, 5]);
      drawBodies(ctx, view, actor, at);
      ctx.setLineDash([]);
      if (layers.com) drawCentre(ctx, view, actor, at);
      drawLoads(ctx, view, actor, at, reach, layers);
      ctx.globalAlpha = 1;
    }
    state.replaceChildren();
    if (!leader) return;
    const index = phaseAt(leader, time);
    const ended = time > leader.times[leader.times.length - 1] + 1e-9;
    const chip = element('span', 'chip', ended ? `ended at ${shown(leader.times[leader.times.length - 1])} s` : leader.phases[index].name);
    chip.style.setProperty('--chip', colour(`--phase${index % 4}`));
    state.append(chip);
  };
  return { place, canvas, draw };
}

/** What the layers' boxes may switch: only what is there. */
function presentLayers(actors) {
  const kinds = new Set(actors.flatMap((a) => a.loads.map((l) => l.kind)));
  const there = {
    forces: kinds.has('force'),
    cone: kinds.has('force') && actors.some((a) => a.friction !== null),
    drag: kinds.has('drag'),
    com: actors.some((a) => a.centre.length > 0),
    ghost: actors.some((a) => a.style === 'ghost'),
  };
  return LAYERS.filter(([key]) => there[key]);
}

/** The span of all actors' times. */
export function spanOf(animation, data) {
  const times = animation.panels.flatMap((p) => p.actors.map((a) => data.array(a.time)));
  return [Math.min(...times.map((t) => t[0])), Math.max(...times.map((t) => t[t.length - 1]))];
}

/** Makes the animation inside `place`, in step with `clock`. */
export function makeAnimation(animation, data, place, clock) {
  const panels = animation.panels.map((p) => ({ panel: p, actors: p.actors.map((a) => readActor(a, data)) }));
  const actors = panels.flatMap((p) => p.actors);
  const box = boundsOf(actors.flatMap((a) => [...a.parts.map((b) => b.values), a.centre]));
  const margin = 0.08 * Math.max(box.right - box.left, box.high - box.low) + 0.02;
  Object.assign(box, { left: box.left - margin, right: box.right + margin, low: Math.min(box.low, 0) - margin, high: box.high + margin });
  const reach = { force: 0, drag: 0 };
  for (const a of actors) for (const l of a.loads) reach[l.kind] = Math.max(reach[l.kind], longest(l.vector));

  const layers = { forces: true, cone: true, drag: true, com: true, ghost: true };
  const figure = element('figure', 'animation');
  figure.id = `animation-${animation.id}`;
  figure.append(element('h3', '', animation.title));
  const row = element('div', 'panels');
  const made = panels.map(({ panel, actors: own }) => makePanel(panel, own, box, reach, layers));
  row.append(...made.map((m) => m.place));
  const boxes = element('div', 'layers');
  const redraw = () => made.forEach((m) => m.draw(clock.time));
  for (const [key, label] of presentLayers(actors)) {
    const input = element('input');
    input.type = 'checkbox';
    input.checked = true;
    input.addEventListener('change', () => {
      layers[key] = input.checked;
      redraw();
    });
    boxes.append(element('label', '', null, input, ` ${label}`));
  }
  figure.append(row, boxes);
  if (reach.force > 0) figure.append(element('p', 'note', `Longest arrow of a foot: ${shown(reach.force)} N.`));
  if (animation.caption) figure.append(element('figcaption', '', animation.caption));
  place.append(figure);
  const shape = Math.min(1.4, Math.max(0.35, (box.high - box.low) / (box.right - box.left)));
  for (const m of made) m.canvas.style.aspectRatio = `1 / ${shape}`;
  clock.follow((t) => made.forEach((m) => m.draw(t)));
  new ResizeObserver(redraw).observe(row);
  onTheme(redraw);
}
