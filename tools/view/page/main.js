// SPDX-License-Identifier: MIT
// The view: reads the page's data, draws when something has changed, coarser while it changes, in full when it rests.

const FIELD = 32; // of view, upright [degrees]
const STILL = {pixels: 1.25, after: 220, sharp: 250, slow: 500}; // a cell's size; rests until drawn so, and sharper [ms]
const MOVING = {least: 2.5, most: 14, slow: 30, fast: 21}; // a cell's size; frames [ms]

class View {
  constructor(canvas) {
    this.canvas = canvas;
    const context = canvas.getContext('webgl2', {alpha: false, antialias: false, powerPreference: 'high-performance'}) ||
      canvas.getContext('webgl', {alpha: false, antialias: false});
    if (!context) throw new Error('no WebGL');
    this.renderer = new THREE.WebGLRenderer({canvas, context});
    this.renderer.setClearColor('#f5f6f8');
    this.renderer.localClippingEnabled = true;
    this.renderer.sortObjects = true;
    this.scene = new THREE.Scene();
    this.scene.autoUpdate = true;
    this.camera = new THREE.PerspectiveCamera(FIELD, 1, 0.01, 10);
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    this.controls.enableKeys = false;
    this.controls.screenSpacePanning = true;
    this.controls.addEventListener('change', () => this.touch());
    this.controls.addEventListener('start', () => { this.held = true; });
    this.controls.addEventListener('end', () => { this.held = false; this.touch(); });
    this.bodies = [];
    this.layers = {};
    this.slices = null;
    this.cut = true;
    this.arrows = 1;
    this.coarse = 6; // pixels of a cell while the view moves
    this.finest = STILL.pixels; // and while it rests
    this.patience = STILL.slow; // how long a frame at rest may take before the next are coarser [ms]
    this.fewest = 0.6; // of the pixels along an edge, while the view moves on a machine that is slow at the coarsest
    this.changed = true;
    this.drawn = {faces: 0, frames: 0, full: false, sharp: false};
    new ResizeObserver(() => this.touch()).observe(canvas);
    canvas.addEventListener('keydown', event => this.key(event));
  }

  // Everything as it is known now, in sight.
  fit() {
    const box = new THREE.Box3();
    for (const body of this.bodies) box.union(body.worldBox());
    if (this.motion) box.union(this.motion.box());
    if (box.isEmpty()) box.expandByPoint(new THREE.Vector3()).expandByScalar(0.01);
    this.box = box;
    this.sphere = box.getBoundingSphere(new THREE.Sphere());
    this.look(SIDES.Corner);
  }

  look(direction) {
    const aspect = Math.min(1, this.canvas.clientWidth / this.canvas.clientHeight || 1);
    const far = 0.92 * this.sphere.radius / Math.sin(FIELD / 2 * Math.PI / 180) / aspect;
    this.controls.target.copy(this.sphere.center);
    this.camera.position.set(...direction).normalize().multiplyScalar(far).add(this.sphere.center);
    this.controls.minDistance = this.sphere.radius * 0.02;
    this.controls.maxDistance = this.sphere.radius * 40;
    this.controls.update();
    this.touch();
  }

  // Something has changed: one frame at least is drawn as of a moving view.
  touch() {
    this.changed = true;
    this.drawn.full = this.drawn.sharp = false;
    clearTimeout(this.later);
    this.wake();
  }

  wake() {
    if (!this.waiting && this.sphere) this.waiting = requestAnimationFrame(now => { this.waiting = 0; this.frame(now); });
  }

  key(event) {
    const turn = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]}[event.key];
    const zoom = {'+': 0.9, '=': 0.9, '-': 1 / 0.9, '_': 1 / 0.9}[event.key];
    if (turn) this.turn(0.06 * turn[0], 0.06 * turn[1]);
    else if (zoom) this.camera.position.sub(this.controls.target).multiplyScalar(zoom).add(this.controls.target);
    else if (event.key === ' ' && this.play) this.play(!this.playing);
    else return;
    event.preventDefault();
    this.controls.update();
    this.touch();
  }

  turn(about, up) {
    const ball = new THREE.Spherical().setFromVector3(this.camera.position.clone().sub(this.controls.target));
    ball.theta += about;
    ball.phi += up;
    ball.makeSafe();
    this.camera.position.setFromSpherical(ball).add(this.controls.target);
    this.controls.update();
  }

  advance(now) {
    if (!this.playing) return;
    const {motion} = this, t = motion.t[this.playing.row] + (now - this.playing.from) / 1000;
    motion.seek(motion.rowAt(t));
    this.touch();
    if (motion.row >= motion.rows - 1) this.play(false);
  }

  // Coarser cells when frames come late, finer when there is time; below that fewer pixels.
  pace(now) {
    const since = Math.min(200, now - this.last);
    this.since = 0.75 * (this.since || 25) + 0.25 * since;
    if (this.since > MOVING.slow) {
      if (this.coarse === MOVING.most) this.rough = true;
      this.coarse = Math.min(MOVING.most, 1.12 * this.coarse);
    } else if (this.since < MOVING.fast) {
      this.rough = false;
      this.coarse = Math.max(MOVING.least, 0.985 * this.coarse);
    }
  }

  // Waits until what was drawn is there [ms].
  finish() {
    const from = performance.now(), context = this.renderer.getContext();
    context.readPixels(0, 0, 1, 1, context.RGBA, context.UNSIGNED_BYTE, new Uint8Array(4));
    return performance.now() - from;
  }

  frame(now) {
    this.advance(now);
    const still = !this.changed, sharp = still && this.drawn.full;
    this.changed = false;
    if (!still && this.moved) this.pace(now);
    this.last = now;
    this.moved = !still;
    this.size(sharp ? Math.max(2, devicePixelRatio) : !still && this.rough ? this.fewest * devicePixelRatio : devicePixelRatio);
    this.planes();
    this.near();
    const full = this.draw(still);
    const took = still ? this.finish() : 0;
    if (still && took > this.patience) this.finest = Math.min(MOVING.least, 1.3 * this.finest);
    this.drawn.full = still && full;
    this.drawn.sharp = sharp;
    ++this.drawn.frames;
    if (this.opened === undefined) this.opened = performance.now();
    if (this.drawn.full && this.complete === undefined) this.complete = performance.now();
    clearTimeout(this.later);
    if (this.playing || this.changed || (still && !full)) this.wake();
    else if (!this.held && !still) this.later = setTimeout(() => this.wake(), STILL.after);
    else if (still && !sharp && took < this.patience) this.later = setTimeout(() => this.wake(), STILL.sharp);
    else if (still) this.drawn.sharp = true;
  }

  // False: with more time it would be finer.
  draw(still) {
    const pixels = this.canvas.clientHeight / (2 * Math.tan(FIELD / 2 * Math.PI / 180)), most = still ? this.finest : this.coarse;
    this.camera.updateMatrixWorld();
    this.camera.matrixWorldInverse.getInverse(this.camera.matrixWorld);
    const wanted = {camera: this.camera, pixels, most, until: performance.now() + (still ? 60 : 6), faces: 0};
    const metre = pixels / this.camera.position.distanceTo(this.controls.target);
    let full = true;
    for (const body of this.bodies) {
      body.show(body.layers, still, {pixels: pixels * this.renderer.getPixelRatio(), metre, most, cut: this.cuts > 0});
      if (!body.cells || !body.layers.cells) continue;
      let finest = 0;
      for (const instance of body.instances) {
        full = instance.cells.select(wanted) && full;
        finest = Math.max(finest, instance.cells.finest);
      }
      const edge = body.cells.cells.voxel * metre;
      body.cells.lines(finest === 0 ? Math.max(0, Math.min(1, (edge - 4) / 4)) : 0);
      for (const instance of body.instances) instance.cells.dress();
    }
    if (this.motion) {
      this.motion.show(this.layers, this.arrows);
      this.told();
    }
    this.renderer.render(this.scene, this.camera);
    this.overlay(metre);
    this.drawn.faces = wanted.faces;
    return full;
  }

  size(ratio) {
    const wide = this.canvas.clientWidth, high = this.canvas.clientHeight;
    const now = this.renderer.getSize(new THREE.Vector2());
    if (now.x === wide && now.y === high && this.renderer.getPixelRatio() === ratio) return;
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(wide, high, false);
    this.camera.aspect = wide / high;
    this.camera.updateProjectionMatrix();
  }

  // Near and far planes around what there is.
  near() {
    const away = this.camera.position.distanceTo(this.sphere.center), r = 1.2 * this.sphere.radius;
    this.camera.far = away + r;
    this.camera.near = Math.max((away + r) / 2000, away - r);
    this.camera.updateProjectionMatrix();
  }

  planes() {
    const cut = this.slices && this.cut ? this.slices.filter(slice => slice.on).map(slice => slice.cut()) : [];
    const key = this.cuts = cut.length;
    for (const body of this.bodies) {
      if (body.moves && this.motion) continue;
      const lines = body.points ? body.instances.map(instance => instance.parts.normals.material) : [];
      for (const material of [...body.materials(), ...lines]) {
        material.clippingPlanes = cut;
        material.clipIntersection = true;
        if (material.cuts !== key) material.needsUpdate = true;
        material.cuts = key;
      }
    }
  }

  // A scale bar for lengths at the middle of the view, and where the axes point.
  overlay(metre) {
    const want = 150 / metre, ten = 10 ** Math.floor(Math.log10(want));
    const length = [5, 2, 1].find(n => n * ten <= want) * ten;
    el('scale').firstElementChild.textContent = metres(length, 2);
    el('scale').lastElementChild.style.width = `${length * metre}px`;
    const inverse = this.camera.quaternion.clone().inverse();
    [...el('axes').children].forEach((axis, n) => {
      const end = new THREE.Vector3().setComponent(n, 20).applyQuaternion(inverse), [line, text] = axis.children;
      line.setAttribute('x2', end.x);
      line.setAttribute('y2', -end.y);
      text.setAttribute('x', 1.3 * end.x);
      text.setAttribute('y', 3 - 1.3 * end.y);
    });
  }
}

function needs() {
  if (typeof DecompressionStream === 'undefined')
    return 'This browser cannot unpack the page’s data: it is older than 2023. Any later Firefox, Chrome, Edge or Safari can.';
  const probe = document.createElement('canvas');
  if (!probe.getContext('webgl2') && !probe.getContext('webgl'))
    return 'This browser draws no 3D: WebGL is switched off or its graphics driver is refused. The figures beside this are complete; for the picture try another browser, or switch on hardware acceleration in its settings.';
  return '';
}

async function load(page) {
  for (const library of document.querySelectorAll('script.library')) {
    const text = new TextDecoder().decode(await inflate(library.textContent));
    document.head.append(Object.assign(document.createElement('script'), {textContent: text}));
    library.textContent = '';
  }
  const view = new View(el('view'));
  for (const layer of page.bodies) {
    const body = await Body.read(layer);
    view.bodies.push(body);
    for (const instance of body.instances) view.scene.add(instance.group);
  }
  if (page.recorded) {
    view.motion = await Motion.read(page.recorded);
    const box = new THREE.Box3();
    for (const body of view.bodies) box.union(body.worldBox());
    view.motion.attach(view.scene, view.bodies, 0.3 * box.getBoundingSphere(new THREE.Sphere()).radius);
  }
  layersPanel(view);
  slicesPanel(view);
  timePanel(view);
  sidesPanel(view);
  view.fit();
  return view;
}

async function main() {
  const page = JSON.parse(el('page').textContent);
  figuresPanel(page);
  const missing = needs();
  el('say').textContent = missing || 'Opening …';
  if (missing) return;
  try {
    window.voxshell = await load(page);
    el('say').textContent = '';
  } catch (error) {
    el('say').textContent = `This page could not be drawn: ${error.message}`;
    throw error;
  }
}
