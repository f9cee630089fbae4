// What a chart shows of long series: in each of so many stretches of x its first, least, largest and last point, so that no peak is lost. All
// points where they are few.

const MOST_POINTS = 4000;

/** First index whose x is not below `value`. */
export function lowerBound(x, value) {
  let low = 0;
  let high = x.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (x[middle] < value) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** Indices of the points of (x, y) that show between `from` and `to`, one neighbour beyond each end among them. */
export function thin(x, y, from, to, most = MOST_POINTS) {
  const begin = Math.max(0, lowerBound(x, from) - 1);
  const end = Math.min(x.length, lowerBound(x, to) + 2);
  const kept = [];
  if (end - begin <= most) {
    for (let i = begin; i < end; i++) kept.push(i);
    return kept;
  }
  const stretches = most / 4;
  const each = (end - begin) / stretches;
  for (let s = 0; s < stretches; s++) {
    const first = begin + Math.floor(s * each);
    const last = Math.min(end, begin + Math.floor((s + 1) * each)) - 1;
    let least = first;
    let largest = first;
    let gap = -1;
    for (let i = first; i <= last; i++) {
      if (Number.isNaN(y[i])) gap = i;
      if (y[i] < y[least] || Number.isNaN(y[least])) least = i;
      if (y[i] > y[largest] || Number.isNaN(y[largest])) largest = i;
    }
    const picked = new Set([first, least, largest, last]);
    if (gap >= 0) picked.add(gap);
    kept.push(...[...picked].sort((a, b) => a - b));
  }
  return kept;
}
