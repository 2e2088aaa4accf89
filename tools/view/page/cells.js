// SPDX-License-Identifier: MIT
// Surface cells on the screen: of each part of the octree the level whose cells are about as large as asked for in
// pixels. Faces are made when they are first wanted, as long as a frame has time for it.

const FACE_SHADING = `
  vec3 faceNormal(float face) {
    float axis = floor(face * 0.5 + 0.01), side = face - 2.0 * axis > 0.5 ? 1.0 : -1.0;
    return axis < 0.5 ? vec3(side, 0.0, 0.0) : axis < 1.5 ? vec3(0.0, side, 0.0) : vec3(0.0, 0.0, side);
  }`;

// Light that goes with the eye, from above on the left.
const LIGHT = `
  float lit(vec3 n) {
    return clamp(0.66 + 0.3 * dot(n, vec3(-0.4, 0.7, 0.6)) + 0.1 * n.z, 0.3, 1.06);
  }`;

// With the lines between cells, or without: where cells are too small for them, and quicker.
function cellMaterial(colour, lined) {
  return new THREE.ShaderMaterial({
    uniforms: {colour: {value: new THREE.Color(colour)}, lines: {value: 0}},
    defines: lined ? {LINED: 1} : {},
    clipping: true,
    extensions: {derivatives: lined},
    vertexShader: `
      attribute vec4 corner;
      uniform vec3 colour;
      varying vec3 seen;
      #ifdef LINED
      varying vec3 cell;
      varying vec3 across;
      #endif
      ${FACE_SHADING}${LIGHT}
      #include <clipping_planes_pars_vertex>
      void main() {
        vec3 n = faceNormal(corner.w);
        #ifdef LINED
        cell = corner.xyz;
        across = vec3(1.0) - abs(n);
        #endif
        seen = colour * lit(normalize(normalMatrix * n));
        vec4 mvPosition = modelViewMatrix * vec4(corner.xyz, 1.0);
        gl_Position = projectionMatrix * mvPosition;
        #include <clipping_planes_vertex>
      }`,
    fragmentShader: `
      varying vec3 seen;
      #ifdef LINED
      uniform float lines;
      varying vec3 cell;
      varying vec3 across;
      #endif
      #include <clipping_planes_pars_fragment>
      void main() {
        #include <clipping_planes_fragment>
        float light = 1.0;
        #ifdef LINED
        vec3 wide = max(fwidth(cell), vec3(1e-5));
        vec3 off = abs(fract(cell - 0.5) - 0.5) / wide + 10.0 * (vec3(1.0) - across);
        light = 1.0 - 0.35 * lines * (1.0 - smoothstep(0.4, 1.4, min(off.x, min(off.y, off.z))));
        #endif
        gl_FragColor = vec4(seen * light, 1.0);
      }`,
  });
}

// One index for the rectangles of all blocks.
class SharedIndex {
  constructor() {
    this.attribute = null;
  }
  of(quads) {
    if (!this.attribute || this.attribute.count < 6 * quads) {
      const index = new Uint32Array(6 * Math.max(16384, 2 ** Math.ceil(Math.log2(quads))));
      for (let n = 0; n < index.length / 6; ++n) index.set([4 * n, 4 * n + 1, 4 * n + 2, 4 * n, 4 * n + 2, 4 * n + 3], 6 * n);
      this.attribute = new THREE.BufferAttribute(index, 1);
    }
    return this.attribute;
  }
}
const sharedIndex = new SharedIndex();

// Cells of one body: what all its instances share.
class CellFaces {
  constructor(cells, colour) {
    this.cells = cells;
    this.blocks = new Blocks(cells);
    this.made = this.blocks.levels.map(() => new Map());
    this.plain = cellMaterial(colour, false);
    this.lined = cellMaterial(colour, true);
    this.material = this.plain;
    this.faces = 0;
  }

  // How dark the lines between cells are, 0 to 1.
  lines(dark) {
    this.material = dark > 0 ? this.lined : this.plain;
    this.lined.uniforms.lines.value = dark;
  }

  ready(level, key) {
    return this.made[level].has(key);
  }

  geometry(level, key) {
    let geometry = this.made[level].get(key);
    if (!geometry) {
      const {bytes, count} = facesOf(this.blocks.levels[level].get(key));
      geometry = new THREE.BufferGeometry();
      geometry.setIndex(sharedIndex.of(count));
      const corners = new THREE.BufferAttribute(bytes, 4);
      geometry.setAttribute('corner', corners);
      geometry.setAttribute('position', corners); // without one three.js draws nothing
      geometry.setDrawRange(0, 6 * count);
      this.made[level].set(key, geometry);
      this.faces += count;
    }
    return geometry;
  }
}

class CellInstance {
  constructor(faces) {
    this.shared = faces;
    this.group = new THREE.Group();
    this.meshes = new Map();
    this.shown = [];
  }

  mesh(level, key) {
    const name = level + ':' + key;
    let mesh = this.meshes.get(name);
    if (!mesh) {
      const {cells, blocks} = this.shared, edge = cells.voxel * 2 ** level;
      mesh = new THREE.Mesh(this.shared.geometry(level, key), this.shared.material);
      const at = blocks.levels[level].get(key).at;
      mesh.position.set(...at.map((x, n) => x * SIDE * edge + cells.origin[n] * cells.voxel));
      mesh.scale.setScalar(edge);
      mesh.frustumCulled = false;
      mesh.visible = false;
      mesh.matrixAutoUpdate = false;
      mesh.updateMatrix();
      this.group.add(mesh);
      this.meshes.set(name, mesh);
      mesh.updateMatrixWorld(true);
    }
    return mesh;
  }

  // view: {camera, pixels: of a metre one metre away, most: pixels that a cell may have, until: when time is up}.
  // False: with more time it would be finer. The faces shown are added to view.faces.
  select(view) {
    for (const mesh of this.shown) mesh.visible = false;
    this.shown = [];
    this.finest = this.shared.blocks.levels.length;
    const {blocks, cells} = this.shared, top = blocks.levels.length - 1;
    const inverse = new THREE.Matrix4().getInverse(this.group.matrixWorld);
    const eye = new THREE.Vector3().setFromMatrixPosition(view.camera.matrixWorld).applyMatrix4(inverse);
    const frustum = new THREE.Frustum().setFromMatrix(new THREE.Matrix4().multiplyMatrices(
      new THREE.Matrix4().multiplyMatrices(view.camera.projectionMatrix, view.camera.matrixWorldInverse), this.group.matrixWorld));
    const box = new THREE.Box3();
    const seen = (level, at) => {
      const edge = cells.voxel * 2 ** level * SIDE;
      box.min.set(...at.map((x, n) => x * edge + cells.origin[n] * cells.voxel));
      box.max.copy(box.min).addScalar(edge);
      return frustum.intersectsBox(box);
    };
    let done = true;
    const visit = (level, key) => {
      const at = blocks.levels[level].get(key).at;
      if (!seen(level, at)) return;
      const distance = Math.max(box.distanceToPoint(eye), view.camera.near);
      if (level > 0 && cells.voxel * 2 ** level * view.pixels / distance > view.most) {
        const children = [];
        for (let n = 0; n < 8; ++n) {
          const child = keyOf(2 * at[0] + (n >> 2), 2 * at[1] + (n >> 1 & 1), 2 * at[2] + (n & 1));
          const block = blocks.levels[level - 1].get(child);
          if (block && seen(level - 1, block.at)) children.push(child);
        }
        let all = true;
        for (const child of children) {
          if (this.shared.ready(level - 1, child)) continue;
          if (performance.now() < view.until) this.shared.geometry(level - 1, child);
          else all = false;
        }
        if (all) {
          for (const child of children) visit(level - 1, child);
          return;
        }
        done = false;
      }
      const mesh = this.mesh(level, key);
      mesh.visible = true;
      this.finest = Math.min(this.finest, level);
      this.shown.push(mesh);
      view.faces += mesh.geometry.drawRange.count / 6;
    };
    for (const key of blocks.levels[top].keys()) visit(top, key);
    return done;
  }

  // After all instances have been selected and it is known whether lines are drawn.
  dress() {
    for (const mesh of this.shown) mesh.material = this.shared.material;
  }
}
