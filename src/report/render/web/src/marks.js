// Marks in a chart: figures of the paper, limits, notes; as points, lines or strips with a label.

import { colour } from './theme.js';

const LOOK = {
  published: { colour: '--published', dash: [2, 3] },
  limit: { colour: '--limit', dash: [8, 4] },
  note: { colour: '--muted', dash: [2, 3] },
};

function drawPoint(ctx, x, y, size) {
  ctx.beginPath();
  ctx.moveTo(x, y - size);
  ctx.lineTo(x + size, y);
  ctx.lineTo(x, y + size);
  ctx.lineTo(x - size, y);
  ctx.closePath();
  ctx.fill();
}

/** Writes labels one below the other where they would overlap. */
function placeLabel(ctx, taken, text, x, y, box, ratio) {
  const height = 13 * ratio;
  const width = ctx.measureText(text).width;
  let left = Math.min(Math.max(x, box.left + 2 * ratio), box.left + box.width - width - 2 * ratio);
  left = Math.max(left, box.left + 2 * ratio);
  let top = Math.min(Math.max(y, box.top + height), box.top + box.height - 2 * ratio);
  const overlaps = (t) => taken.some((b) => Math.abs(b.top - t) < height && left < b.left + b.width && b.left < left + width);
  for (let tries = 0; tries < 8 && overlaps(top); tries++) top += height;
  taken.push({ left, top, width });
  ctx.fillText(text, left, top);
}

export function marksPlugin(marks) {
  const draw = (u) => {
    const { ctx, bbox } = u;
    const ratio = devicePixelRatio || 1;
    const taken = [];
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.font = `${11 * ratio}px system-ui, sans-serif`;
    ctx.textAlign = 'left';
    ctx.textBaseline = 'alphabetic';
    for (const mark of marks) {
      const look = LOOK[mark.kind] || LOOK.note;
      const ink = colour(look.colour);
      ctx.strokeStyle = ink;
      ctx.fillStyle = ink;
      ctx.lineWidth = 1.25 * ratio;
      ctx.setLineDash(look.dash.map((d) => d * ratio));
      const x = mark.x === null ? null : u.valToPos(mark.x, 'x', true);
      const y = mark.y === null ? null : u.valToPos(mark.y, 'y', true);
      if (x !== null && y !== null) {
        drawPoint(ctx, x, y, 5 * ratio);
        placeLabel(ctx, taken, mark.label, x + 8 * ratio, y - 4 * ratio, bbox, ratio);
        continue;
      }
      if (x !== null && mark.xTo !== null) {
        const to = u.valToPos(mark.xTo, 'x', true);
        ctx.globalAlpha = 0.18;
        ctx.fillRect(x, bbox.top, to - x, bbox.height);
        ctx.globalAlpha = 1;
        placeLabel(ctx, taken, mark.label, to + 3 * ratio, bbox.top + 13 * ratio, bbox, ratio);
        continue;
      }
      ctx.beginPath();
      if (x !== null) {
        ctx.moveTo(x, bbox.top);
        ctx.lineTo(x, bbox.top + bbox.height);
      } else if (y !== null) {
        ctx.moveTo(bbox.left, y);
        ctx.lineTo(bbox.left + bbox.width, y);
      }
      ctx.stroke();
      if (x !== null) placeLabel(ctx, taken, mark.label, x + 3 * ratio, bbox.top + 13 * ratio, bbox, ratio);
      else placeLabel(ctx, taken, mark.label, bbox.left + 4 * ratio, y - 3 * ratio, bbox, ratio);
    }
    ctx.restore();
  };
  return { hooks: { draw: [draw] } };
}
