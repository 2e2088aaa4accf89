// SPDX-License-Identifier: MIT
// Cells as blocks of 32 x 32 x 32, and above them levels whose cells are twice as large each: an octree of bits.
// Word 32 i + j of a block holds its cells (i, j, 0..31). A coarse cell is surface if one of its eight is.

const SIDE = 32;
const keyOf = (i, j, k) => (i * 65536 + j) * 65536 + k;

class Block {
  constructor(i, j, k) {
    this.at = [i, j, k];
    this.surface = new Uint32Array(SIDE * SIDE);
    this.interior = new Uint32Array(SIDE * SIDE);
  }
}

// The even bits of a word, moved together.
function halved(word) {
  word &= 0x55555555;
  word = (word | word >>> 1) & 0x33333333;
  word = (word | word >>> 2) & 0x0f0f0f0f;
  word = (word | word >>> 4) & 0x00ff00ff;
  return (word | word >>> 8) & 0xffff;
}

class Blocks {
  constructor(cells) {
    this.levels = [new Map()];
    this.solid = [new Set()]; // blocks that are interior throughout
    this.fill(cells);
    while (this.top().size > 1 && this.levels.length < 16) this.coarsen();
  }

  top() {
    return this.levels[this.levels.length - 1];
  }

  block(level, i, j, k) {
    const blocks = this.levels[level], key = keyOf(i, j, k);
    if (!blocks.has(key)) blocks.set(key, new Block(i, j, k));
    return blocks.get(key);
  }

  fill(cells) {
    const {at, surface, interior, solid} = cells;
    // A brick's bits, 64 bytes from 8 * 8 rows, or all of them.
    const put = (into, from, n, i, j, k) => {
      const shift = (k & 3) * 8;
      for (let row = 0; row < 64; ++row) {
        const byte = from ? from[64 * n + row] : 255;
        if (byte) into[((i & 3) * 8 + (row >> 3)) * SIDE + (j & 3) * 8 + (row & 7)] |= byte << shift;
      }
    };
    const any = (bytes, n) => {
      for (let row = 0; row < 64; ++row) if (bytes[64 * n + row]) return true;
      return false;
    };
    const brick = n => [at[3 * n], at[3 * n + 1], at[3 * n + 2]], bricks = at.length / 3;
    for (let n = 0; n < bricks; ++n) {
      const [i, j, k] = brick(n);
      if (any(surface, n)) put(this.block(0, i >> 2, j >> 2, k >> 2).surface, surface, n, i, j, k);
    }
    // Interior and free cells touch nowhere: a block without surface cells is all of one kind.
    const inside = (key, fill) => {
      const block = this.levels[0].get(key);
      if (block) fill(block.interior);
      else this.solid[0].add(key);
    };
    for (let n = 0; n < bricks; ++n) {
      const [i, j, k] = brick(n);
      if (any(interior, n)) inside(keyOf(i >> 2, j >> 2, k >> 2), bits => put(bits, interior, n, i, j, k));
    }
    for (let n = 0; n < solid.length; n += 4) {
      const [i, j, first, last] = solid.subarray(n, n + 4);
      for (let from = first; from <= last; from = (from | 3) + 1)
        inside(keyOf(i >> 2, j >> 2, from >> 2), bits => {
          for (let k = from; k <= Math.min(last, from | 3); ++k) put(bits, null, 0, i, j, k);
        });
    }
  }

  coarsen() {
    const level = this.levels.length, fine = this.levels[level - 1];
    this.levels.push(new Map());
    this.solid.push(new Set());
    for (const child of fine.values()) {
      const [i, j, k] = child.at, parent = this.block(level, i >> 1, j >> 1, k >> 1);
      const first = (i & 1) * 16 * SIDE + (j & 1) * 16, shift = (k & 1) * 16;
      for (let u = 0; u < 16; ++u) {
        for (let v = 0; v < 16; ++v) {
          const a = 2 * u * SIDE + 2 * v, b = a + SIDE, to = first + u * SIDE + v;
          const four = words => words[a] | words[a + 1] | words[b] | words[b + 1];
          const s = four(child.surface), t = four(child.interior);
          const surface = halved(s | s >>> 1);
          parent.surface[to] |= surface << shift;
          parent.interior[to] |= (halved(t | t >>> 1) & ~surface) << shift;
        }
      }
    }
    for (const key of this.solid[level - 1]) {
      const k = key % 65536, j = Math.floor(key / 65536) % 65536, i = Math.floor(key / 4294967296);
      const parent = this.levels[level].get(keyOf(i >> 1, j >> 1, k >> 1));
      if (!parent) {
        this.solid[level].add(keyOf(i >> 1, j >> 1, k >> 1));
        continue;
      }
      for (let u = 0; u < 16; ++u)
        for (let v = 0; v < 16; ++v)
          parent.interior[((i & 1) * 16 + u) * SIDE + (j & 1) * 16 + v] |= 0xffff << (k & 1) * 16;
    }
  }
}
