// SPDX-License-Identifier: MIT
// The side panel: layers, slices, time and figures. It tells the view what is wanted, and draws nothing itself.

const el = id => document.getElementById(id);

function make(kind, attributes, ...children) {
  const element = Object.assign(document.createElement(kind), attributes);
  element.append(...children);
  return element;
}

const LAYERS = [
  ['mesh', 'Mesh', body => body.meshGeometry, body => body.colours.mesh],
  ['cells', 'Surface cells', body => body.cells, body => body.colours.cells],
  ['points', 'Points', body => body.points, body => body.colours.points],
  ['normals', 'Normals (they lead inwards)', body => body.points, () => COLOURS.normals],
  ['clusters', 'Clusters', body => body.points, () => COLOURS.clusters],
];

// What is seen at first: cells where there are any, else points or the mesh.
function atFirst(body) {
  return {cells: true, mesh: !body.cells, points: !body.cells};
}

// Bodies that are switched together.
function groupsOf(bodies) {
  if (bodies.length <= 4) return bodies.map(body => ({title: body.name, bodies: [body]}));
  return [false, true].map(moves => ({title: moves ? 'what moves' : `${bodies.filter(b => !b.moves).length} parts`, bodies: bodies.filter(b => b.moves === moves)}))
    .filter(group => group.bodies.length);
}

function checkbox(id, text, on, colour, change) {
  const box = make('input', {type: 'checkbox', id, checked: on});
  box.addEventListener('change', () => change(box.checked));
  const swatch = make('span', {className: 'swatch'});
  swatch.style.background = colour;
  return make('label', {className: 'row'}, box, swatch, text);
}

function layersPanel(view) {
  groupsOf(view.bodies).forEach((group, n) => {
    if (view.bodies.length > 1) el('layers').append(make('h3', {textContent: group.title}));
    for (const body of group.bodies) body.layers = atFirst(body);
    for (const [name, text, has, colour] of LAYERS) {
      const with_it = group.bodies.filter(has);
      if (!with_it.length) continue;
      el('layers').append(checkbox(`layer-${n}-${name}`, text, Boolean(with_it[0].layers[name]), colour(with_it[0]), on => {
        for (const body of with_it) body.layers[name] = on;
        view.touch();
      }));
    }
  });
  if (view.motion) {
    el('layers').append(make('h3', {textContent: view.motion.source}));
    view.layers = {path: true, forces: true};
    el('layers').append(checkbox('layer-path', 'Way of the body', true, '#606060', on => { view.layers.path = on; view.touch(); }));
    if (view.motion.forces)
      el('layers').append(checkbox('layer-forces', 'Forces', true, FORCES.collision, on => { view.layers.forces = on; view.touch(); }));
  }
}

const METRES = [[1e-6, 'µm'], [1e-3, 'mm'], [1, 'm']];
function metres(x, digits = 4) {
  const [unit, name] = METRES.find(([u]) => Math.abs(x) < 1000 * u) || METRES[2];
  return `${Number((x / unit).toPrecision(digits))} ${name}`;
}

// What the colours of a section say.
function legend(cells, shows) {
  const css = colour => `rgb(${colour})`, swatch = colour => {
    const element = make('span', {className: 'swatch'});
    element.style.background = css(colour);
    return element;
  };
  if (shows === 'state' || !cells[shows]) {
    el('legend').replaceChildren(swatch(STATE_COLOURS.surface), 'surface', swatch(STATE_COLOURS.interior), 'interior');
    return;
  }
  const most = shows === 'layer' ? `${cells.layers + 1} layers` : metres(cells.band), scale = make('i', {});
  scale.style.background = `linear-gradient(90deg, ${[-1, -0.5, 0, 0.5, 1].map(share => css(distanceColour(share)))})`;
  el('legend').replaceChildren(`${most} inside`, scale, `${most} outside`);
}

function slicesPanel(view) {
  const bodies = view.bodies.filter(body => body.cells);
  if (!bodies.length) return;
  el('slices').hidden = false;
  bodies.forEach((body, n) => el('sliced').append(make('option', {value: n, textContent: body.name})));
  el('sliced-of').hidden = bodies.length < 2;
  const shows = {state: 'surface and interior', layer: 'layers', distance: 'distance'};
  for (const [value, text] of Object.entries(shows))
    if (value === 'state' || bodies.some(body => body.cells.cells[value])) el('shows').append(make('option', {value, textContent: text}));
  el('shows-of').hidden = el('shows').length < 2;

  const rows = ['X', 'Y', 'Z'].map((name, axis) => {
    const box = make('input', {type: 'checkbox', id: `slice-${axis}`, checked: false});
    const range = make('input', {type: 'range', id: `slice-at-${axis}`, step: 1});
    range.setAttribute('aria-label', `Where the slice across ${name} is`);
    const says = make('output', {});
    el('planes').append(make('div', {className: 'row'}, make('label', {className: 'row'}, box, name), range, says));
    return {box, range, says};
  });
  const apply = () => {
    rows.forEach(({box, range, says}, axis) => {
      const slice = view.slices[axis];
      slice.show(box.checked, Number(range.value), el('shows').value);
      says.textContent = metres(slice.coordinate());
    });
    view.cut = el('cut').checked;
    legend(view.slices[0].body.cells.cells, el('shows').value);
    view.touch();
  };
  const choose = () => {
    if (view.slices) for (const slice of view.slices) slice.show(false, slice.at, 'state');
    const body = bodies[el('sliced').value];
    if (!body.slices) body.slices = [0, 1, 2].map(axis => new Slice(body, axis));
    view.slices = body.slices;
    rows.forEach(({range}, axis) => Object.assign(range, {min: view.slices[axis].low, max: view.slices[axis].high, value: view.slices[axis].at}));
    apply();
  };
  rows.forEach(({box, range}) => {
    box.addEventListener('change', apply);
    range.addEventListener('input', () => { box.checked = true; apply(); });
  });
  el('cut').addEventListener('change', apply);
  el('shows').addEventListener('change', apply);
  el('sliced').addEventListener('change', choose);
  choose();
}

function timePanel(view) {
  const motion = view.motion;
  if (!motion) return;
  el('time').hidden = false;
  el('seek').max = motion.rows - 1;
  el('chart').hidden = el('longer').hidden = !motion.forces;
  view.told = () => {
    el('seek').value = motion.row;
    el('when').textContent = `${motion.t[motion.row].toFixed(3)} s`;
    if (!motion.forces) return;
    const line = (name, text) => {
      const swatch = make('span', {className: 'swatch'});
      swatch.style.background = FORCES[name];
      return make('span', {}, swatch, `${text} ${motion.force[name][motion.row].toFixed(3)} N`);
    };
    el('forces').replaceChildren(line('collision', 'of contact'), line('output', 'at the hand'),
      make('span', {textContent: `${motion.contacts[motion.row]} points touch`}));
    motion.chart(el('chart'));
  };
  const play = on => {
    view.playing = on ? {from: performance.now(), row: motion.row >= motion.rows - 1 ? 0 : motion.row} : null;
    el('play').setAttribute('aria-pressed', on);
    el('play').textContent = on ? 'Stop' : 'Play';
    view.touch();
  };
  view.play = play;
  const seek = row => {
    if (view.playing) play(false);
    motion.seek(row);
    view.touch();
  };
  el('play').addEventListener('click', () => play(!view.playing));
  el('seek').addEventListener('input', () => seek(Number(el('seek').value)));
  const click = event => {
    const share = event.offsetX / el('chart').clientWidth;
    seek(motion.rowAt(motion.t[0] + share * motion.seconds()));
  };
  el('chart').addEventListener('pointerdown', event => { el('chart').setPointerCapture(event.pointerId); click(event); });
  el('chart').addEventListener('pointermove', event => { if (event.buttons) click(event); });
  el('arrows').addEventListener('input', () => { view.arrows = 10 ** Number(el('arrows').value); view.touch(); });
}

const SIDES = {Corner: [1, 0.75, 1.25], Front: [0, 0, 1], Right: [1, 0, 0], Top: [0, 1, 0.0001], Left: [-1, 0, 0], Back: [0, 0, -1]};

function sidesPanel(view) {
  for (const [name, direction] of Object.entries(SIDES)) {
    const button = make('button', {type: 'button', textContent: name, id: `side-${name.toLowerCase()}`});
    button.addEventListener('click', () => view.look(direction));
    el('sides').append(button);
  }
}

function figuresPanel(page) {
  el('title').textContent = page.title;
  el('summary').textContent = page.figures.length ? page.figures[0].says.replace(/, source.*/, '').replace(/^[^:]*: /, '') : '';
  page.figures.forEach((figure, n) => {
    const table = make('table', {});
    for (const [name, value] of figure.rows) table.append(make('tr', {}, make('td', {textContent: name}), make('td', {textContent: value})));
    el('figures').append(make('details', {open: n < 2 || /\.(csv|rec)$/.test(figure.title)}, make('summary', {textContent: figure.title}), table));
  });
  el('made').textContent = `voxshell ${page.version} view. Metres, +Y up. Drag turns, wheel zooms, right drag shifts; keys: arrows, + and −, space plays.`;
}
