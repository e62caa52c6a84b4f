import {Pedal} from "../mouse/pedal";
import {element} from "./elements";

/// The pedal, as a button and as a key: Space.
export class PedalButton {
  private readonly button = element("pedal", HTMLButtonElement);
  private readonly pedal = new Pedal(() => {
    this.button.setAttribute("aria-pressed", String(this.pedal.turns));
    this.changed();
  });

  constructor(private readonly changed: () => void) {
    const {button, pedal} = this;
    button.addEventListener("pointerdown", (event) => {
      button.setPointerCapture(event.pointerId);
      pedal.down(event.timeStamp);
    });
    for (const end of ["pointerup", "pointercancel"])
      button.addEventListener(end, ({timeStamp}) => pedal.up(timeStamp));
    button.addEventListener("contextmenu", (event) => event.preventDefault());
    document.addEventListener("keydown", (event) => {
      const {key, target} = event;
      const isFree = target === button || target === document.body;
      if (key !== " " || button.hidden || !(isFree || target instanceof HTMLCanvasElement)) return;
      event.preventDefault();
      pedal.down(event.timeStamp);
    });
    document.addEventListener("keyup", ({key, timeStamp}) => {
      if (key === " ") pedal.up(timeStamp);
    });
    window.addEventListener("blur", () => pedal.off());
  }

  get turns(): boolean {
    return this.pedal.turns;
  }

  /// @param isThere  a bur is held
  show(isThere: boolean): void {
    this.button.hidden = !isThere;
    if (!isThere) this.pedal.off();
  }
}
