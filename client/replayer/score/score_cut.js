// Shows what a trial left, coloured by its distance from the expert's result.  The page defines
// `pictures` before this script.
{
  const canvas = document.getElementById("cut");
  const whose = document.getElementById("whose");
  const plain = document.getElementById("plain");
  const gl = canvas.getContext("webgl2", {antialias: true, preserveDrawingBuffer: true});
  const size = Math.max(...pictures.map(({reach_mm}) => reach_mm));
  let azimuth = 0.5;
  let height = 0.7;
  let nearer = 1.25;

  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
  const vertexShader = `#version 300 es
    uniform vec2 turn, tilt, zoom;
    uniform vec3 middle;
    uniform float reach;
    in vec3 place;
    in float off;
    in vec3 colour;
    out vec3 eye;
    out vec4 shade;
    void main() {
      vec3 p = reach * place + middle;
      float right = p.x * turn.x - p.z * turn.y;
      float near = p.x * turn.y + p.z * turn.x;
      eye = vec3(right, p.y * tilt.x - near * tilt.y, p.y * tilt.y + near * tilt.x);
      shade = vec4(colour, off);
      gl_Position = vec4(zoom * eye.xy, -0.2 * zoom.y * eye.z, 1.0);
    }`;
  const fragmentShader = `#version 300 es
    precision highp float;
    uniform bool plain;
    in vec3 eye;
    in vec4 shade;
    out vec4 pixel;
    void main() {
      vec3 normal = normalize(cross(dFdx(eye), dFdy(eye)));
      float off = plain ? 0.0 : shade.w;
      vec3 far = off > 0.0 ? vec3(0.12, 0.37, 0.82) : vec3(0.78, 0.13, 0.12);
      vec3 colour = mix(shade.rgb, far, smoothstep(0.08, 0.9, abs(off)));
      float light = 0.67 + 0.33 * dot(normal, normalize(vec3(-0.4, 0.7, 0.7)));
      pixel = vec4(colour * light, 1.0);
    }`;

  function shaderOf(kind, source) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    return shader;
  }

  function shapeOf(program, picture) {
    const vao = gl.createVertexArray();
    gl.bindVertexArray(vao);
    for (const [name, text, type, count] of [
      ["place", picture.places, gl.SHORT, 3],
      ["off", picture.off, gl.BYTE, 1],
      ["colour", picture.colours, gl.UNSIGNED_BYTE, 3],
    ]) {
      gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
      gl.bufferData(gl.ARRAY_BUFFER, bytes(text), gl.STATIC_DRAW);
      const at = gl.getAttribLocation(program, name);
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, count, type, true, 0, 0);
    }
    const corners = bytes(picture.corners);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, corners, gl.STATIC_DRAW);
    return {...picture, vao, count: corners.byteLength / 4};
  }

  function begin() {
    const program = gl.createProgram();
    gl.attachShader(program, shaderOf(gl.VERTEX_SHADER, vertexShader));
    gl.attachShader(program, shaderOf(gl.FRAGMENT_SHADER, fragmentShader));
    gl.linkProgram(program);
    gl.useProgram(program);
    gl.enable(gl.DEPTH_TEST);
    const shapes = pictures.map((picture) => shapeOf(program, picture));
    const at = (name) => gl.getUniformLocation(program, name);

    function draw() {
      const scale = window.devicePixelRatio || 1;
      canvas.width = canvas.clientWidth * scale;
      canvas.height = canvas.clientHeight * scale;
      gl.viewport(0, 0, canvas.width, canvas.height);
      gl.clearColor(0, 0, 0, 0);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      const shape = shapes[whose.selectedIndex];
      const middle = shape.middle_mm.map((x, i) => x - shapes[0].middle_mm[i]);
      const zoom = (0.95 * nearer) / size;
      gl.uniform2f(at("turn"), Math.cos(azimuth), Math.sin(azimuth));
      gl.uniform2f(at("tilt"), Math.cos(height), Math.sin(height));
      gl.uniform2f(at("zoom"), (zoom * canvas.height) / canvas.width, zoom);
      gl.uniform3fv(at("middle"), middle);
      gl.uniform1f(at("reach"), shape.reach_mm);
      gl.uniform1i(at("plain"), plain.checked ? 1 : 0);
      gl.bindVertexArray(shape.vao);
      gl.drawElements(gl.TRIANGLES, shape.count, gl.UNSIGNED_INT, 0);
    }

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
        nearer = Math.min(20, Math.max(0.8, nearer * Math.exp(-0.002 * event.deltaY)));
        draw();
      },
      {passive: false},
    );
    whose.addEventListener("change", draw);
    plain.addEventListener("change", draw);
    new ResizeObserver(draw).observe(canvas);
  }

  whose.replaceChildren(...pictures.map(({name}) => new Option(name)));
  whose.selectedIndex = Math.min(1, pictures.length - 1);
  const sayExpert = () => (whose.options[0].text = say("the_expert"));
  addEventListener("languagechange", sayExpert);
  sayExpert();
  if (gl) begin();
  else canvas.replaceWith(say("no_webgl"));
}
