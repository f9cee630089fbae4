// Values of a moving figure between its frames.

/** Index of the frame before `time` and the share of the way to the next one. */
export function frameAt(times, time) {
  const last = times.length - 1;
  if (last <= 0 || time <= times[0]) return [0, 0];
  if (time >= times[last]) return [last, 0];
  let low = 0;
  let high = last;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle;
    else high = middle;
  }
  const span = times[high] - times[low];
  return [low, span > 0 ? (time - times[low]) / span : 0];
}

/** The point number `index` of `count` in each frame, [x, z]; NaN where it is not known. */
export function pointAt(values, count, index, [frame, share]) {
  const i = (frame * count + index) * 2;
  const j = share > 0 ? i + count * 2 : i;
  return [values[i] + share * (values[j] - values[i]), values[i + 1] + share * (values[j + 1] - values[i + 1])];
}

/** Smallest box that holds every point of `lists`. */
export function boundsOf(lists) {
  const box = { left: Infinity, right: -Infinity, low: Infinity, high: -Infinity };
  for (const values of lists) {
    for (let i = 0; i + 1 < values.length; i += 2) {
      if (!Number.isFinite(values[i]) || !Number.isFinite(values[i + 1])) continue;
      box.left = Math.min(box.left, values[i]);
      box.right = Math.max(box.right, values[i]);
      box.low = Math.min(box.low, values[i + 1]);
      box.high = Math.max(box.high, values[i + 1]);
    }
  }
  return box.left <= box.right ? box : { left: -0.5, right: 0.5, low: 0, high: 1 };
}

/** Length of the longest vector of `values`, pairs of numbers. */
export function longest(values) {
  let most = 0;
  for (let i = 0; i + 1 < values.length; i += 2) {
    const length = Math.hypot(values[i], values[i + 1]);
    if (length > most) most = length;
  }
  return most;
}
