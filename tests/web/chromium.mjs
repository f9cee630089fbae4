// A headless Chromium driven through its debugging pipe, with nothing but node's own modules.

import { spawn } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

const FLAGS = [
  '--headless', '--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
  '--disable-component-update', '--disable-sync', '--disable-dev-shm-usage', '--hide-scrollbars', '--remote-debugging-pipe',
];

/** Starts the program and returns {open, close}. */
export async function startChromium(program) {
  const folder = mkdtempSync(join(tmpdir(), 'jaculus-chromium-'));
  const child = spawn(program, [...FLAGS, `--user-data-dir=${folder}`, 'about:blank'], {
    stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe'],
  });
  const [, , , input, output] = child.stdio;
  const waiting = new Map();
  const listeners = [];
  let last = 0;
  let rest = '';
  output.setEncoding('utf8');
  output.on('data', (chunk) => {
    rest += chunk;
    for (let end = rest.indexOf('\0'); end >= 0; end = rest.indexOf('\0')) {
      const message = JSON.parse(rest.slice(0, end));
      rest = rest.slice(end + 1);
      if (message.id && waiting.has(message.id)) {
        const { resolve, reject } = waiting.get(message.id);
        waiting.delete(message.id);
        if (message.error) reject(new Error(message.error.message));
        else resolve(message.result);
      } else for (const listener of listeners) listener(message);
    }
  });
  child.on('exit', () => waiting.forEach(({ reject }) => reject(new Error('chromium ended'))));
  const send = (method, params = {}, sessionId = undefined) =>
    new Promise((resolve, reject) => {
      waiting.set(++last, { resolve, reject });
      input.write(`${JSON.stringify({ id: last, method, params, sessionId })}\0`);
    });
  const close = async () => {
    await send('Browser.close').catch(() => {});
    await new Promise((resolve) => (child.exitCode === null ? child.on('exit', resolve) : resolve()));
    rmSync(folder, { recursive: true, force: true, maxRetries: 5 });
  };
  return { open: (address, options) => openPage(send, listeners, address, options), close };
}

const READY = "document.documentElement.classList.contains('ready')"; // reports say so

/** Opens a page and waits until it says that it is ready, by the expression `ready`; everything that it complained of or asked for stands in the result. */
async function openPage(send, listeners, address, { width = 1300, height = 1000, dark = false, ready = READY } = {}) {
  const { targetId } = await send('Target.createTarget', { url: 'about:blank' });
  const { sessionId } = await send('Target.attachToTarget', { targetId, flatten: true });
  const call = (method, params) => send(method, params, sessionId);
  const errors = [];
  const requests = [];
  listeners.push((m) => {
    if (m.sessionId !== sessionId) return;
    const p = m.params;
    if (m.method === 'Runtime.exceptionThrown') errors.push(p.exceptionDetails.exception?.description || p.exceptionDetails.text);
    if (m.method === 'Runtime.consoleAPICalled' && ['error', 'warning', 'assert'].includes(p.type))
      errors.push(p.args.map((a) => a.value ?? a.description).join(' '));
    if (m.method === 'Log.entryAdded' && p.entry.level === 'error') errors.push(p.entry.text);
    if (m.method === 'Network.requestWillBeSent') requests.push(p.request.url);
    if (m.method === 'Page.javascriptDialogOpening') errors.push(`a dialog: ${p.message}`);
  });
  for (const domain of ['Runtime', 'Log', 'Network', 'Page']) await call(`${domain}.enable`);
  await call('Emulation.setDeviceMetricsOverride', { width, height, deviceScaleFactor: 1, mobile: width < 600 });
  await call('Emulation.setEmulatedMedia', { features: [{ name: 'prefers-color-scheme', value: dark ? 'dark' : 'light' }] });
  await call('Page.navigate', { url: address });
  const evaluate = async (expression) => {
    const { result, exceptionDetails } = await call('Runtime.evaluate', { expression, awaitPromise: true, returnByValue: true });
    if (exceptionDetails) throw new Error(exceptionDetails.exception?.description || exceptionDetails.text);
    return result.value;
  };
  const deadline = Date.now() + 60000;
  while (!(await evaluate(ready).catch(() => false))) {
    if (Date.now() > deadline) throw new Error(`${address} is not ready: ${errors.join('; ')}`);
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
  const settle = () => evaluate('new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))');
  await settle();
  return {
    call, evaluate, settle, errors, requests,
    screenshot: async (file, options = {}) => {
      const { data } = await call('Page.captureScreenshot', { format: 'png', ...options });
      writeFileSync(file, Buffer.from(data, 'base64'));
      return Buffer.from(data, 'base64');
    },
    pdf: async (file) => {
      const { data } = await call('Page.printToPDF', { printBackground: true, paperWidth: 8.27, paperHeight: 11.69 });
      writeFileSync(file, Buffer.from(data, 'base64'));
      return Buffer.from(data, 'base64');
    },
    close: () => send('Target.closeTarget', { targetId }),
  };
}
