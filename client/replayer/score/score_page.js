// Shows the paths in space at the slider's time.  The page defines `score` before this script.
const canvas = document.getElementById("space");
const slider = document.getElementById("time");
const now = document.getElementById("now");
const clock = document.getElementById("clock");
const {time, tracks} = score;
let azimuth = 0.6;
let height = 0.45;
let nearer = 1; // zoom; above 1 it is centred on the expert's hand

const all = tracks.flatMap(({p}) => p);
const middle = [0, 1, 2].map((i) => {
  const values = all.map((p) => p[i]);
  return (Math.min(...values) + Math.max(...values)) / 2;
});
const reach = Math.max(1, ...all.map((p) => Math.hypot(...p.map((x, i) => x - middle[i]))));
const look = (name) => getComputedStyle(document.body).getPropertyValue(name);
const series = (i) => `--series-${(i % 8) + 1}`;

/// Returns right and up coordinates on the screen, in millimetres from `about`; y is up, as in the scenes.
function onPaper(p, about) {
  const [x, y, z] = p.map((value, i) => value - about[i]);
  const right = x * Math.cos(azimuth) - z * Math.sin(azimuth);
  const near = x * Math.sin(azimuth) + z * Math.cos(azimuth);
  return [right, y * Math.cos(height) - near * Math.sin(height)];
}

function draw() {
  const scale = window.devicePixelRatio || 1;
  const {clientWidth: w, clientHeight: h} = canvas;
  canvas.width = w * scale;
  canvas.height = h * scale;
  const pen = canvas.getContext("2d");
  pen.scale(scale, scale);
  const zoom = (0.46 * nearer * Math.min(w, h)) / reach;
  const k = Number(slider.value);
  const about = nearer > 1 ? tracks[0].p[k] : middle;
  const at = (p) => {
    const [x, y] = onPaper(p, about);
    return [w / 2 + zoom * x, h / 2 - zoom * y];
  };
  pen.lineJoin = "round";
  tracks.forEach(({p}, i) => {
    for (const [from, to, strength] of [[0, p.length, 0.35], [0, k + 1, 1]]) {
      pen.globalAlpha = strength;
      pen.strokeStyle = look(series(i));
      pen.lineWidth = i === 0 ? 3 : 2;
      pen.beginPath();
      for (let j = from; j < to; j++) pen.lineTo(...at(p[j]));
      pen.stroke();
    }
  });
  pen.globalAlpha = 1;
  tracks.forEach(({p}, i) => {
    pen.fillStyle = look(series(i));
    pen.beginPath();
    pen.arc(...at(p[k]), 5, 0, 2 * Math.PI);
    pen.fill();
  });
  // The scale bar.
  const round = 10 ** Math.floor(Math.log10(reach / nearer));
  pen.strokeStyle = pen.fillStyle = look("--quiet");
  pen.lineWidth = 1.5;
  pen.beginPath();
  pen.moveTo(16, h - 16);
  pen.lineTo(16 + zoom * round, h - 16);
  pen.stroke();
  pen.font = `13px ${look("--font")}`;
  pen.fillText(`${round} mm`, 16, h - 22);
}

function show() {
  const k = Number(slider.value);
  clock.textContent = `${time[k].toFixed(2)} s`;
  const lines = tracks.map(({name, f, d}, i) => {
    const line = document.createElement("li");
    const dot = document.createElement("i");
    dot.style.background = `var(${series(i)})`;
    const force = `${f[k].toFixed(2)} N`;
    const figures = d ? say("away", {force, mm: d[k].toFixed(1)}) : force;
    line.append(dot, `${i === 0 ? say("expert") : name}: ${figures}`);
    return line;
  });
  now.replaceChildren(...lines);
  draw();
}

slider.max = String(time.length - 1);
slider.value = slider.max;
slider.addEventListener("input", show);
canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
canvas.addEventListener("pointermove", (event) => {
  if (event.buttons === 0) return;
  azimuth -= 0.01 * event.movementX;
  height = Math.min(1.57, Math.max(-1.57, height + 0.01 * event.movementY));
  draw();
});
canvas.addEventListener(
  "wheel",
  (event) => {
    event.preventDefault();
    nearer = Math.min(20, Math.max(1, nearer * Math.exp(-0.002 * event.deltaY)));
    draw();
  },
  {passive: false},
);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
new ResizeObserver(draw).observe(canvas);
addEventListener("languagechange", show);
show();
