// SPDX-License-Identifier: MIT
// What was recorded, or is planned: where the body is at a time, and the forces that act there.

const FORCES = {collision: '#d55e00', output: '#0072b2'};

class Motion {
  static async read(layer) {
    const motion = new Motion();
    Object.assign(motion, layer);
    const columns = await unpack(layer.columns), body = await unpack(layer.body), n = layer.rows;
    const column = (from, c) => from.subarray(c * n, (c + 1) * n);
    motion.t = column(columns, 0);
    ['device', 'hand', 'collision', 'torque', 'output'].forEach((name, c) => {
      motion[name] = [0, 1, 2].map(a => column(columns, 1 + 3 * c + a));
    });
    motion.contacts = column(columns, 16);
    motion.pose = [0, 1, 2, 3, 4, 5, 6].map(c => column(body, c));
    const size = v => v[0].map((_, row) => Math.hypot(v[0][row], v[1][row], v[2][row]));
    motion.force = {collision: size(motion.collision), output: size(motion.output)};
    motion.peak = Math.max(...['collision', 'output'].map(name => motion.force[name].reduce((a, b) => Math.max(a, b), 0)));
    motion.row = 0;
    return motion;
  }

  // Bodies: all; `large`: what a force as large as any is drawn as [m].
  attach(scene, bodies, large) {
    this.bodies = bodies;
    this.large = large;
    this.group = new THREE.Group();
    const path = new Float32Array(3 * this.rows);
    for (let n = 0; n < this.rows; ++n) for (let a = 0; a < 3; ++a) path[3 * n + a] = this.pose[a][n];
    const line = new THREE.BufferGeometry();
    line.setAttribute('position', new THREE.BufferAttribute(path, 3));
    this.path = new THREE.Line(line, new THREE.LineBasicMaterial({color: '#606060'}));
    this.path.frustumCulled = false;
    this.group.add(this.path);
    this.arrows = {};
    for (const [name, colour] of Object.entries(FORCES)) {
      const arrow = new THREE.Group(), material = new THREE.MeshBasicMaterial({color: colour, depthTest: false});
      const shaft = new THREE.Mesh(new THREE.CylinderBufferGeometry(1, 1, 1, 12), material);
      const head = new THREE.Mesh(new THREE.ConeBufferGeometry(1, 1, 16), material);
      shaft.renderOrder = head.renderOrder = name === 'output' ? 11 : 10;
      arrow.add(shaft, head);
      arrow.visible = false;
      this.arrows[name] = {arrow, shaft, head};
      this.group.add(arrow);
    }
    scene.add(this.group);
    this.seek(0);
  }

  seconds() {
    return this.t[this.rows - 1] - this.t[0];
  }

  rowAt(t) {
    let low = 0, high = this.rows - 1;
    while (low < high) {
      const middle = low + high + 1 >> 1;
      if (this.t[middle] <= t) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  seek(row) {
    this.row = Math.max(0, Math.min(this.rows - 1, Math.round(row)));
    const at = columns => columns.map(column => column[this.row]);
    for (const body of this.bodies) {
      if (body.moves) {
        const pose = at(this.pose);
        for (const instance of body.instances) body.place(instance, pose.slice(0, 3), pose.slice(3));
      } else if (body.track) {
        const pose = [0, 1, 2, 3, 4, 5, 6].map(c => body.track[c * this.rows + this.row]);
        for (const instance of body.instances) body.place(instance, pose.slice(0, 3), pose.slice(3));
      }
    }
  }

  // Arrows at the body's place, `scale` times as long as by default.
  show(layers, scale) {
    this.path.visible = Boolean(layers.path);
    for (const [name, {arrow, shaft, head}] of Object.entries(this.arrows)) {
      const force = this[name].map(column => column[this.row]), size = Math.hypot(...force);
      const long = this.peak > 0 ? size / this.peak * this.large * scale : 0;
      arrow.visible = Boolean(layers.forces) && long > 0;
      if (!arrow.visible) continue;
      const wide = 0.02 * this.large * (name === 'output' ? 1 : 2.2), tip = Math.min(long, 7 * wide);
      shaft.scale.set(wide, Math.max(long - tip, 1e-9), wide);
      shaft.position.y = (long - tip) / 2;
      head.scale.set(2.6 * wide, tip, 2.6 * wide);
      head.position.y = long - tip / 2;
      arrow.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), new THREE.Vector3(...force).divideScalar(size));
      arrow.position.set(...this.pose.slice(0, 3).map(column => column[this.row]));
    }
  }

  box() {
    return new THREE.Box3().setFromBufferAttribute(this.path.geometry.attributes.position);
  }

  // Both forces over time, and where it is now.
  chart(canvas) {
    const wide = canvas.width = canvas.clientWidth * devicePixelRatio, high = canvas.height = canvas.clientHeight * devicePixelRatio;
    const pen = canvas.getContext('2d'), left = 1, t0 = this.t[0], span = this.seconds() || 1;
    const x = t => left + (t - t0) / span * (wide - 2 * left), y = f => high - 2 - f / (this.peak || 1) * (high - 6);
    pen.clearRect(0, 0, wide, high);
    pen.lineWidth = 1.25 * devicePixelRatio;
    const step = Math.max(1, Math.floor(this.rows / (4 * wide)));
    for (const [name, colour] of Object.entries(FORCES)) {
      pen.strokeStyle = colour;
      pen.beginPath();
      for (let n = 0; n < this.rows; n += step) pen.lineTo(x(this.t[n]), y(this.force[name][n]));
      pen.stroke();
    }
    pen.strokeStyle = '#202020';
    pen.beginPath();
    pen.moveTo(x(this.t[this.row]), 0);
    pen.lineTo(x(this.t[this.row]), high);
    pen.stroke();
  }
}
