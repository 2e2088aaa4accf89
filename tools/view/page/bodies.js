// SPDX-License-Identifier: MIT
// What stands in one frame: cells, points with normals and clusters, a mesh; once or at several poses.

const COLOURS = {
  stands: {cells: '#a9c4dc', mesh: '#c8ccd2', points: '#0072b2'},
  moves: {cells: '#e8c07a', mesh: '#f0d9a8', points: '#3d5166'},
  normals: '#009e73', clusters: '#8a5a83',
};
const MOST_NORMALS = 60000;

// Every 2^n-th first, then those between: any beginning of the order is spread evenly.
function spread(count) {
  const order = new Uint32Array(count);
  let to = 0;
  for (let step = 64; step >= 1; step /= 2)
    for (let n = step === 64 ? 0 : step; n < count; n += step === 64 ? 64 : 2 * step) order[to++] = n;
  return order;
}

function octahedral(x, y) {
  const z = 1 - Math.abs(x) - Math.abs(y);
  const v = z >= 0 ? [x, y, z] : [(1 - Math.abs(y)) * (x < 0 ? -1 : 1), (1 - Math.abs(x)) * (y < 0 ? -1 : 1), z];
  const size = Math.hypot(...v);
  return v.map(a => a / size);
}

function readPoints(layer) {
  const count = layer.at.length / 3, order = spread(count);
  const rank = new Uint32Array(count);
  order.forEach((n, to) => { rank[n] = to; });
  const position = new Float32Array(3 * count), normal = new Int8Array(4 * count), colour = new Uint8Array(4 * count);
  let x = 0, y = 0, cluster = 0, left = layer.counts[0] || 0;
  for (let n = 0; n < count; ++n) {
    const to = rank[n];
    for (let a = 0; a < 3; ++a) position[3 * to + a] = layer.base[a] + layer.step * layer.at[3 * n + a];
    x = x + layer.normal[2 * n] << 24 >> 24;
    y = y + layer.normal[2 * n + 1] << 24 >> 24;
    octahedral(x / 127, y / 127).forEach((v, a) => { normal[4 * to + a] = Math.round(127 * v); });
    while (left === 0 && cluster + 1 < layer.counts.length) left = layer.counts[++cluster];
    --left;
    const hue = cluster * 2654435761 >>> 0;
    for (let a = 0; a < 3; ++a) colour[4 * to + a] = 40 + (hue >>> 8 * a & 255) * 0.7;
  }
  return {count, position, normal, colour};
}

function pointMaterial(colour, voxel) {
  return new THREE.ShaderMaterial({
    uniforms: {colour: {value: new THREE.Color(colour)}, edge: {value: voxel}, pixels: {value: 1}, clustered: {value: 0}, behind: {value: 0}},
    clipping: true,
    vertexShader: `
      attribute vec4 normal4;
      attribute vec4 own;
      uniform vec3 colour;
      uniform float edge, pixels, clustered, behind;
      varying vec3 seen;
      ${LIGHT}
      #include <clipping_planes_pars_vertex>
      void main() {
        vec4 mvPosition = modelViewMatrix * vec4(position, 1.0);
        mvPosition.xyz -= 0.12 * edge * normalize(mvPosition.xyz); // before the mesh that it lies on
        vec3 outwards = normalize(normalMatrix * -normal4.xyz);
        seen = mix(colour, own.xyz, clustered) * (0.35 + 0.75 * lit(outwards));
        gl_Position = projectionMatrix * mvPosition;
        if (behind < 0.5 && dot(outwards, mvPosition.xyz) > 0.0) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
        gl_PointSize = clamp(0.55 * edge * pixels / -mvPosition.z, 1.5, 14.0);
        #include <clipping_planes_vertex>
      }`,
    fragmentShader: `
      varying vec3 seen;
      #include <clipping_planes_pars_fragment>
      void main() {
        #include <clipping_planes_fragment>
        vec2 off = gl_PointCoord - 0.5;
        if (dot(off, off) > 0.25) discard;
        gl_FragColor = vec4(seen, 1.0);
      }`,
  });
}

// A sphere's outline, as a ring around its middle.
function ringMaterial() {
  return new THREE.ShaderMaterial({
    uniforms: {colour: {value: new THREE.Color(COLOURS.clusters)}, pixels: {value: 1}},
    clipping: true,
    vertexShader: `
      attribute float radius;
      uniform float pixels;
      varying float size;
      #include <clipping_planes_pars_vertex>
      void main() {
        vec4 mvPosition = modelViewMatrix * vec4(position, 1.0);
        gl_Position = projectionMatrix * mvPosition;
        size = clamp(2.0 * radius * pixels / -mvPosition.z, 3.0, 512.0);
        gl_PointSize = size;
        #include <clipping_planes_vertex>
      }`,
    fragmentShader: `
      uniform vec3 colour;
      varying float size;
      #include <clipping_planes_pars_fragment>
      void main() {
        #include <clipping_planes_fragment>
        if (abs(length(gl_PointCoord - 0.5) - 0.5 + 0.9 / size) > 0.9 / size) discard;
        gl_FragColor = vec4(colour, 1.0);
      }`,
  });
}

function meshMaterial(colour) {
  return new THREE.ShaderMaterial({
    uniforms: {colour: {value: new THREE.Color(colour)}},
    clipping: true,
    side: THREE.DoubleSide,
    extensions: {derivatives: true},
    vertexShader: `
      varying vec3 place;
      #include <clipping_planes_pars_vertex>
      void main() {
        vec4 mvPosition = modelViewMatrix * vec4(position, 1.0);
        place = mvPosition.xyz;
        gl_Position = projectionMatrix * mvPosition;
        #include <clipping_planes_vertex>
      }`,
    fragmentShader: `
      uniform vec3 colour;
      varying vec3 place;
      ${LIGHT}
      #include <clipping_planes_pars_fragment>
      void main() {
        #include <clipping_planes_fragment>
        vec3 n = normalize(cross(dFdx(place), dFdy(place)));
        gl_FragColor = vec4(colour * lit(n.z < 0.0 ? -n : n), 1.0);
      }`,
  });
}

// Triangles whose corners lie in three different boxes of a grid: what is drawn of a large mesh while the view moves.
function coarseTriangles(layer, most) {
  const index = layer.triangles;
  if (index.length / 3 <= most) return null;
  let span = 0;
  for (let n = 0; n < layer.at.length; ++n) span = Math.max(span, layer.at[n]);
  const first = new Map(), boxes = 128, stands = new Uint32Array(layer.at.length / 3);
  for (let v = 0; v < stands.length; ++v) {
    const [x, y, z] = [0, 1, 2].map(a => Math.floor(layer.at[3 * v + a] * boxes / (span + 1)));
    const key = (x * boxes + y) * boxes + z;
    if (!first.has(key)) first.set(key, v);
    stands[v] = first.get(key);
  }
  const out = [];
  for (let n = 0; n < index.length; n += 3) {
    const [a, b, c] = [stands[index[n]], stands[index[n + 1]], stands[index[n + 2]]];
    if (a !== b && b !== c && c !== a) out.push(a, b, c);
  }
  return new Uint32Array(out);
}

class Body {
  constructor(layer) {
    this.name = layer.name;
    this.moves = layer.moves;
    this.poses = layer.poses;
    this.track = layer.track;
    this.colours = COLOURS[layer.moves ? 'moves' : 'stands'];
    this.instances = [];
    this.box = new THREE.Box3();
  }

  static async read(layer) {
    const body = new Body(layer);
    if (layer.track) body.track = await unpack(layer.track);
    if (layer.cells) {
      body.cells = new CellFaces(await unpackAll(layer.cells), body.colours.cells);
      const {min, max, voxel} = layer.cells;
      body.box.expandByPoint(new THREE.Vector3(...min).multiplyScalar(voxel));
      body.box.expandByPoint(new THREE.Vector3(...max).addScalar(1).multiplyScalar(voxel));
    }
    if (layer.points) body.addPoints(await unpackAll(layer.points));
    if (layer.mesh) body.addMesh(await unpackAll(layer.mesh));
    for (const pose of body.poses) body.addInstance(pose);
    return body;
  }

  addPoints(layer) {
    this.points = readPoints(layer);
    this.pointLayer = layer;
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(this.points.position, 3));
    geometry.setAttribute('normal4', new THREE.BufferAttribute(this.points.normal, 4, true));
    geometry.setAttribute('own', new THREE.BufferAttribute(this.points.colour, 4, true));
    this.pointGeometry = geometry;
    this.pointMaterial = pointMaterial(this.colours.points, layer.voxel);
    const rings = new THREE.BufferGeometry(), count = layer.counts.length;
    const middle = new Float32Array(3 * count), radius = new Float32Array(count);
    for (let n = 0; n < count; ++n) {
      middle.set(layer.spheres.subarray(4 * n, 4 * n + 3), 3 * n);
      radius[n] = layer.spheres[4 * n + 3];
    }
    rings.setAttribute('position', new THREE.BufferAttribute(middle, 3));
    rings.setAttribute('radius', new THREE.BufferAttribute(radius, 1));
    this.ringGeometry = rings;
    this.ringMaterial = ringMaterial();
    geometry.computeBoundingBox();
    if (this.points.count) this.box.union(geometry.boundingBox);
  }

  // Drawn from outside up to the point: normals lead inwards.
  normals() {
    if (this.normalGeometry) return this.normalGeometry;
    const {position, normal} = this.points, count = Math.min(MOST_NORMALS, this.points.count);
    const ends = new Float32Array(6 * count), long = 1.5 * this.pointLayer.voxel;
    for (let n = 0; n < count; ++n) {
      for (let a = 0; a < 3; ++a) {
        ends[6 * n + a] = position[3 * n + a];
        ends[6 * n + 3 + a] = position[3 * n + a] - long * normal[4 * n + a] / 127;
      }
    }
    this.normalGeometry = new THREE.BufferGeometry();
    this.normalGeometry.setAttribute('position', new THREE.BufferAttribute(ends, 3));
    return this.normalGeometry;
  }

  addMesh(layer) {
    const count = layer.at.length / 3, position = new Float32Array(3 * count);
    for (let n = 0; n < 3 * count; ++n) position[n] = layer.base[n % 3] + layer.step * layer.at[n];
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute('position', new THREE.BufferAttribute(position, 3));
    geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(layer.triangles.buffer), 1));
    geometry.computeBoundingBox();
    this.meshGeometry = geometry;
    this.meshMaterial = meshMaterial(this.colours.mesh);
    const coarse = coarseTriangles(layer, 150000);
    if (coarse) {
      this.coarseGeometry = new THREE.BufferGeometry();
      this.coarseGeometry.setAttribute('position', geometry.attributes.position);
      this.coarseGeometry.setIndex(new THREE.BufferAttribute(coarse, 1));
    }
    this.triangles = layer.triangles.length / 3;
    if (count) this.box.union(geometry.boundingBox);
  }

  addInstance(pose) {
    const instance = {group: new THREE.Group(), parts: {}};
    const part = (name, object) => {
      object.frustumCulled = false;
      instance.parts[name] = object;
      instance.group.add(object);
    };
    instance.group.position.set(...pose.slice(0, 3));
    instance.group.quaternion.set(...pose.slice(3));
    if (this.cells) {
      instance.cells = new CellInstance(this.cells);
      part('cells', instance.cells.group);
    }
    if (this.points) {
      part('points', new THREE.Points(this.pointGeometry, this.pointMaterial));
      part('clusters', new THREE.Points(this.ringGeometry, this.ringMaterial));
      part('normals', new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({color: COLOURS.normals})));
    }
    if (this.meshGeometry) part('mesh', new THREE.Mesh(this.meshGeometry, this.meshMaterial));
    instance.group.updateMatrixWorld(true);
    this.instances.push(instance);
  }

  // layers: which are on; still: whether the view rests; of the view: pixels of a metre one metre away, as drawn, and
  // of a metre at its middle, how many pixels apart what is drawn is at least, and whether something is cut away: points
  // that look away from the eye are seen only then.
  show(layers, still, {pixels, metre, most, cut}) {
    for (const instance of this.instances) {
      for (const [name, object] of Object.entries(instance.parts)) object.visible = Boolean(layers[name]);
      if (layers.normals && this.points) instance.parts.normals.geometry = this.normals();
      if (this.meshGeometry) instance.parts.mesh.geometry = still || !this.coarseGeometry ? this.meshGeometry : this.coarseGeometry;
      if (this.points && !still && this.pointLayer.counts.length > 3000) instance.parts.clusters.visible = false;
    }
    if (!this.points) return;
    const uniforms = this.pointMaterial.uniforms, apart = this.pointLayer.voxel * metre;
    const share = Math.min(1, (apart / most) ** 2); // of the points, the first of their order
    this.pointGeometry.setDrawRange(0, Math.ceil(share * this.points.count));
    if (this.normalGeometry) this.normalGeometry.setDrawRange(0, still ? Infinity : 20000);
    uniforms.edge.value = this.pointLayer.voxel / Math.sqrt(share);
    uniforms.pixels.value = this.ringMaterial.uniforms.pixels.value = pixels;
    uniforms.clustered.value = layers.clusters ? 1 : 0;
    uniforms.behind.value = cut ? 1 : 0;
  }

  materials() {
    return [this.cells && this.cells.plain, this.cells && this.cells.lined, this.pointMaterial, this.ringMaterial, this.meshMaterial].filter(Boolean);
  }

  place(instance, position, quaternion) {
    instance.group.position.set(...position);
    instance.group.quaternion.set(...quaternion);
    instance.group.updateMatrixWorld(true);
  }

  worldBox() {
    const box = new THREE.Box3();
    for (const instance of this.instances) box.union(this.box.clone().applyMatrix4(instance.group.matrixWorld));
    return box;
  }
}
