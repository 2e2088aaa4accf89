// SPDX-License-Identifier: MIT
// Sections through the cells of a body, one an axis, as pictures of the cells that the plane goes through; and what
// is cut away in front of them.

const STATE_COLOURS = {surface: [0, 114, 178], interior: [190, 214, 232]};
const MOST_TEXELS = 2048; // along an edge: above it a coarser level is shown

// Blue inside, white at the surface, vermilion outside.
function distanceColour(share) {
  const far = share < 0 ? [0, 80, 150] : [213, 94, 0], t = Math.min(1, Math.abs(share));
  return far.map(x => Math.round(245 + (x - 245) * t));
}

class Slice {
  constructor(body, axis) {
    this.body = body;
    this.axis = axis;
    this.on = false;
    const cells = body.cells.cells;
    this.low = cells.min[axis];
    this.high = cells.max[axis];
    this.at = Math.floor((this.low + this.high) / 2);
    this.plane = new THREE.Plane();
    this.geometry = new THREE.BufferGeometry();
    this.geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(12), 3));
    this.geometry.setAttribute('uv', new THREE.BufferAttribute(new Float32Array([0, 0, 1, 0, 1, 1, 0, 1]), 2));
    this.geometry.setIndex([0, 1, 2, 0, 2, 3]);
    this.mesh = new THREE.Mesh(this.geometry, new THREE.MeshBasicMaterial({side: THREE.DoubleSide, alphaTest: 0.5}));
    this.mesh.frustumCulled = false;
    this.mesh.visible = false;
    body.instances[0].group.add(this.mesh);
  }

  // Of the section's middle, in metres of the body's frame.
  coordinate() {
    return (this.at + 0.5) * this.body.cells.cells.voxel;
  }

  show(on, at, shows) {
    this.on = on;
    this.at = Math.min(this.high, Math.max(this.low, at));
    this.mesh.visible = on;
    if (on) this.draw(shows);
  }

  draw(shows) {
    const {cells, blocks} = this.body.cells, [, u, v] = AXES[this.axis];
    const size = a => cells.max[a] - cells.min[a] + 1;
    let level = 0;
    while (level < blocks.levels.length - 1 && Math.max(size(u), size(v)) >> level > MOST_TEXELS) ++level;
    const whole = shows !== 'state' && level === 0 && cells[shows];
    const relative = this.at - cells.origin[this.axis] >> level;
    const low = [u, v].map(a => cells.min[a] - cells.origin[a] >> level);
    const [wide, high] = [u, v].map((a, n) => (cells.max[a] - cells.origin[a] >> level) - low[n] + 1);
    const texels = new Uint8Array(4 * wide * high);
    const put = (x, y, colour) => {
      if (x < 0 || y < 0 || x >= wide || y >= high) return;
      texels.set(colour, 4 * (y * wide + x));
      texels[4 * (y * wide + x) + 3] = 255;
    };
    if (whole) this.channel(cells, shows, relative, low, put);
    else this.states(blocks, level, relative, low, put);
    if (this.texture) this.texture.dispose();
    this.texture = new THREE.DataTexture(texels, wide, high, THREE.RGBAFormat);
    this.texture.needsUpdate = true;
    this.mesh.material.map = this.texture;
    this.mesh.material.needsUpdate = true;
    this.texels = texels;
    const corner = (a, n, end) => ((low[n] + end << level) + cells.origin[a]) * cells.voxel;
    const position = this.geometry.attributes.position;
    [[0, 0], [wide, 0], [wide, high], [0, high]].forEach(([x, y], n) => {
      position.array[3 * n + this.axis] = this.coordinate();
      position.array[3 * n + u] = corner(u, 0, x);
      position.array[3 * n + v] = corner(v, 1, y);
    });
    position.needsUpdate = true;
  }

  states(blocks, level, relative, low, put) {
    const p = relative % SIDE, [, u, v] = AXES[this.axis];
    const each = (i, j, k, bits) => {
      const from = [SIDE * i, SIDE * j, SIDE * k];
      const bit = (words, x, y) => this.axis === 0 ? words[p * SIDE + x] >>> y & 1
        : this.axis === 1 ? words[x * SIDE + p] >>> y & 1 : words[x * SIDE + y] >>> p & 1;
      for (let x = 0; x < SIDE; ++x) {
        for (let y = 0; y < SIDE; ++y) {
          const state = bits === null ? 'interior' : bit(bits.surface, x, y) ? 'surface' : bit(bits.interior, x, y) ? 'interior' : '';
          if (state) put(from[u] + x - low[0], from[v] + y - low[1], STATE_COLOURS[state]);
        }
      }
    };
    const here = Math.floor(relative / SIDE);
    for (const block of blocks.levels[level].values()) if (block.at[this.axis] === here) each(...block.at, block);
    for (const key of blocks.solid[level]) {
      const at = [Math.floor(key / 4294967296), Math.floor(key / 65536) % 65536, key % 65536];
      if (at[this.axis] === here) each(...at, null);
    }
  }

  channel(cells, shows, relative, low, put) {
    const [, u, v] = AXES[this.axis], values = new Int8Array(512), most = shows === 'layer' ? cells.layers + 1 : 127;
    for (let n = 0; n < cells.at.length / 3; ++n) {
      const first = [8 * cells.at[3 * n], 8 * cells.at[3 * n + 1], 8 * cells.at[3 * n + 2]];
      const p = relative - first[this.axis];
      if (p < 0 || p > 7) continue;
      for (let c = 0; c < 512; ++c) values[c] = cells[shows][512 * n + c] + (c % 8 ? values[c - 1] : 0);
      for (let x = 0; x < 8; ++x) {
        for (let y = 0; y < 8; ++y) {
          const c = this.axis === 0 ? [p, x, y] : this.axis === 1 ? [x, p, y] : [x, y, p];
          put(first[u] + x - low[0], first[v] + y - low[1], distanceColour(values[64 * c[0] + 8 * c[1] + c[2]] / most));
        }
      }
    }
  }

  // What is cut away lies on the far side of this plane, which is where the axis points.
  cut() {
    const normal = new THREE.Vector3();
    normal.setComponent(this.axis, -1);
    this.plane.set(normal, this.coordinate());
    return this.plane.clone().applyMatrix4(this.body.instances[0].group.matrixWorld);
  }
}
