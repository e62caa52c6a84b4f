import type {MouseDevice} from "../mouse/mouse_device";

/// What a pointer does over the picture is the tool's while it is held, and else the eye's.
export function listenToPointer(
  canvas: HTMLCanvasElement,
  mouse: MouseDevice,
  controls: {enabled: boolean}, // the camera's
): void {
  // In the capture phase, before the camera's own listeners.
  const first = {capture: true};
  canvas.addEventListener(
    "pointerdown",
    (event) => {
      const isTools = mouse.pointerDown(event);
      controls.enabled = !isTools;
      if (isTools) canvas.setPointerCapture(event.pointerId);
    },
    first,
  );
  canvas.addEventListener("pointermove", (event) => void mouse.pointerMove(event), first);
  const up = (event: PointerEvent): void => {
    mouse.pointerUp(event);
    controls.enabled = true;
  };
  canvas.addEventListener("pointerup", up);
  canvas.addEventListener("pointercancel", up);
  canvas.addEventListener(
    "wheel",
    (event) => {
      if (mouse.wheel(event)) event.preventDefault();
    },
    {capture: true, passive: false},
  );
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
}
