// The report's data: JSON in the page, numbers as base64 of little-endian single precision.

/** Bytes of base64 as numbers. */
function decode(text) {
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; i++) bytes[i] = binary.charCodeAt(i);
  return Float64Array.from(new Float32Array(bytes.buffer));
}

/** The data of the element `id`, with array(index) for its numbers; each is decoded once, when asked for. */
export function readData(id) {
  const data = JSON.parse(document.getElementById(id).textContent);
  const decoded = new Map();
  data.array = (index) => {
    if (index === null || index === undefined) return new Float64Array(0);
    if (!decoded.has(index)) decoded.set(index, decode(data.arrays[index]));
    return decoded.get(index);
  };
  return data;
}

/** A number for people: five digits, no trailing zeros. */
export function shown(value) {
  if (value === null || value === undefined || !Number.isFinite(value)) return '–';
  const text = Number(value.toPrecision(5)).toString();
  return text.replace('-', '−');
}

/** "time [s]"; a ratio has no brackets. */
export function axisTitle(axis) {
  return axis.unit && axis.unit !== '-' ? `${axis.name} [${axis.unit}]` : axis.name;
}

/** Offers `text` as a file. */
export function download(name, text, type) {
  const link = document.createElement('a');
  const address = URL.createObjectURL(new Blob([text], { type }));
  link.href = address;
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), 1000);
}

/** An element with a class, text (never markup) and children. */
export function element(tag, className, text, ...children) {
  const made = document.createElement(tag);
  if (className) made.className = className;
  if (text !== undefined && text !== null) made.textContent = text;
  made.append(...children);
  return made;
}
