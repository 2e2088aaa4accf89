// SPDX-License-Identifier: MIT
// The faces of a block's surface cells that lead into free cells, merged into rectangles. What leads out of the block
// is drawn too: its neighbour may be shown at another level.

// Corners of the rectangle u0..u1, v0..v1 of the plane at `at`, counter-clockwise from outside: [u, v] picks.
const TURNS = [[[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 0], [0, 1], [1, 1], [1, 0]]];
const AXES = [[0, 1, 2], [1, 0, 2], [2, 0, 1]]; // normal, u, v

class Quads {
  constructor() {
    this.bytes = new Uint8Array(1 << 16);
    this.count = 0;
  }

  // Four corners of four bytes each: i, j, k and which face (2 axis + (1 if it looks along it)).
  add(axis, up, at, u0, u1, v0, v1) {
    if (16 * this.count === this.bytes.length) {
      const more = new Uint8Array(2 * this.bytes.length);
      more.set(this.bytes);
      this.bytes = more;
    }
    const [n, u, v] = AXES[axis], turn = TURNS[(axis === 1) === up ? 1 : 0];
    for (let c = 0; c < 4; ++c) {
      const to = 16 * this.count + 4 * c;
      this.bytes[to + n] = at;
      this.bytes[to + u] = turn[c][0] ? u1 : u0;
      this.bytes[to + v] = turn[c][1] ? v1 : v0;
      this.bytes[to + 3] = 2 * axis + (up ? 1 : 0);
    }
    ++this.count;
  }

  // planes[32 p + u]: bits over v of the faces in plane p. Taken apart on the way.
  merge(planes, axis, up) {
    for (let p = 0; p < SIDE; ++p) {
      for (let u = 0; u < SIDE; ++u) {
        let row = planes[p * SIDE + u];
        while (row) {
          const v0 = 31 - Math.clz32(row & -row), run = ~(row >>> v0);
          const long = run ? 31 - Math.clz32(run & -run) : SIDE;
          const v1 = Math.min(SIDE, v0 + long);
          const mask = v1 - v0 === SIDE ? 0xffffffff : (2 ** (v1 - v0) - 1) << v0 >>> 0;
          let u1 = u;
          do {
            planes[p * SIDE + u1] &= ~mask;
            ++u1;
          } while (u1 < SIDE && (planes[p * SIDE + u1] & mask) >>> 0 === mask);
          this.add(axis, up, up ? p + 1 : p, u, u1, v0, v1);
          row = planes[p * SIDE + u];
        }
      }
    }
  }
}

function facesOf(block) {
  const {surface, interior} = block, quads = new Quads(), planes = new Uint32Array(SIDE * SIDE);
  const full = (i, j) => i < 0 || j < 0 || i >= SIDE || j >= SIDE ? 0 : surface[i * SIDE + j] | interior[i * SIDE + j];
  for (const up of [true, false]) {
    const step = up ? 1 : -1;
    for (let axis = 0; axis < 3; ++axis) {
      planes.fill(0);
      for (let i = 0; i < SIDE; ++i) {
        for (let j = 0; j < SIDE; ++j) {
          const s = surface[i * SIDE + j];
          if (!s) continue;
          if (axis === 0) planes[i * SIDE + j] = s & ~full(i + step, j);
          else if (axis === 1) planes[j * SIDE + i] = s & ~full(i, j + step);
          else {
            const o = full(i, j);
            for (let faces = s & ~(up ? o >>> 1 : o << 1); faces; faces &= faces - 1)
              planes[(31 - Math.clz32(faces & -faces)) * SIDE + i] |= 1 << j;
          }
        }
      }
      quads.merge(planes, axis, up);
    }
  }
  return {bytes: quads.bytes.slice(0, 16 * quads.count), count: quads.count};
}
