// The one time of a report: its scrubber, its play button, and everything that follows them.

import { element, shown } from './data.js';

const STEPS = 2000;
const SPEEDS = [
  [1, 'real time'],
  [0.25, '1/4'],
  [0.1, '1/10'],
  [0.05, '1/20'],
];

/** A clock from `from` to `to` [s]; followers are called with the time after every change. */
export function makeClock(from, to) {
  const followers = [];
  const clock = { time: from, from, to, playing: false, speed: to - from < 2 ? 0.1 : 1 };
  clock.follow = (follower) => {
    followers.push(follower);
    follower(clock.time);
  };
  clock.set = (time) => {
    clock.time = Math.min(Math.max(time, from), to);
    for (const follower of followers) follower(clock.time);
  };
  let last = 0;
  const tick = (now) => {
    if (!clock.playing) return;
    const next = clock.time + ((now - last) / 1000) * clock.speed;
    last = now;
    if (next >= to) {
      clock.playing = false;
      clock.set(to);
      return;
    }
    clock.set(next);
    requestAnimationFrame(tick);
  };
  clock.toggle = () => {
    clock.playing = !clock.playing;
    if (clock.playing && clock.time >= to) clock.time = from;
    if (clock.playing) {
      last = performance.now();
      requestAnimationFrame(tick);
    }
    clock.set(clock.time);
  };
  return clock;
}

/** Play button, scrubber, speed and the time itself. */
export function makeControls(clock) {
  const bar = element('div', 'controls');
  const play = element('button', 'play', '▶');
  play.type = 'button';
  play.setAttribute('aria-label', 'play or pause');
  play.addEventListener('click', clock.toggle);
  const scrubber = element('input', 'scrubber');
  scrubber.type = 'range';
  scrubber.min = 0;
  scrubber.max = STEPS;
  scrubber.step = 1;
  scrubber.setAttribute('aria-label', 'time');
  scrubber.addEventListener('input', () => {
    clock.playing = false;
    clock.set(clock.from + ((clock.to - clock.from) * Number(scrubber.value)) / STEPS);
  });
  const speed = element('select', 'speed');
  speed.setAttribute('aria-label', 'speed');
  for (const [value, label] of SPEEDS) {
    const option = element('option', '', label);
    option.value = value;
    option.selected = value === clock.speed;
    speed.append(option);
  }
  speed.addEventListener('change', () => (clock.speed = Number(speed.value)));
  const readout = element('output', 'time');
  clock.follow((t) => {
    scrubber.value = Math.round((STEPS * (t - clock.from)) / (clock.to - clock.from || 1));
    play.textContent = clock.playing ? '❚❚' : '▶';
    readout.textContent = `${t.toFixed(3)} s`;
    scrubber.setAttribute('aria-valuetext', `${shown(t)} seconds`);
  });
  bar.append(play, scrubber, readout, speed);
  return bar;
}
