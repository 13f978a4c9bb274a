// The 3D view: a parallel projection with its own depth buffer, so that it needs no graphics driver, prints, and looks
// the same everywhere. Bodies are flat polygons, filled line by line; hidden paths show through.

function makeScene(canvas, world, lines, spots) {
  const context = canvas.getContext("2d");
  const buffer = document.createElement("canvas");
  const start = { heading: -28, elevation: 38, zoom: 1, east: 0, north: 0 };
  let view = { ...start }, marker = null, chosen = -1, home = null, waiting = 0;
  let faces = [], strokes = [], colors = null;

  const middle = [0, 1].map((k) => (world.lower[k] + world.upper[k]) / 2);
  const radius = Math.hypot(world.upper[0] - world.lower[0], world.upper[1] - world.lower[1]) / 2;
  const lift = world.lift, floor = world.floor;
  const sun = unit([-0.45, -0.35, 0.82]);

  function unit(v) { const n = Math.hypot(...v) || 1; return v.map((x) => x / n); }

  function color(name) {
    const probe = document.createElement("i");
    probe.style.color = `var(${name})`;
    document.body.append(probe);
    const found = getComputedStyle(probe).color.match(/[\d.]+/g).slice(0, 3).map(Number);
    probe.remove();
    return found;
  }
  const mix = (a, b, t) => a.map((x, k) => x + (b[k] - x) * Math.min(Math.max(t, 0), 1));
  const pack = (c) => (255 << 24) | (Math.min(255, c[2]) << 16) | (Math.min(255, c[1]) << 8) | Math.min(255, c[0]);

  function normalOf(ring) {  // Newell's method, with the stretched heights
    const n = [0, 0, 0];
    for (let i = 0; i < ring.length; i++) {
      const a = ring[i], b = ring[(i + 1) % ring.length];
      n[0] += (a[1] - b[1]) * (a[2] + b[2]) * lift; n[1] += (a[2] - b[2]) * lift * (a[0] + b[0]); n[2] += (a[0] - b[0]) * (a[1] + b[1]);
    }
    return unit(n);
  }
  function addFace(rings, tint) {
    const normal = normalOf(rings[0]);
    const light = 0.66 + 0.4 * Math.max(0, normal[0] * sun[0] + normal[1] * sun[1] + normal[2] * sun[2]);
    faces.push({ rings, normal, ink: pack(tint.map((c) => c * light)) });
  }
  const turnsLeft = (ring) => ring.reduce((sum, a, i) => {
    const b = ring[(i + 1) % ring.length];
    return sum + a[0] * b[1] - b[0] * a[1];
  }, 0) > 0;

  function build() {
    faces = []; strokes = [];
    colors = Object.fromEntries(["--planned", "--flown", "--good", "--bad", "--ink", "--card", "--edge", "--focus", "--quiet", "--paper"]
      .map((name) => [name, color(name)]));
    const [low, high] = [color("--low-ground"), color("--high-ground")];
    const [lowRoof, highRoof] = [color("--low-roof"), color("--high-roof")];
    const g = world.ground, at = (i, j) => [g.east + j * g.step_east, g.north + i * g.step_north, g.heights[i * g.columns + j]];
    const least = Math.min(...g.heights), most = Math.max(Math.max(...g.heights), least + 5);
    for (let i = 0; i + 1 < g.rows; i++) for (let j = 0; j + 1 < g.columns; j++) {
      const quad = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
      addFace([quad], mix(low, high, (quad[0][2] + quad[2][2] - 2 * least) / 2 / (most - least)));
    }
    for (const zone of world.zones) for (const ring of zone.rings) ring.forEach((a, i) => {
      const b = ring[(i + 1) % ring.length], [base, top] = [Math.max(zone.base, floor), Math.min(zone.top, world.highest)];
      for (const up of [base, top]) strokes.push([[...a, up], [...b, up], "--bad"]);
      strokes.push([[...a, base], [...a, top], "--bad"]);
    });
    for (const body of world.bodies) {
      const tint = mix(lowRoof, highRoof, (body.top ?? body.center[2] + body.radius) / world.highest);
      if (body.radius !== undefined) { addBall(body, tint); continue; }
      const rings = body.rings.map((ring, n) => (turnsLeft(ring) === (n === 0) ? ring : [...ring].reverse()));
      addFace(rings.map((ring) => ring.map(([e, n]) => [e, n, body.top])), tint);
      for (const ring of rings) ring.forEach((a, i) => {
        const b = ring[(i + 1) % ring.length];
        addFace([[[...a, body.base], [...b, body.base], [...b, body.top], [...a, body.top]]], tint);
        strokes.push([[...a, body.top], [...b, body.top]]);
        if (!body.round) strokes.push([[...a, body.base], [...a, body.top]]);
      });
    }
  }
  function addBall({ center, radius: r }, tint) {
    const N = 28, M = 14;
    const node = (i, j) => {
      const a = (2 * Math.PI * j) / N, b = Math.PI * (i / M - 0.5);
      return [center[0] + r * Math.cos(b) * Math.cos(a), center[1] + r * Math.cos(b) * Math.sin(a), center[2] + r * Math.sin(b)];
    };
    for (let i = 0; i < M; i++) for (let j = 0; j < N; j++) {
      const quad = [node(i, j), node(i, j + 1), node(i + 1, j + 1), node(i + 1, j)];
      addFace([i === 0 ? quad.slice(1) : i === M - 1 ? quad.slice(0, 3) : quad], tint);
    }
  }

  function camera(width, height) {
    const h = (view.heading * Math.PI) / 180, e = (view.elevation * Math.PI) / 180;
    const s = Math.sin(e), c = Math.cos(e);
    const scale = (view.zoom * Math.min(width / (2 * radius * 0.98), height / (2 * radius * (0.93 * s + 0.12) + (world.highest - floor) * lift * c)));
    const right = [Math.cos(h), -Math.sin(h), 0], up = [s * Math.sin(h), s * Math.cos(h), c * lift];
    const near = [-c * Math.sin(h), -c * Math.cos(h), s * lift];
    const pivot = [middle[0] + view.east, middle[1] + view.north, floor + (world.highest - floor) * 0.4];
    const dot = (a, p) => a[0] * (p[0] - pivot[0]) + a[1] * (p[1] - pivot[1]) + a[2] * (p[2] - pivot[2]);
    return {
      scale, near,
      to: (p) => [width / 2 + scale * dot(right, p), height / 2 - scale * dot(up, p), scale * dot(near, p)],
    };
  }

  function paint(width, height) {
    const ink = new Uint32Array(width * height).fill(pack(colors["--paper"]));
    const depth = new Float32Array(width * height).fill(-Infinity);
    const { to, near, scale } = camera(width, height);
    const towards = [near[0], near[1], near[2] / lift];
    const cuts = [];
    for (const face of faces) {
      const n = face.normal;
      if (n[0] * towards[0] + n[1] * towards[1] + n[2] * towards[2] <= 1e-6) continue;
      fill(face.rings.map((ring) => ring.map(to)), face.ink);
    }
    const thick = Math.max(1, width / 900), edge = colors["--edge"];
    const crisp = Math.min(0.75, scale / thick - 0.3);  // outlines would blacken bodies of a few pixels
    if (crisp > 0.05) for (const [a, b, tone] of strokes)
      stroke(to(a), to(b), thick * 0.5, tone ? colors[tone] : edge, 1.5 * thick, 0, tone ? 1 : crisp);
    for (const spot of spots) stroke(to(spot), to([spot[0], spot[1], spot[3]]), thick * 0.5, colors["--quiet"], thick, 0, 0.8);
    for (const line of lines) {
      const tone = colors[line.color], wide = thick * line.width, ends = line.points.map(to);
      for (let i = 0; i + 1 < ends.length; i++)
        if (!line.dashed || i % 6 < 4) stroke(ends[i], ends[i + 1], wide, tone, 3 * thick, 0.28, 1);
    }
    return new ImageData(new Uint8ClampedArray(ink.buffer), width, height);

    function fill(rings, tone) {
      let nx = 0, ny = 0, nz = 0, top = Infinity, bottom = -Infinity;
      const first = rings[0];
      for (let i = 0; i < first.length; i++) {
        const a = first[i], b = first[(i + 1) % first.length];
        nx += (a[1] - b[1]) * (a[2] + b[2]); ny += (a[2] - b[2]) * (a[0] + b[0]); nz += (a[0] - b[0]) * (a[1] + b[1]);
        if (a[1] < top) top = a[1];
        if (a[1] > bottom) bottom = a[1];
      }
      if (Math.abs(nz) < 1e-9) return;
      const zx = -nx / nz, zy = -ny / nz, [x0, y0, z0] = first[0];
      const last = Math.min(height - 1, Math.floor(bottom - 0.5));
      for (let y = Math.max(0, Math.ceil(top - 0.5)); y <= last; y++) {
        const level = y + 0.5;
        cuts.length = 0;
        for (const ring of rings) for (let i = 0, j = ring.length - 1; i < ring.length; j = i++) {
          const a = ring[j], b = ring[i];
          if ((a[1] > level) !== (b[1] > level)) cuts.push(a[0] + ((level - a[1]) / (b[1] - a[1])) * (b[0] - a[0]));
        }
        cuts.sort((p, q) => p - q);
        for (let k = 0; k + 1 < cuts.length; k += 2) {
          const end = Math.min(width - 1, Math.ceil(cuts[k + 1] - 0.5) - 1);
          let x = Math.max(0, Math.ceil(cuts[k] - 0.5)), z = z0 + zx * (x + 0.5 - x0) + zy * (level - y0);
          for (let at = y * width + x; x <= end; x++, at++, z += zx) if (z > depth[at]) { depth[at] = z; ink[at] = tone; }
        }
      }
    }
    function stroke(a, b, half, tone, bias, through, strength) {
      const steps = Math.max(1, Math.ceil(Math.max(Math.abs(b[0] - a[0]), Math.abs(b[1] - a[1])))), r = Math.ceil(half);
      for (let s = 0; s <= steps; s++) {
        const t = s / steps, x = a[0] + t * (b[0] - a[0]), y = a[1] + t * (b[1] - a[1]), z = a[2] + t * (b[2] - a[2]) + bias;
        for (let j = Math.round(y) - r; j <= Math.round(y) + r; j++) for (let i = Math.round(x) - r; i <= Math.round(x) + r; i++) {
          if (i < 0 || j < 0 || i >= width || j >= height || (i - x) ** 2 + (j - y) ** 2 > half * half + 0.3) continue;
          const at = j * width + i, seen = z >= depth[at], share = seen ? strength : through && s % 3 === 0 ? through : 0;
          if (!share) continue;
          const under = ink[at], keep = 1 - share;
          ink[at] = pack([(under & 255) * keep + tone[0] * share, ((under >> 8) & 255) * keep + tone[1] * share, ((under >> 16) & 255) * keep + tone[2] * share]);
        }
      }
    }
  }

  function show() {  // copies the painted image to the screen, and draws the moving marks
    if (!colors) return;
    const ratio = Math.min(window.devicePixelRatio || 1, 2), { clientWidth: width, clientHeight: height } = canvas;
    canvas.width = width * ratio; canvas.height = height * ratio;
    context.imageSmoothingQuality = "high";
    context.drawImage(buffer, 0, 0, canvas.width, canvas.height);
    context.scale(ratio, ratio);
    const { to } = camera(width, height), css = (name) => `rgb(${colors[name].join(" ")})`;
    if (home) {
      context.strokeStyle = css(home.clear ? "--good" : "--bad");
      context.lineWidth = 2.4;
      context.setLineDash([7, 4]);
      context.beginPath();
      home.points.forEach((place, n) => context[n ? "lineTo" : "moveTo"](...to(place).slice(0, 2)));
      context.stroke();
      context.setLineDash([]);
    }
    spots.forEach((spot, n) => dot(to(spot), n === chosen ? 6 : 3.4, css(n === chosen ? "--focus" : "--card"), css(n === chosen ? "--ink" : "--planned")));
    if (marker) dot(to(marker), 5, css("--ink"), css("--card"));
    const [x, y] = [26, height - 26], h = (-view.heading * Math.PI) / 180, flat = Math.sin((view.elevation * Math.PI) / 180);
    context.strokeStyle = context.fillStyle = css("--quiet");
    context.beginPath(); context.moveTo(x - 11 * Math.sin(h), y + 11 * Math.cos(h) * flat); context.lineTo(x + 11 * Math.sin(h), y - 11 * Math.cos(h) * flat); context.stroke();
    context.font = "700 11px system-ui, sans-serif"; context.textAlign = "center"; context.textBaseline = "middle";
    context.fillText("N", x + 18 * Math.sin(h), y - 18 * Math.cos(h) * flat);
    function dot([px, py], size, inside, round) {
      context.beginPath(); context.arc(px, py, size, 0, 7); context.fillStyle = inside; context.fill();
      context.lineWidth = 1.8; context.strokeStyle = round; context.stroke();
    }
  }
  function render(fine) {
    const width = canvas.clientWidth, height = canvas.clientHeight;
    if (!width || !height) return;
    if (!colors) build();
    const grain = fine ? 2 : 1;
    buffer.width = width * grain; buffer.height = height * grain;
    buffer.getContext("2d").putImageData(paint(buffer.width, buffer.height), 0, 0);
    canvas.dataset.heading = view.heading.toFixed(1);
    canvas.dataset.elevation = view.elevation.toFixed(1);
    canvas.dataset.zoom = view.zoom.toFixed(2);
    canvas.dataset.spots = JSON.stringify(spots.map((spot) => camera(width, height).to(spot).slice(0, 2).map(Math.round)));
    show();
  }
  let pending = false;
  function move(change) {  // coarse in motion, fine at rest
    view = { ...view, ...change };
    view.elevation = Math.min(90, Math.max(4, view.elevation));
    view.zoom = Math.min(20, Math.max(0.5, view.zoom));
    clearTimeout(waiting);
    waiting = setTimeout(() => render(true), 140);
    if (!pending) { pending = true; requestAnimationFrame(() => { pending = false; render(false); }); }
  }
  function pan(dx, dy) {
    const { scale } = camera(canvas.clientWidth, canvas.clientHeight), h = (view.heading * Math.PI) / 180;
    const flat = Math.max(0.3, Math.sin((view.elevation * Math.PI) / 180)), right = -dx / scale, ahead = dy / scale / flat;
    move({ east: view.east + right * Math.cos(h) + ahead * Math.sin(h), north: view.north - right * Math.sin(h) + ahead * Math.cos(h) });
  }

  const fingers = new Map();
  let traveled = 0;
  canvas.addEventListener("pointerdown", (event) => {
    fingers.set(event.pointerId, [event.offsetX, event.offsetY]);
    canvas.setPointerCapture(event.pointerId);
    traveled = 0;
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    const others = [...fingers].filter(([id]) => id !== event.pointerId).map(([, place]) => place);
    const dx = event.offsetX - before[0], dy = event.offsetY - before[1];
    traveled += Math.abs(dx) + Math.abs(dy);
    if (others.length) {
      const apart = (p) => Math.hypot(p[0] - others[0][0], p[1] - others[0][1]) || 1;
      move({ zoom: (view.zoom * apart([event.offsetX, event.offsetY])) / apart(before) });
    } else if (event.shiftKey || event.buttons === 2) pan(dx, dy);
    else move({ heading: view.heading + dx * 0.45, elevation: view.elevation + dy * 0.35 });
    fingers.set(event.pointerId, [event.offsetX, event.offsetY]);
  });
  for (const kind of ["pointerup", "pointercancel"]) canvas.addEventListener(kind, (event) => fingers.delete(event.pointerId));
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && document.activeElement !== canvas) return;  // the page scrolls until the view has the focus
    event.preventDefault();
    move({ zoom: view.zoom * Math.exp(-event.deltaY * 0.0016) });
  }, { passive: false });
  const keys = {
    ArrowLeft: () => ({ heading: view.heading - 6 }), ArrowRight: () => ({ heading: view.heading + 6 }),
    ArrowUp: () => ({ elevation: view.elevation + 4 }), ArrowDown: () => ({ elevation: view.elevation - 4 }),
    "+": () => ({ zoom: view.zoom * 1.25 }), "=": () => ({ zoom: view.zoom * 1.25 }), "-": () => ({ zoom: view.zoom / 1.25 }),
    0: () => start, Home: () => start,
  };
  canvas.addEventListener("keydown", (event) => {
    if (!keys[event.key] || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    move(keys[event.key]());
  });
  new ResizeObserver(() => setTimeout(() => render(true))).observe(canvas);  // after the first paint of the page
  for (const query of ["(prefers-color-scheme: dark)", "print"])
    matchMedia(query).addEventListener("change", () => { build(); render(true); });

  return {
    key: (name) => move(keys[name]()),
    mark(place, stop, way) { marker = place; chosen = stop; home = way; show(); },
    nearestSpot(x, y) {  // returns the stop at a place on the canvas, or -1; a drag is not a click
      if (traveled > 5) return -1;
      const { to } = camera(canvas.clientWidth, canvas.clientHeight);
      const apart = spots.map((spot) => { const [px, py] = to(spot); return Math.hypot(px - x, py - y); });
      const n = apart.indexOf(Math.min(...apart));
      return apart[n] < 16 ? n : -1;
    },
  };
}
