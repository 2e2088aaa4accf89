// SPDX-License-Identifier: MIT
// The page's arrays: base64 of deflated bytes in elements of the page, as tools/view/page_data.hpp puts them.

async function inflate(text) {
  const coded = atob(text), bytes = new Uint8Array(coded.length);
  for (let n = 0; n < bytes.length; ++n) bytes[n] = coded.charCodeAt(n);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

function sums(bytes, count, stride) {
  const out = new Int32Array(count);
  for (let n = 0, at = 0; n < count; ++n) {
    let zigzag = 0, shift = 0, byte;
    do {
      byte = bytes[at++];
      zigzag |= (byte & 127) << shift;
      shift += 7;
    } while (byte & 128);
    out[n] = (n < stride ? 0 : out[n - stride]) + ((zigzag >>> 1) ^ -(zigzag & 1));
  }
  return out;
}

// Reads each array once and lets go of its text.
async function unpack(array) {
  const element = document.querySelectorAll('script.blob')[array.blob];
  const bytes = await inflate(element.textContent);
  element.textContent = '';
  if (array.kind === 'ints') return sums(bytes, array.n, array.stride);
  return array.kind === 'floats' ? new Float32Array(bytes.buffer, 0, array.n) : bytes;
}

// All arrays of a layer, in place of what names them.
async function unpackAll(layer) {
  for (const [key, value] of Object.entries(layer))
    if (value && typeof value === 'object' && 'blob' in value) layer[key] = await unpack(value);
  return layer;
}
